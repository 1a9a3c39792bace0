// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Parts of the page's headset without a browser: what members say of heads and hands, a hand's springs, how simple a
// picture has to be, where a jump leads.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {Budget} from '../../tools/room/page/budget.js';
import {Grip} from '../../tools/room/page/grip.js';
import {nearest} from '../../tools/room/page/nearest.js';
import {rotated} from '../../tools/room/page/poses.js';
import {Malformed, decode, encodeHeadset, encodePointer} from '../../tools/room/page/presence.js';
import {Stand, landing} from '../../tools/room/page/stand.js';

const STRAIGHT = [0, 0, 0, 1];
const body = (name, position, mass = 2, shape = {type: 'box', halfExtents: [0.5, 0.1, 0.1]}) =>
  ({name, mass, def: {shape}, body: {position, orientation: STRAIGHT}});
const near = (a, b, by = 1e-6) => a.forEach((x, i) => assert.ok(Math.abs(x - b[i]) <= by, `${a} is not ${b}`));
/** Repeatable, 0 to 1. */
function random(seed) {
  return () => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return seed / 2 ** 32;
  };
}

describe('what members say of heads and hands', () => {
  const held = body('piano', [0, 0, 0]);
  const find = (name) => (name === 'piano' ? held : undefined);
  const seen = {head: {position: [1, -2, 1.7], orientation: [0.5, 0.5, 0.5, 0.5]},
                right: {position: [1, -2, 1], orientation: [0, 1, 0, 0]}};
  const holding = new Map([['right', {held, attachment: [0.5, 0, 0.25]}]]);

  test('comes back from its bytes', () => {
    const said = decode(encodeHeadset(seen, holding), find);
    assert.equal(said.left, undefined);
    assert.equal(said.right.held, held);
    near(said.right.attachment, [0.5, 0, 0.25]);
    for (const [one, other] of [[said.head, seen.head], [said.right.pose, seen.right]]) {
      near(one.position, other.position);
      near(one.orientation, other.orientation);
    }
    const {pointer} = decode(encodePointer({held, anchor: [1, 2, 3], attachment: [0, 0.5, 0]}), find);
    assert.equal(pointer.held, held);
    near([...pointer.anchor, ...pointer.attachment], [1, 2, 3, 0, 0.5, 0]);
  });
  test('is no number to who knows pointers only, and so dropped', () => {
    const bytes = encodeHeadset(seen, holding);
    assert.ok(Number.isNaN(new DataView(bytes.buffer).getFloat32(0, true)));
  });
  test('is refused where any of it is missing or too much', () => {
    const bytes = encodeHeadset(seen, holding);
    for (let length = 0; length < bytes.length; ++length) {
      assert.throws(() => decode(bytes.subarray(0, length), find), Malformed);
    }
    assert.throws(() => decode(new Uint8Array([...bytes, 0]), find), Malformed);
  });
  test('with any bits changed is refused, or finite and in the room', () => {
    const draw = random(7);
    let taken = 0;
    for (let i = 0; i < 20000; ++i) {
      const bytes = encodeHeadset(seen, holding);
      const at = () => 5 + Math.floor(draw() * (bytes.length - 5));
      for (let k = 0; k <= 3 * draw(); ++k) bytes[at()] ^= 1 << Math.floor(8 * draw());
      let said = null;
      try {
        said = decode(bytes, find);
      } catch (problem) {
        assert.ok(problem instanceof Malformed, String(problem));
        continue;
      }
      ++taken;
      for (const {position, orientation} of [said.head, said.left?.pose, said.right?.pose].filter(Boolean)) {
        assert.ok(position.every((x) => Math.abs(x) <= 20) && Math.abs(Math.hypot(...orientation) - 1) < 1e-6);
      }
    }
    assert.ok(taken > 1000 && taken < 19000, `${taken} taken`);
  });
});

describe('a hand of three springs', () => {
  const DT = 1000 / 60;  // ms
  /** A peer that notes what it is told. */
  const peer = () => {
    const springs = new Map();
    let last = 0;
    return {springs, grab: (name, def) => springs.set(++last, {...def}) && last,
            move: (id, anchor) => { springs.get(id).anchor = anchor; }, release: (id) => springs.delete(id)};
  };
  const middle = ({springs}) => [0, 1, 2].map((k) =>
    [...springs.values()].reduce((sum, {anchor}) => sum + anchor[k], 0) / 3);

  test('together carry the load with 1 cm of sag, and half of it each where two hands hold', () => {
    const held = body('crate', [0, 0, 0], 6);
    const one = peer();
    const grip = new Grip(held, {position: [0, 0, 0.1], orientation: STRAIGHT});
    const stiffness = () => [...one.springs.values()].reduce((sum, spring) => sum + spring.stiffness, 0);
    grip.update(one, 0n);
    assert.equal(one.springs.size, 3);
    near([stiffness() * 0.01], [6 * 9.81], 1e-9);
    grip.share(2, one);
    assert.equal(one.springs.size, 0);
    grip.update(one, 16666667n);
    assert.equal(one.springs.size, 3);
    near([stiffness() * 0.01], [3 * 9.81], 1e-9);
    grip.release(one);
    assert.equal(one.springs.size, 0);
  });
  test('goes evenly where the hand does, whatever the display\'s rate', () => {
    for (const hz of [72, 90, 120]) {
      const one = peer();
      const grip = new Grip(body('crate', [0, 0, 0]), {position: [0, 0, 0], orientation: STRAIGHT});
      const places = [];
      let step = 0;
      for (let i = 0; i < 2 * hz; ++i) {
        const time = 1000 * i / hz;
        grip.track(time, {position: [time / 1000, 0, 0], orientation: STRAIGHT});
        // A step is made once its time is over.
        for (; (step + 1) * DT <= time; ++step) {
          grip.update(one, BigInt(Math.round(step * DT * 1e6)));
          places.push(middle(one)[0]);
        }
      }
      for (let i = 2; i < places.length; ++i) near([places[i] - places[i - 1]], [1 / 60], 1e-6);
    }
  });
  test('lets go of what stays behind by more than an arm can be', () => {
    const grip = new Grip(body('crate', [0, 0, 0]), {position: [0, 0, 0.1], orientation: STRAIGHT});
    const one = peer();
    for (const [z, lost] of [[0.1, false], [0.45, false], [0.55, true]]) {
      grip.track(z, {position: [0, 0, z], orientation: STRAIGHT});
      grip.update(one, 1000000000n);
      assert.equal(grip.lost, lost, `at ${z}`);
    }
  });
  test('reaches the nearest thing that can be held', () => {
    const bodies = [body('wall', [0, 0, 0], 0), body('far', [0, 0.5, 0]), body('near', [0, 0.3, 0]),
                    body('ball', [2, 0, 0], 1, {type: 'sphere', radius: 0.3})];
    assert.equal(nearest(bodies, [0, 0.15, 0], 0.1).name, 'near');
    assert.equal(nearest(bodies, [0.55, 0.65, 0], 0.1).name, 'far');
    assert.equal(nearest(bodies, [2, 0, 0.39], 0.1).name, 'ball');
    assert.equal(nearest(bodies, [2, 0, 0.41], 0.1), null);
    assert.equal(nearest(bodies, [0, 0, 0.1], 0.05), null);
  });
});

describe('a picture\'s budget', () => {
  const pictures = (budget, hz, interval, late, count, begin = 0) => {
    let simpler = 0;
    for (let i = 0; i < count; ++i) simpler += budget.took(begin + i * interval, late, hz) ? 1 : 0;
    return simpler;
  };
  test('is all where pictures come in time', () => {
    for (const hz of [72, 90, 120]) assert.equal(pictures(new Budget(), hz, 1000 / hz, 2, 2000), 0);
  });
  test('shrinks step by step where every second picture is missed, down to the least', () => {
    const budget = new Budget();
    const most = budget.level;
    assert.equal(pictures(budget, 90, 2000 / 90, 2, 44), 0);
    assert.ok(pictures(budget, 90, 2000 / 90, 2, 2000, 10000) > 0);
    assert.ok(most.shadows && !budget.level.shadows && budget.level.plain && budget.level.scale < most.scale);
    assert.equal(pictures(budget, 90, 2000 / 90, 2, 2000, 100000), 0);
  });
  test('shrinks where steps are late for pictures that are not', () => {
    assert.ok(pictures(new Budget(), 72, 1000 / 72, 20, 200) > 0);
  });
  test('does not count a pause', () => {
    const budget = new Budget();
    for (let i = 0; i < 200; ++i) assert.equal(budget.took(i * 1000, 0, 72), false);
  });
});

describe('where a headset stands', () => {
  test('its y is up in the room, and -z ahead', () => {
    const stand = new Stand();
    near(stand.pose({position: {x: 1, y: 2, z: -3}, orientation: {x: 0, y: 0, z: 0, w: 1}}).position, [1, 3, 2]);
    const turned = () => rotated(stand.orientation, [0, 0, -1]);
    near(turned(), [0, 1, 0]);
    stand.turn(Math.PI / 2, [0, 0, 1.6]);
    near(turned(), [-1, 0, 0]);
  });
  test('a throw lands where a parabola does, or nowhere', () => {
    const level = {position: [1, 2, 1.2], orientation: new Stand().orientation};
    const far = 6 * Math.sqrt(2 * 1.2 / 9.81);
    near(landing(level), [1, 2 + far]);
    assert.equal(landing({position: [0, 0, 40], orientation: STRAIGHT}), null);
  });
});
