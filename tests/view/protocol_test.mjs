// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What demos/view/page/protocol.js makes of bytes.
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {ELSEWHERE, FrameDecoder, ProtocolError, unpackPosition, unpackQuaternion}
  from '../../demos/view/page/protocol.js';
import {encodeFrame} from './mock/encoder.mjs';

const UNIT = 1e-4;
const hello = (bodies, peers = 1) => ({
  position_unit: UNIT, bodies: Array.from({length: bodies}, (_, i) => ({name: `b${i}`})),
  peers: Array.from({length: peers}, (_, i) => ({id: i + 1}))});
const peerOf = (bodies, overlays = null, springs = []) => ({
  stepMs: 0.5, latencyMs: 28.5, divergenceP50Mm: NaN, divergenceMaxMm: 0.25, bodies, springs, overlays});
const frameOf = (peers, rest = {}) => (
  encodeFrame({number: 7, time: 1.5, key: true, unit: UNIT, peers, ...rest}));

/** Known bytes, written by hand from demos/view/README.md: one body at (1, -2, 3) units, turned. */
function knownFrame() {
  const bytes = new DataView(new ArrayBuffer(47));
  bytes.setUint8(0, 1);
  bytes.setUint8(1, 1);
  bytes.setUint16(2, 1, true);
  bytes.setUint32(4, 0x01020304, true);
  bytes.setFloat64(8, 12.25, true);
  [2, 30, NaN, 4].forEach((v, i) => bytes.setFloat32(16 + 4 * i, v, true));
  bytes.setUint8(32, 1);
  // x = 0x100001, y = 0xffffe, z = 0x100003: lo = x | y << 21, hi = y >> 11 | z << 10 | 1 << 31.
  bytes.setUint32(33, 0xffd00001, true);
  bytes.setUint32(37, 0xc0000dff, true);
  // w left out, z = (1022 - 511) / 511 / sqrt 2, x = y = 0: a quarter turn about z.
  bytes.setUint32(41, 0xffe7fdff, true);
  bytes.setUint16(45, 0, true);  // springs
  return bytes.buffer;
}

test('a frame written by hand is read as demos/view/README.md says', () => {
  const frame = new FrameDecoder(hello(1)).decode(knownFrame());
  assert.equal(frame.number, 0x01020304);
  assert.equal(frame.time, 12.25);
  assert.equal(frame.key, true);
  const [peer] = frame.peers;
  assert.deepEqual([peer.stepMs, peer.latencyMs, peer.divergenceMaxMm], [2, 30, 4]);
  assert.ok(Number.isNaN(peer.divergenceP50Mm));
  assert.deepEqual([...peer.positions].map((v) => Math.round(v / UNIT)), [1, -2, 3]);
  const half = Math.SQRT1_2;
  [0, 0, half, half].forEach((v, i) => assert.ok(Math.abs(peer.orientations[i] - v) < 1e-6));
});

test('positions at both ends of the range come back', () => {
  const out = new Float32Array(3);
  unpackPosition(0, 0, 1, out, 0);
  assert.deepEqual([...out], [-0x100000, -0x100000, -0x100000]);
  unpackPosition(0xffffffff, 0x7fffffff, 1, out, 0);
  assert.deepEqual([...out], [0xfffff, 0xfffff, 0xfffff]);
});

test('any 32 bits are a rotation', () => {
  const out = new Float32Array(4);
  let bits = 1;
  for (let i = 0; i < 5000; ++i) {
    bits = (Math.imul(bits, 1664525) + 1013904223) >>> 0;
    unpackQuaternion(bits, out, 0);
    assert.ok(Math.abs(Math.hypot(...out) - 1) < 1e-6, `${bits.toString(16)}: ${out}`);
  }
});

test('a rotation survives to within the step of ten bits', () => {
  for (const q of [[0.1, -0.7, 0.1, 0.7], [-0.5, 0.5, 0.5, -0.5], [0, 0, 0, -1],
                   [0.9, 0, 0.3, 0.3]]) {
    const length = Math.hypot(...q);
    const unit = q.map((v) => v / length);
    const {peers} = new FrameDecoder(hello(1)).decode(
      frameOf([peerOf([{position: [0, 0, 0], quaternion: unit}])]).buffer);
    const dot = unit.reduce((sum, v, i) => sum + v * peers[0].orientations[i], 0);
    assert.ok(Math.abs(dot) > 1 - 3e-6, `${unit}: ${peers[0].orientations}`);
  }
});

test('a body without a record stays where it was, beyond the eighth as well', () => {
  const decoder = new FrameDecoder(hello(11, 2));
  const all = (x) => Array.from({length: 11}, (_, b) => ({position: [x, b, 0], quaternion: null}));
  decoder.decode(frameOf([peerOf(all(1)), peerOf(all(2))]).buffer);
  const some = all(3).map((body, b) => (b === 9 ? body : null));
  const frame = decoder.decode(
    frameOf([peerOf(some), peerOf(all(0).fill(null))], {key: false}).buffer);
  assert.equal(frame.key, false);
  assert.deepEqual(frame.peers.map((peer) => peer.changed), [1, 0]);
  const x = (peer, b) => Math.round(10 * frame.peers[peer].positions[3 * b]) / 10;
  assert.deepEqual([x(0, 8), x(0, 9), x(0, 10), x(1, 9)], [1, 3, 1, 2]);
  assert.deepEqual([...frame.peers[0].orientations.subarray(36, 40)], [0, 0, 0, 1]);
});

test('overlays are read, without bodies that are not there, and peers may be elsewhere', () => {
  const overlays = {
    contacts: [{body: 1, point: [1, 2, 3], normal: [0, 0, 1], depth: 0.5},
               {body: 65535, point: [1, 2, 3], normal: [0, 0, 1], depth: 0.5}],
    targets: [{body: 0, peer: 0, position: [1, 1, 1]}, {body: 9, peer: 0, position: [1, 1, 1]},
              {body: 1, peer: 65535, position: [1, 1, 1]}],
    influence: [255, 51]};
  const springs = [
    {body: 1, anchor: [4, 5, 6], attachment: [7, 8, 9], user: 255, own: true}];
  const decoder = new FrameDecoder(hello(2));
  const {peers} = decoder.decode(frameOf([peerOf([null, null], overlays, springs)]).buffer);
  assert.deepEqual(peers[0].overlays.contacts, overlays.contacts.slice(0, 1));
  assert.deepEqual(peers[0].springs, [{...springs[0], user: ELSEWHERE}]);
  assert.deepEqual(peers[0].overlays.targets,
                   [overlays.targets[0], {...overlays.targets[2], peer: ELSEWHERE}]);
  assert.deepEqual([...peers[0].overlays.influence], [255, 51]);
});

test('what is cut short, too long or of another kind is refused, at every length', () => {
  const whole = knownFrame();
  for (let length = 0; length < whole.byteLength; ++length) {
    assert.throws(() => new FrameDecoder(hello(1)).decode(whole.slice(0, length)), ProtocolError);
  }
  const longer = new Uint8Array(48);
  longer.set(new Uint8Array(whole));
  assert.throws(() => new FrameDecoder(hello(1)).decode(longer.buffer), ProtocolError);
  // A run beside may be there or not; more peers than hello has cannot.
  assert.equal(new FrameDecoder(hello(1, 2)).decode(whole).peers.length, 1);
  const two = frameOf([peerOf([null]), peerOf([null])]).buffer;
  assert.throws(() => new FrameDecoder(hello(1)).decode(two), ProtocolError);
  assert.throws(() => new FrameDecoder(hello(1)).decode(frameOf([]).buffer), ProtocolError);
  new Uint8Array(whole)[0] = 2;
  assert.throws(() => new FrameDecoder(hello(1)).decode(whole), ProtocolError);
});
