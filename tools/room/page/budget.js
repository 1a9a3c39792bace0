// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Reduces a headset's picture quality, permanently, if pictures take longer than a frame of the display or delay the
// world's steps.

const USUAL_HZ = 72;
const LONGER = 1.25;     // of the display's frame: every fourth picture is missed
const SHARE = 0.05;      // weight of a new value in the mean
const SETTLING = 45;     // pictures
const LATE_MS = 16;      // a step
const PAUSED_MS = 500;   // longer is no picture's time
/** Ascending. scale: of the picture's width and height. */
const LEVELS = [
  {shadows: false, plain: true, scale: 0.5},
  {shadows: false, plain: true, scale: 0.75},
  {shadows: false, plain: true, scale: 1},
  {shadows: false, plain: false, scale: 1},
  {shadows: true, plain: false, scale: 1},
];
const PLAIN = 2;

export class Budget {
  #mean = 1;        // time per picture over the display's
  #last = null;     // ms
  #settled = 0;     // pictures at this level
  #level;

  /** @param {boolean} plain  software rendering */
  constructor(plain = false) {
    this.#level = plain ? PLAIN : LEVELS.length - 1;
  }
  get level() { return LEVELS[this.#level]; }

  /**
   * Call before each picture.
   * @param {number} now  ms @param {number} late  ms, of steps @param {?number} hz  of the display
   * @returns {boolean}  whether the level changed
   */
  took(now, late, hz) {
    const interval = this.#last === null ? 0 : now - this.#last;
    this.#last = now;
    if (interval <= 0 || interval > PAUSED_MS) return false;
    this.#mean += SHARE * (interval * (hz || USUAL_HZ) / 1000 - this.#mean);
    ++this.#settled;
    const over = this.#mean > LONGER || late > LATE_MS;
    if (!over || this.#settled < SETTLING || this.#level === 0) return false;
    --this.#level;
    this.#settled = 0;
    this.#mean = 1;
    return true;
  }
}
