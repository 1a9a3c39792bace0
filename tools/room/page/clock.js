// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Session time: the server's, as the quickest answers have it, carried on by the page's own clock, so that it goes on
// where the server does not.

const MOST_SLEW = 1;  // ms each answer, once it is known well
const FIRST = 3;      // answers, before which it is not known
const SETTLED = 20;   // answers, up to which a quicker one sets it

export class Clock {
  #offset = null;
  #best = Infinity;
  #answers = 0;

  /** An answer has come. @param sent  ms, performance.now() when it was asked @param server  ms since 1970 */
  take(sent, server) {
    const roundTrip = performance.now() - sent;
    if (!(roundTrip >= 0) || !Number.isFinite(server)) return;
    const offset = server - (sent + roundTrip / 2);
    ++this.#answers;
    if (this.#offset === null || (this.#answers <= SETTLED && roundTrip <= this.#best)) {
      this.#offset = offset;
    } else if (this.#answers > SETTLED && roundTrip < 2 * this.#best + 1) {
      this.#offset += Math.min(MOST_SLEW, Math.max(-MOST_SLEW, offset - this.#offset));
    }
    this.#best = Math.min(this.#best, roundTrip);
  }
  get known() { return this.#answers >= FIRST; }
  get settled() { return this.#answers >= SETTLED; }
  /** ms since 1970. */
  now() { return performance.now() + this.#offset; }
}
