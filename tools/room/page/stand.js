// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Position of the headset's floor in the room, and the only conversion between its frame (y up) and the room's (z up).
import {minus, plus, product, rotated, toWorld} from './poses.js';

const UPRIGHT = [Math.SQRT1_2, 0, 0, Math.SQRT1_2];  // y up to z up
const FAR = 10;        // m from the room's middle
const SPEED = 6;       // m/s, of the aiming throw
const GRAVITY = 9.81;  // m/s²
const LONGEST = 2;     // s

const about = (yaw) => [0, 0, Math.sin(yaw / 2), Math.cos(yaw / 2)];
const within = (x) => Math.min(FAR, Math.max(-FAR, x));

export class Stand {
  constructor() {
    this.position = [0, 0, 0];  // m, world
    this.yaw = 0;               // rad; 0 looks along +y
  }
  get orientation() { return product(about(this.yaw), UPRIGHT); }
  /** A pose of the headset's frame in the world. @param {XRRigidTransform} transform */
  pose({position: p, orientation: q}) {
    return {position: toWorld(this, [p.x, p.y, p.z]), orientation: product(this.orientation, [q.x, q.y, q.z, q.w])};
  }
  /** Moves the head above a point. @param {number[]} head  m, world: its present position */
  jump([x, y], head) {
    this.position = [this.position[0] + within(x) - head[0], this.position[1] + within(y) - head[1], 0];
  }
  /** Turns about the head. @param {number} angle  rad, to the left */
  turn(angle, head) {
    const foot = [head[0], head[1], 0];
    this.position = plus(foot, rotated(about(angle), minus(this.position, foot)));
    this.yaw += angle;
  }
}

/** The point where a throw along -z of this pose meets the floor, m; null if it is too far. */
export function landing({position, orientation}) {
  const speed = rotated(orientation, [0, 0, -SPEED]);
  const time = (speed[2] + Math.sqrt(speed[2] ** 2 + 2 * GRAVITY * Math.max(0, position[2]))) / GRAVITY;
  return time <= LONGEST ? [position[0] + speed[0] * time, position[1] + speed[1] * time] : null;
}
