// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The room's bodies, from its file and made by members; their recent positions, and the divergence from those of
// others.
import {STATE, World, shapeMass, sharedId} from './tandem.js';

export const STEP_MS = 16666667e-6;  // of session time
const DT = 1 / 60;                   // s
const REMEMBERED = 120;              // steps
const MOST_BODIES = 320;
const MADE = {density: 300, linearDamping: 0.3, angularDamping: 2};
const DIGEST_BODY = 20;              // bytes
const LATE_MS = 1000;
/** Result of compare(): the own world has not reached that time. */
export const WAIT = Symbol('wait');

const within = (value, low, high) => typeof value === 'number' && value >= low && value <= high;

/** Bodies that members may make: one shape of 3 cm to 1 m, near the centre. Native peers have the same rule. */
export function mayBeMade(body) {
  if (body === null || typeof body !== 'object' || Object.keys(body).length !== 3) return false;
  const {name, shape, position} = body;
  if (typeof name !== 'string' || name.length > 64 || !name.startsWith('made/')) return false;
  if (!Array.isArray(position) || position.length !== 3) return false;
  if (!position.every((x, i) => within(x, i === 2 ? 0 : -10, 10))) return false;
  if (shape === null || typeof shape !== 'object') return false;
  if (shape.type === 'sphere') return within(shape.radius, 0.03, 0.5);
  return shape.type === 'box' && Array.isArray(shape.halfExtents) && shape.halfExtents.length === 3 &&
    shape.halfExtents.every((x) => within(x, 0.015, 0.5));
}

function summary(values) {
  if (values.length === 0) return null;
  values.sort((a, b) => a - b);
  return {typical: values[values.length >> 1], most: values[values.length - 1]};
}

export class RoomWorld {
  #ids = new Map();   // upper half of a shared id: row
  #past = [];         // of the last steps: {time: ms, states}
  #shown = new Float64Array(0);

  /** @param {object} room  its file */
  constructor(room) {
    this.room = room;
    this.world = new World();
    this.bodies = [];  // {name, body, mass, def}, by row of states
    this.made = [];    // bodies made by members
    for (const def of room.bodies) this.#add(def);
  }

  #add(def) {
    const {name, colour, parts = [], ...solid} = def;
    const body = this.world.addBody(solid);
    for (const part of parts) {
      this.world.addCollider(body, {...part, friction: def.friction, restitution: def.restitution});
    }
    const moves = def.type !== 'static';
    const mass = moves ? def.mass ?? shapeMass(def.shape, def.density).mass : 0;
    const added = {name, body, mass, def};
    this.bodies.push(added);
    if (moves) this.#ids.set(sharedId(name).high, body.row);
    return added;
  }
  find(name) { return this.bodies.find((one) => one.name === name); }
  /** Null if it is not allowed, or exists already. @param {object} def  untrusted */
  make(def) {
    if (!mayBeMade(def) || this.bodies.length >= MOST_BODIES || this.find(def.name)) return null;
    const added = this.#add({...def, ...MADE});
    this.made.push(def);
    return added;
  }

  step() { this.world.step(DT); }
  /** Stores the states. @param {number} time  ms, session time after the step */
  remember(time) {
    const old = this.#past.length >= REMEMBERED ? this.#past.shift() : null;
    const states = this.world.states;
    const kept = old?.states.length === states.length ? old.states : new Float64Array(states.length);
    kept.set(states);
    this.#past.push({time, states: kept});
  }
  forget() { this.#past = []; }
  /**
   * Poses between the last two steps, as `states`; without velocities. @param {number} part  fraction of a step,
   * clamped to 0 to 1
   */
  between(part) {
    const [before, last] = this.#past.slice(-2).map(({states}) => states);
    const {states} = this.world;
    if (!last || before.length !== last.length || last.length !== states.length) return states;
    const share = Math.min(1, Math.max(0, part));
    if (this.#shown.length !== last.length) this.#shown = new Float64Array(last.length);
    const shown = this.#shown;
    for (let at = 0; at < last.length; at += STATE) {
      for (let k = 0; k < 3; ++k) shown[at + k] = before[at + k] + share * (last[at + k] - before[at + k]);
      let dot = 0;
      for (let k = 3; k < 7; ++k) dot += before[at + k] * last[at + k];
      let square = 0;
      for (let k = 3; k < 7; ++k) {
        const from = dot < 0 ? -before[at + k] : before[at + k];
        shown[at + k] = from + share * (last[at + k] - from);
        square += shown[at + k] ** 2;
      }
      for (let k = 3; k < 7; ++k) shown[at + k] /= Math.sqrt(square);
    }
    return this.#shown;
  }

  /** Session time, ns, then the upper half of the id and the position of each body. @param {bigint} time */
  digest(time) {
    const view = new DataView(new ArrayBuffer(8 + DIGEST_BODY * this.#ids.size));
    view.setBigUint64(0, time, true);
    let at = 8;
    for (const [id, row] of this.#ids) {
      view.setBigUint64(at, id, true);
      for (let k = 0; k < 3; ++k) view.setFloat32(at + 8 + 4 * k, this.world.states[row * STATE + k], true);
      at += DIGEST_BODY;
    }
    return new Uint8Array(view.buffer);
  }
  /**
   * Distance of another's bodies from the own ones, at its time.
   * @param {Uint8Array} bytes  untrusted
   * @returns {?{typical: number, most: number}|symbol}  m; null if that time is unknown here, WAIT: not yet
   */
  compare(bytes) {
    if (bytes.length < 8 || (bytes.length - 8) % DIGEST_BODY !== 0) return null;
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
    const time = Number(view.getBigUint64(0, true)) / 1e6;
    const after = this.#past.findIndex((one) => one.time >= time - 1e-3);
    if (after < 0) return time - (this.#past.at(-1)?.time ?? 0) < LATE_MS ? WAIT : null;
    if (after === 0 && this.#past[0].time > time + 1e-3) return null;
    const last = this.#past[after];
    const first = this.#past[Math.max(0, after - 1)];
    const part = last.time > first.time ? Math.min(1, (time - first.time) / (last.time - first.time)) : 1;
    const apart = [];
    for (let at = 8; at < bytes.length; at += DIGEST_BODY) {
      const row = this.#ids.get(view.getBigUint64(at, true));
      if (row === undefined || row * STATE + 3 > first.states.length) continue;
      let square = 0;
      for (let k = 0; k < 3; ++k) {
        const a = first.states[row * STATE + k];
        const own = a + part * (last.states[row * STATE + k] - a);
        square += (view.getFloat32(at + 8 + 4 * k, true) - own) ** 2;
      }
      if (Number.isFinite(square)) apart.push(Math.sqrt(square));
    }
    return summary(apart);
  }
}
