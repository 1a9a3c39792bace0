// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What demos/view/page/timeline.js shows between two frames.
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {Timeline} from '../../demos/view/page/timeline.js';

const near = (a, b, margin = 1e-6) => assert.ok(Math.abs(a - b) <= margin, `${a} is not ${b}`);

/** A body at x = speed t that turns about z at a rate of 1 rad/s, and its marks. */
function frameAt(time, speeds = [2, 2]) {
  return {time, peers: speeds.map((speed, p) => {
    const x = speed * time;
    const [c, s] = [Math.cos(time), Math.sin(time)];
    const corner = [x + 0.1 * c, 0.1 * s, 0.5];  // (0.1, 0, 0.5) in the frame of the body
    return {
      positions: Float32Array.of(x, 0, 0), orientations: Float32Array.of(0, 0, Math.sin(time / 2),
                                                                          Math.cos(time / 2)),
      springs: [{body: 0, anchor: [x, 1, 0], attachment: corner, user: 0, own: p === 0}],
      overlays: {contacts: [{body: 0, point: corner, normal: [0, 0, 1], depth: 0}],
                 targets: [{body: 0, peer: 1 - p, position: [x + 1, 0, 0]}],
                 influence: Uint8Array.of(0)}};
  })};
}
const shown = () => ({positions: new Float32Array(3), orientations: new Float32Array(4)});

test('all peers, bodies and marks are of the instant of the playhead', () => {
  const timeline = new Timeline(1);
  timeline.push(frameAt(0), 0, false);
  // Frames come at uneven times of the clock and of the session.
  let clock = 0;
  let last = 0;
  for (const [wall, time] of [[20, 0.02], [70, 0.05], [75, 0.06], [200, 0.2], [260, 0.22]]) {
    timeline.push(frameAt(time), wall, false);
    for (clock = wall; clock < wall + 60; clock += 7) {
      timeline.advance(clock);
      const t = timeline.time;
      assert.ok(t >= last && t >= timeline.before.time && t <= timeline.after.time, `${t}`);
      last = t;
      for (const peer of [0, 1]) {
        const out = shown();
        timeline.poses(peer, out);
        near(out.positions[0], 2 * t);
        near(2 * Math.atan2(out.orientations[2], out.orientations[3]), t, 1e-3);
        const {springs, contacts, targets} = timeline.marks(peer, out);
        near(springs[0].anchor[0], 2 * t);
        near(targets[0].position[0], 2 * t + 1);
        // On the body, wherever it is drawn.
        for (const at of [springs[0].attachment, contacts[0].point]) {
          near(at[0], 2 * t + 0.1 * Math.cos(t), 1e-4);
          near(at[1], 0.1 * Math.sin(t), 1e-4);
          near(at[2], 0.5);
        }
      }
    }
  }
});

test('the playhead comes to the last frame within the time that one takes, and stays there', () => {
  const timeline = new Timeline(1);
  for (let i = 0; i <= 60; ++i) timeline.push(frameAt(i / 60), 1000 * i / 60, false);
  assert.ok(!timeline.advance(1001));
  assert.ok(timeline.advance(1020));
  near(timeline.time, 1);
  assert.ok(timeline.advance(5000));
  near(timeline.time, 1);
});

test('where nothing moves a frame is shown at once, and there is nothing to draw until the next', () => {
  const resting = (time) => ({time, peers: frameAt(0).peers.map((peer) => ({...peer, springs: [], overlays: null}))});
  const timeline = new Timeline(1);
  timeline.push(resting(0), 0, false);
  for (let i = 1; i <= 9; ++i) {
    timeline.push(resting(0.5 * i), 500 * i, false);
    assert.ok(timeline.advance(500 * i));
    near(timeline.time, 0.5 * i);
  }
  // Motion after that is shown as quickly as before, and so are marks on bodies at rest.
  timeline.push(frameAt(4.6), 4516, false);
  assert.ok(!timeline.advance(4516));
  timeline.push({...frameAt(4.6), time: 4.62}, 4533, false);
  assert.ok(!timeline.advance(4534));
  assert.ok(timeline.advance(4580));
});

test('a restart, another run beside and a jump are shown at once', () => {
  const timeline = new Timeline(1);
  timeline.push(frameAt(3), 0, false);
  timeline.push(frameAt(4), 16, false);
  timeline.push(frameAt(0), 32, false);
  timeline.advance(32);
  near(timeline.time, 0);
  timeline.push(frameAt(0.02, [2, 2, 5, 5]), 48, false);
  timeline.advance(48);
  near(timeline.time, 0.02);
  const out = shown();
  timeline.poses(3, out);
  near(out.positions[0], 0.1);
  timeline.push(frameAt(9, [2, 2, 5, 5]), 64, true);
  timeline.advance(64);
  near(timeline.time, 9);
});

test('who is furthest apart is found among the copies of one run', () => {
  const at = (...positions) => ({positions: Float32Array.from(positions)});
  const all = [at(0, 0, 0, 1, 0, 0), at(0, 0, 0.1, 1, 0.3, 0), at(9, 9, 9, 9, 9, 9)];
  const {distance, body} = Timeline.furthest([0, 1], all);
  near(distance, 0.3, 1e-6);
  assert.equal(body, 1);
  assert.ok(Number.isNaN(Timeline.furthest([2], all).distance));
});
