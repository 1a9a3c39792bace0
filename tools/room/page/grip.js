// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A headset's hand: it holds a pose rather than a point, by three springs around its palm (docs/hands.md).
import {distance, mixed, poseOf, toLocal, toWorld} from './poses.js';

const SPRINGS = 3;
const RADIUS = 0.04;       // m, of the springs around the hand
const GRAVITY = 9.81;      // m/s²
const SAG = 0.01;          // m, under the full load
const STRENGTH = 4;        // times the load's weight
const DAMPING = 1.4;       // twice the damping ratio
const LOST = 0.4;          // m, stretch at which it releases
const KEPT = 16;           // tracked poses

const AROUND = Array.from({length: SPRINGS}, (_, i) => {
  const angle = 2 * Math.PI * i / SPRINGS;
  return [RADIUS * Math.cos(angle), RADIUS * Math.sin(angle), 0];
});

export class Grip {
  #springs = [];   // ids, in the order of AROUND
  #attachments;    // m, frame of the body
  #tracked = [];   // {time: ms of session time, pose}, newest last
  #hands = 1;

  /** @param {{name: string, body: object, mass: number}} held @param {object} pose  of the hand, world */
  constructor(held, pose) {
    this.held = held;
    this.pose = pose;
    const body = poseOf(held.body);
    this.attachment = toLocal(body, pose.position);  // m, frame of the body: the centre of the palm
    this.#attachments = AROUND.map((p) => toLocal(body, toWorld(pose, p)));
  }
  /** m, world: the target. */
  get anchor() { return this.pose.position; }
  /** True if the body stays too far behind, at a wall or in others' hands. */
  get lost() { return distance(this.anchor, toWorld(poseOf(this.held.body), this.attachment)) > LOST; }

  /** Tracks the hand. @param {number} time  ms of session time */
  track(time, pose) {
    this.#tracked.push({time, pose});
    if (this.#tracked.length > KEPT) this.#tracked.shift();
  }
  /** Sets the number of this user's hands on the body, which share its load. */
  share(hands, peer) {
    if (hands === this.#hands) return;
    this.#hands = hands;
    this.release(peer);  // reattached with new springs before the next step
  }
  /** Call before each step. @param {object} peer @param {bigint} now  ns, session time */
  update(peer, now) {
    this.pose = this.#at(Number(now) / 1e6) ?? this.pose;
    const anchors = AROUND.map((p) => toWorld(this.pose, p));
    if (this.#springs.length > 0) return this.#springs.forEach((spring, i) => peer.move(spring, anchors[i], now));
    const load = this.held.mass / this.#hands;
    const weight = GRAVITY * load;
    const stiffness = weight / SAG;
    this.#springs = anchors.map((anchor, i) => peer.grab(this.held.name, {
      attachment: this.#attachments[i], anchor, stiffness: stiffness / SPRINGS, maxForce: STRENGTH * weight / SPRINGS,
      damping: DAMPING * Math.sqrt(stiffness * load) / SPRINGS,
    }));
  }
  release(peer) {
    for (const spring of this.#springs) peer.release(spring);
    this.#springs = [];
  }

  /** Interpolates tracked poses: with the newest alone uniform motion would become uneven. */
  #at(time) {
    const after = this.#tracked.findIndex((one) => one.time >= time);
    if (after < 0) return this.#tracked.at(-1)?.pose;
    if (after === 0) return this.#tracked[0].pose;
    const [a, b] = [this.#tracked[after - 1], this.#tracked[after]];
    return b.time > a.time ? mixed(a.pose, b.pose, (time - a.time) / (b.time - a.time)) : b.pose;
  }
}
