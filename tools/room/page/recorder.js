// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Records this page's hand, in memory from one press of its button to the next, then as a file on the user's disk. The
// format is in docs/hands.md.

const LONGEST = 600;  // s
const RATE = 60;      // steps of the page per second
const TELL_MS = 500;

// To 0.1 ms, and 0.1 mm.
const short = (value) => String(Number(value.toFixed(4)));
const point = (values) => values.map(short).join(' ');
// Names of members' bodies contain their maker. Printable characters, as the format requires.
const nameOf = (name) => (name.startsWith('made/') ? 'made' : name.replace(/[^!-~]/g, '_').slice(0, 64));

export class Recorder {
  #lines = [];
  #first = null;  // ms, session time of the first step
  #hand = null;   // of the last step

  /** @param {string} room  its name */
  constructor(room) {
    this.seconds = 0;
    this.#lines.push('tandem-hand 1', `room ${room}`, `rate ${RATE}`);
  }
  get full() { return this.seconds >= LONGEST; }
  /** Call at each step. @param {number} time  ms, grows @param {?object} hand  wanted, held, attachment */
  step(time, hand) {
    this.#first ??= time;
    this.seconds = Math.min(LONGEST, (time - this.#first) / 1000);
    if (this.full) hand = null;
    if (this.#hand && hand !== this.#hand) this.#say('let');
    if (hand && hand !== this.#hand) {
      this.#say(`grab ${nameOf(hand.held.name)} ${point(hand.attachment)} ${point(hand.wanted)}`);
    } else if (hand) {
      this.#say(`move ${point(hand.wanted)}`);
    }
    this.#hand = hand;
  }
  /** The file's text; clears the record. */
  end() {
    this.step(1000 * this.seconds + (this.#first ?? 0), null);
    this.#say('end');
    return `${this.#lines.join('\n')}\n`;
  }
  #say(what) { this.#lines.push(`${short(this.seconds)} ${what}`); }
}

function download(text, name) {
  const url = URL.createObjectURL(new Blob([text], {type: 'text/plain'}));
  const way = document.createElement('a');
  Object.assign(way, {href: url, download: name});
  way.click();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

/** The button #record. @param {object} session @param {string} room  its name */
export function offerRecording(session, room) {
  const button = document.getElementById('record');
  let recorder = null;
  let telling = 0;
  const tell = () => {
    if (!recorder) return;
    button.textContent = recorder.full ? 'Full: save my hand' : `Save my hand (${recorder.seconds.toFixed(0)} s)`;
  };
  button.onclick = () => {
    const done = recorder;
    recorder = done ? null : new Recorder(room);
    session.onHand = recorder ? recorder.step.bind(recorder) : () => {};
    button.setAttribute('aria-pressed', String(recorder !== null));
    clearInterval(telling);
    if (recorder) telling = setInterval(tell, TELL_MS);
    tell();
    if (!done) return;
    button.textContent = 'Record my hand';
    download(done.end(), `hand-${room}.txt`);
  };
}
