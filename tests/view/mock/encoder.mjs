// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Frames of demos/view/README.md from values: the other side of demos/view/page/protocol.js, for the mock
// server and for tests.

const SQRT2 = Math.SQRT2;

/** @param {number[]} q  x y z w, unit @returns {number}  u32, smallest three */
export function packQuaternion(q) {
  let left = 0;
  for (let i = 1; i < 4; ++i) if (Math.abs(q[i]) > Math.abs(q[left])) left = i;
  const sign = q[left] < 0 ? -1 : 1;
  let bits = left * 2 ** 30;
  let shift = 0;
  for (let i = 0; i < 4; ++i) {
    if (i === left) continue;
    bits += Math.round(sign * q[i] * SQRT2 * 511 + 511) * 2 ** shift;
    shift += 10;
  }
  return bits;
}

/** @param {number[]} p  m @param {number} unit  m @param {boolean} turned @returns {number[]} */
export function packPosition(p, unit, turned) {
  const [x, y, z] = p.map((v) => Math.round(v / unit) + 0x100000);
  return [(x | (y << 21)) >>> 0,
          (((y >>> 11) | (z << 10)) & 0x7fffffff) + (turned ? 2 ** 31 : 0)];
}

/** Bytes that grow. */
class Writer {
  constructor() {
    this.view = new DataView(new ArrayBuffer(1 << 20));
    this.at = 0;
  }
  u8(v) { this.view.setUint8(this.at, v); this.at += 1; }
  u16(v) { this.view.setUint16(this.at, v, true); this.at += 2; }
  u32(v) { this.view.setUint32(this.at, v, true); this.at += 4; }
  f32(...vs) { for (const v of vs) { this.view.setFloat32(this.at, v, true); this.at += 4; } }
  f64(v) { this.view.setFloat64(this.at, v, true); this.at += 8; }
}

/**
 * @param {{number: number, time: number, key: boolean, unit: number, peers: object[]}} frame
 *   a peer: stepMs, latencyMs, divergenceP50Mm, divergenceMaxMm, bodies [{position, quaternion}]
 *   (null: no record; quaternion null: not told), springs, overlays (null where no peer has them)
 * @returns {Uint8Array}
 */
export function encodeFrame(frame) {
  const out = new Writer();
  const overlays = frame.peers.some((peer) => peer.overlays);
  out.u8(1);
  out.u8((frame.key ? 1 : 0) | (overlays ? 2 : 0));
  out.u16(frame.peers.length);
  out.u32(frame.number);
  out.f64(frame.time);
  for (const peer of frame.peers) {
    out.f32(peer.stepMs, peer.latencyMs, peer.divergenceP50Mm, peer.divergenceMaxMm);
    const mask = new Uint8Array((peer.bodies.length + 7) >> 3);
    peer.bodies.forEach((body, b) => { if (body) mask[b >> 3] |= 1 << (b & 7); });
    mask.forEach((byte) => out.u8(byte));
    for (const body of peer.bodies) {
      if (!body) continue;
      packPosition(body.position, frame.unit, Boolean(body.quaternion)).forEach((v) => out.u32(v));
      if (body.quaternion) out.u32(packQuaternion(body.quaternion));
    }
    encodeSprings(out, peer.springs ?? []);
    if (overlays) encodeOverlays(out, peer.overlays);
  }
  return new Uint8Array(out.view.buffer.slice(0, out.at));
}

function encodeSprings(out, springs) {
  out.u16(springs.length);
  for (const s of springs) {
    out.u16(s.body);
    out.f32(...s.anchor, ...s.attachment);
    out.u8(s.user);
    out.u8(s.own ? 1 : 0);
  }
}

function encodeOverlays(out, {contacts, targets, influence}) {
  out.u16(contacts.length);
  for (const c of contacts) {
    out.u16(c.body);
    out.f32(...c.point, ...c.normal, c.depth);
  }
  out.u16(targets.length);
  for (const t of targets) {
    out.u16(t.body);
    out.u16(t.peer);
    out.f32(...t.position);
  }
  influence.forEach((v) => out.u8(v));
}
