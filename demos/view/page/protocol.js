// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Decodes the bytes of demos/view/README.md. Independent of page and socket. Lengths m, times s, quaternions x y z w,
// world frame with z up.

export const PROTOCOL = 2;
/** Stands for a peer without a pane here. */
export const ELSEWHERE = -1;
const FRAME = 1;
const KEY = 1;
const OVERLAYS = 2;
const ORIGIN = 0x100000;
const SQRT2 = Math.SQRT2;

/** Received bytes break the protocol. */
export class ProtocolError extends Error {}

/**
 * @typedef {object} Contact
 * @property {number} body      index in hello, of the body that it follows
 * @property {number[]} point   m, world
 * @property {number[]} normal  unit, world
 * @property {number} depth     m, > 0 overlap
 *
 * @typedef {object} Spring
 * @property {number} body          index in hello
 * @property {number[]} anchor      m, world: the target
 * @property {number[]} attachment  m, world: the held point
 * @property {number} user          index in hello of the user's peer, or ELSEWHERE
 * @property {boolean} own          of this peer's own user
 *
 * @typedef {object} Target
 * @property {number} body        index in hello
 * @property {number} peer        index in hello, or ELSEWHERE
 * @property {number[]} position  m, world: the body's estimated position at that peer
 *
 * @typedef {object} Overlays
 * @property {Contact[]} contacts
 * @property {Target[]} targets
 * @property {Uint8Array} influence  [bodies], this peer's share, 0..255 = 0..1
 *
 * @typedef {object} PeerFrame
 * @property {number} stepMs            ms, duration of the last step
 * @property {number} latencyMs         ms, mean age of the others' updates
 * @property {number} divergenceP50Mm   mm, NaN: unknown
 * @property {number} divergenceMaxMm   mm, NaN: unknown
 * @property {Float32Array} positions     [3 * bodies] m, world; kept from frame to frame
 * @property {Float32Array} orientations  [4 * bodies] x y z w, body to world; kept too
 * @property {number} changed             number of bodies with a record
 * @property {Spring[]} springs
 * @property {?Overlays} overlays
 *
 * @typedef {object} Frame
 * @property {number} number  of the frame
 * @property {number} time    s, session time
 * @property {boolean} key    every body was in it
 * @property {PeerFrame[]} peers  as in hello; without a second run's if there is none
 */

/** A reader that reports the offset of a premature end. */
class Reader {
  constructor(buffer) {
    this.view = new DataView(buffer);
    this.at = 0;
  }
  need(bytes) {
    const at = this.at;
    if (at + bytes > this.view.byteLength) {
      throw new ProtocolError(`frame ends at byte ${this.view.byteLength}, needs ${at + bytes}`);
    }
    this.at += bytes;
    return at;
  }
  u8() { return this.view.getUint8(this.need(1)); }
  u16() { return this.view.getUint16(this.need(2), true); }
  u32() { return this.view.getUint32(this.need(4), true); }
  f32() { return this.view.getFloat32(this.need(4), true); }
  f64() { return this.view.getFloat64(this.need(8), true); }
  vec3() { return [this.f32(), this.f32(), this.f32()]; }
}

/**
 * Unpacks a quaternion of 32 bits, smallest three.
 * @param {number} bits  u32
 * @param {Float32Array} out  x y z w are written to out[at..at+3], normalised
 * @param {number} at
 */
export function unpackQuaternion(bits, out, at) {
  const left = bits >>> 30;
  let sum = 0;
  let shift = 0;
  for (let i = 0; i < 4; ++i) {
    if (i === left) continue;
    const value = (((bits >>> shift) & 0x3ff) - 511) / 511 / SQRT2;
    out[at + i] = value;
    sum += value * value;
    shift += 10;
  }
  out[at + left] = Math.sqrt(Math.max(0, 1 - sum));
  // Invalid values would give a length above 1.
  if (sum > 1) {
    const scale = 1 / Math.sqrt(sum);
    for (let i = 0; i < 4; ++i) out[at + i] *= scale;
  }
}

/**
 * Unpacks a position.
 * @param {number} lo    u32
 * @param {number} hi    u32
 * @param {number} unit  m
 * @param {Float32Array} out  x y z in m are written to out[at..at+2]
 * @param {number} at
 */
export function unpackPosition(lo, hi, unit, out, at) {
  out[at] = ((lo & 0x1fffff) - ORIGIN) * unit;
  out[at + 1] = (((lo >>> 21) | ((hi & 0x3ff) << 11)) - ORIGIN) * unit;
  out[at + 2] = (((hi >>> 10) & 0x1fffff) - ORIGIN) * unit;
}

/** Reads a count (u16) and as many elements. */
function list(reader, read) {
  return Array.from({length: reader.u16()}, read);
}

/** Decodes the frames of one connection; keeps the poses of bodies that a frame leaves out. */
export class FrameDecoder {
  /** @param {object} hello  the server's first message */
  constructor(hello) {
    this.bodies = hello.bodies.length;
    this.unit = hello.position_unit;
    this.peers = hello.peers.map(() => ({
      stepMs: NaN, latencyMs: NaN, divergenceP50Mm: NaN, divergenceMaxMm: NaN,
      positions: new Float32Array(3 * this.bodies),
      orientations: Float32Array.from({length: 4 * this.bodies}, (_, i) => Number(i % 4 === 3)),
      changed: 0, springs: [], overlays: null,
    }));
  }

  /**
   * @param {ArrayBuffer} buffer
   * @returns {Frame}  its arrays are the decoder's own and change with the next frame
   * @throws {ProtocolError}  if the bytes are not a frame; poses may be partly overwritten, until
   *   the next key frame
   */
  decode(buffer) {
    const reader = new Reader(buffer);
    const kind = reader.u8();
    if (kind !== FRAME) throw new ProtocolError(`kind ${kind} is not known`);
    const flags = reader.u8();
    const peers = reader.u16();
    if (peers < 1 || peers > this.peers.length) {
      throw new ProtocolError(`${peers} peers in a frame, ${this.peers.length} in hello`);
    }
    const frame = {number: reader.u32(), time: reader.f64(), key: (flags & KEY) !== 0,
                   peers: this.peers.slice(0, peers)};
    for (const peer of frame.peers) this.decodePeer(reader, peer, (flags & OVERLAYS) !== 0);
    if (reader.at !== buffer.byteLength) {
      throw new ProtocolError(`${buffer.byteLength - reader.at} bytes after the frame`);
    }
    return frame;
  }

  decodePeer(reader, peer, overlays) {
    peer.stepMs = reader.f32();
    peer.latencyMs = reader.f32();
    peer.divergenceP50Mm = reader.f32();
    peer.divergenceMaxMm = reader.f32();
    const mask = reader.need((this.bodies + 7) >> 3);
    peer.changed = 0;
    for (let body = 0; body < this.bodies; ++body) {
      if (!((reader.view.getUint8(mask + (body >> 3)) >> (body & 7)) & 1)) continue;
      const lo = reader.u32();
      const hi = reader.u32();
      unpackPosition(lo, hi, this.unit, peer.positions, 3 * body);
      if (hi >>> 31) unpackQuaternion(reader.u32(), peer.orientations, 4 * body);
      ++peer.changed;
    }
    const known = (mark) => mark.body < this.bodies;
    peer.springs = list(reader, () => (
      {body: reader.u16(), anchor: reader.vec3(), attachment: reader.vec3(),
       user: this.peerOf(reader.u8()), own: reader.u8() === 1})).filter(known);
    peer.overlays = overlays ? this.decodeOverlays(reader, known) : null;
  }

  decodeOverlays(reader, known) {
    const contacts = list(reader, () => (
      {body: reader.u16(), point: reader.vec3(), normal: reader.vec3(), depth: reader.f32()}));
    const targets = list(reader, () => (
      {body: reader.u16(), peer: this.peerOf(reader.u16()), position: reader.vec3()}));
    const at = reader.need(this.bodies);
    const influence = new Uint8Array(reader.view.buffer.slice(at, at + this.bodies));
    return {contacts: contacts.filter(known), targets: targets.filter(known), influence};
  }

  peerOf(index) {
    return index < this.peers.length ? index : ELSEWHERE;
  }
}
