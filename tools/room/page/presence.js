// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Members' messages about heads and hands (tools/room/README.md, channel 4). Untrusted: malformed, non-finite, distant or too
// frequent ones are dropped and counted.
import {mixed} from './poses.js';

const POINTER_BYTES = 24;   // anchor (world) and attachment (body), f32; the body's name follows
const MOST_NAME = 64;       // bytes
/** NaN as an f32: older members that know only pointers drop it. */
const HEADSET = 0x7fc00001;
const HEADSET_BYTES = 5;    // the mark and a bit set of the following parts
const POSE_BYTES = 28;      // position and quaternion, f32
const HEAD = 1;
const SIDES = [{side: 'left', there: 2, holds: 8}, {side: 'right', there: 4, holds: 16}];
const ALL_BITS = 31;
const FAR = 20;             // m from the room's middle, by coordinate
const LARGEST = 4;          // m, from the centre of the held body
const UNIT = 0.01;          // tolerance of a quaternion's length
const EACH_SECOND = 30;     // messages per member; pages and native peers send 20
const FOR_MS = 1000;
const BLEND_MS = 60;        // between messages

export class Malformed extends Error {}
const rule = (holds) => { if (!holds) throw new Malformed(); };

/** @param {{held: object, anchor: number[], attachment: number[]}} hand */
export function encodePointer({held, anchor, attachment}) {
  const places = new Uint8Array(new Float32Array([...anchor, ...attachment]).buffer);
  return new Uint8Array([...places, ...new TextEncoder().encode(held.name)]);
}
/** @param {{head: ?object, left: ?object, right: ?object}} seen  poses @param {Map} holding  grips by side */
export function encodeHeadset(seen, holding) {
  const bytes = [];
  const floats = (values) => bytes.push(...new Uint8Array(new Float32Array(values).buffer));
  let bits = 0;
  const tell = (bit, pose) => {
    bits |= bit;
    floats([...pose.position, ...pose.orientation]);
  };
  if (seen.head) tell(HEAD, seen.head);
  for (const {side, there, holds} of SIDES) {
    if (!seen[side]) continue;
    tell(there, seen[side]);
    const grip = holding.get(side);
    const name = grip && new TextEncoder().encode(grip.held.name);
    if (!name || name.length > MOST_NAME) continue;
    bits |= holds;
    floats(grip.attachment);
    bytes.push(name.length, ...name);
  }
  return new Uint8Array([...new Uint8Array(new Uint32Array([HEADSET]).buffer), bits, ...bytes]);
}

/** Sequential reader; missing data or a broken rule throws Malformed. */
class Reader {
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
    this.at = 0;
  }
  skip(count) {
    rule(this.at + count <= this.bytes.length);
    this.at += count;
    return this.at - count;
  }
  floats(count, most) {
    const at = this.skip(4 * count);
    const values = Array.from({length: count}, (_, i) => this.view.getFloat32(at + 4 * i, true));
    rule(values.every((x) => Math.abs(x) <= most));  // also false for NaN
    return values;
  }
  pose() {
    const position = this.floats(3, FAR);
    const orientation = this.floats(4, 2);
    const length = Math.hypot(...orientation);
    rule(Math.abs(length - 1) <= UNIT);
    return {position, orientation: orientation.map((x) => x / length)};
  }
  name(count) {
    const at = this.skip(count);
    return new TextDecoder().decode(this.bytes.subarray(at, at + count));
  }
}

/** @param {Uint8Array} bytes @param {function(string): ?object} find  a body @throws {Malformed} */
export function decode(bytes, find) {
  const found = (name) => {
    const held = find(name);
    return held?.mass > 0 ? held : null;
  };
  const reader = new Reader(bytes);
  rule(bytes.length >= HEADSET_BYTES);
  if (reader.view.getUint32(0, true) !== HEADSET) {
    const anchor = reader.floats(3, FAR);
    const attachment = reader.floats(3, LARGEST);
    rule(bytes.length <= POINTER_BYTES + MOST_NAME);
    const held = found(reader.name(bytes.length - POINTER_BYTES));
    rule(held);
    return {pointer: {held, anchor, attachment}};
  }
  reader.skip(4);
  const bits = bytes[reader.skip(1)];
  rule((bits & ~ALL_BITS) === 0);
  const said = {head: bits & HEAD ? reader.pose() : null};
  for (const {side, there, holds} of SIDES) {
    rule(bits & there || !(bits & holds));
    if (!(bits & there)) continue;
    said[side] = {pose: reader.pose()};
    if (!(bits & holds)) continue;
    said[side].attachment = reader.floats(3, LARGEST);
    const length = bytes[reader.skip(1)];
    rule(length <= MOST_NAME);
    // A body that is unknown here: the hand is shown without it.
    said[side].held = found(reader.name(length));
  }
  rule(reader.at === bytes.length);
  return said;
}

/** The others' latest messages. */
export class Presence {
  #said = new Map();   // by member: decode()'s result, with `at`, ms, and `before`, the poses shown on arrival
  #credit = new Map(); // by member: {left: messages, at: ms}
  refused = 0;

  /** @param {function(string): ?object} find  a body by its name */
  constructor(find) { this.find = find; }

  hear(id, bytes, now = performance.now()) {
    if (!this.#allowed(id, now)) return void ++this.refused;
    if (bytes.length === 0) return void this.#said.delete(id);
    try {
      const said = decode(bytes, this.find);
      this.#said.set(id, {...said, at: now, before: this.person(id, now)});
    } catch (problem) {
      if (!(problem instanceof Malformed)) throw problem;
      ++this.refused;
    }
  }
  forget(id) {
    this.#said.delete(id);
    this.#credit.delete(id);
  }
  /** A holding pointer: {held, anchor, attachment}. */
  pointer(id, now = performance.now()) { return this.#lately(id, now)?.pointer ?? null; }
  /** A headset's user, smoothed: {head, left, right}, hands as {pose, held, attachment}. */
  person(id, now = performance.now()) {
    const said = this.#lately(id, now);
    if (!said || said.pointer) return null;
    const part = Math.min(1, (now - said.at) / BLEND_MS);
    const shown = (from, to) => (from && to ? mixed(from, to, part) : to);
    const hand = (side) => said[side] && {...said[side], pose: shown(said.before?.[side]?.pose, said[side].pose)};
    return {head: shown(said.before?.head, said.head), left: hand('left'), right: hand('right')};
  }
  #lately(id, now) {
    const said = this.#said.get(id);
    return said && now - said.at < FOR_MS ? said : null;
  }
  #allowed(id, now) {
    const credit = this.#credit.get(id) ?? {left: EACH_SECOND, at: now};
    credit.left = Math.min(EACH_SECOND, credit.left + EACH_SECOND * (now - credit.at) / 1000);
    credit.at = now;
    this.#credit.set(id, credit);
    if (credit.left < 1) return false;
    --credit.left;
    return true;
  }
}
