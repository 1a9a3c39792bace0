// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Session time: the server's, from its quickest answers, continued by the page's own clock, which also bridges an
// outage of the server.

const MOST_SLEW = 1;  // ms per answer, once it is settled
const FIRST = 3;      // answers before it is known
const SETTLED = 20;   // answers, up to which a quicker one sets it

export class Clock {
  #offset = null;
  #best = Infinity;
  #answers = 0;

  /** Takes an answer. @param sent  ms, performance.now() of the question @param server  ms since 1970 */
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
