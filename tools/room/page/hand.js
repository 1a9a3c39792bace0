// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A hand that holds a body by a spring: at most four times its weight, 2 m/s fast and 10 cm from the held point, so
// that a long pull tows instead of throwing. A pointer moves in steps, which other peers would extrapolate: the hand
// follows it as by a critically damped spring.
import {minus, plus, poseOf, shortened, toWorld} from './poses.js';

const SMOOTH = 0.03;      // s
const FASTEST = 2;        // m/s
const REACH = 0.1;        // m
const FORCE = 40;         // N/kg
const FULL_AT = 0.04;     // m, stretch at maximum force
const DAMPING_RATIO = 0.7;
const DT = 1 / 60;        // s
const LEFT = Math.exp(-DT / SMOOTH);

export class Hand {
  #grab = null;

  /** @param {{name: string, body: object, mass: number}} held @param {number[]} attachment  m, frame of the body */
  constructor(held, attachment) {
    Object.assign(this, {held, attachment});
    this.anchor = this.point;
    this.wanted = this.anchor;
    this.smooth = this.anchor;             // m, world: `wanted`, smoothed
    this.velocity = [0, 0, 0];             // m/s, of `smooth`
  }
  /** m, world: the held point. */
  get point() { return toWorld(poseOf(this.held.body), this.attachment); }
  /** Call before each step. @param {object} peer @param {bigint} now */
  update(peer, now) {
    this.#follow();
    this.anchor = plus(this.anchor, shortened(minus(this.smooth, this.anchor), FASTEST * DT));
    this.anchor = plus(this.point, shortened(minus(this.anchor, this.point), REACH));
    if (this.#grab !== null) return peer.move(this.#grab, this.anchor, now);
    const maxForce = FORCE * this.held.mass;
    const stiffness = maxForce / FULL_AT;
    this.#grab = peer.grab(this.held.name, {
      attachment: this.attachment, anchor: this.anchor, stiffness, maxForce,
      damping: 2 * DAMPING_RATIO * Math.sqrt(stiffness * this.held.mass),
    });
  }
  /** The spring's exact motion over a step. */
  #follow() {
    const behind = minus(this.smooth, this.wanted);
    const drift = behind.map((x, i) => (this.velocity[i] + x / SMOOTH) * DT);
    this.velocity = drift.map((x, i) => LEFT * (this.velocity[i] - x / SMOOTH));
    this.smooth = this.wanted.map((x, i) => x + LEFT * (behind[i] + drift[i]));
  }
  release(peer) {
    if (this.#grab !== null) peer.release(this.#grab);
    this.#grab = null;
  }
}
