// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The package as it is built in build/web/package. Each case claims something that its physics says by itself.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import test from 'node:test';

const root = new URL('../../../', import.meta.url);
const folder = new URL('build/web/package/', root);
const tandem = await import(new URL('tandem.js', folder));
const {Peer, STATE, Transport, World, init, shapeMass, sharedId} = tandem;
const module = readFileSync(new URL('tandem.wasm', folder));
await init(module);

const FRAME = 1 / 60;
const BOX = {type: 'box', halfExtents: [0.5, 0.5, 0.5]};

function withGround(options) {
  const world = new World(options);
  world.addBody({type: 'static', shape: {type: 'halfSpace', normal: [0, 0, 1]}});
  return world;
}

test('the module has every function of the C interface but those of parts', () => {
  const header = readFileSync(new URL('bindings/c/include/tandem/c/tandem.h', root), 'utf8');
  const names = [...header.matchAll(/^TANDEM_C_API [^;(]*?(tandem_\w+)\(/gms)].map((match) => match[1]);
  const parts = /^tandem_(attachment|car|character|cloth|ragdoll|rope)_/;
  const exported = WebAssembly.Module.exports(new WebAssembly.Module(module)).map(({name}) => name);
  assert.ok(names.length > 50);
  assert.deepEqual(names.filter((name) => exported.includes(name) === parts.test(name)), []);
});

test('a body falls as it must', () => {
  const world = new World();
  const body = world.addBody({shape: {type: 'sphere', radius: 0.1}, position: [0, 0, 10]});
  for (let i = 0; i < 60; ++i) world.step(FRAME);
  // The semi-implicit step of n substeps falls g t^2 / 2 (1 + 1 / n) in n of them.
  assert.ok(Math.abs(body.position[2] - (10 - 0.5 * 9.81 * (1 + 1 / 240))) < 1e-9);
  world.free();
});

test('a stack stands, and states has a row for each body, in order', () => {
  const world = withGround({events: true});
  const boxes = [0, 1, 2].map((i) => world.addBody({shape: BOX, position: [0, 0, 0.5 + i], friction: 0.6}));
  let begun = 0;
  for (let i = 0; i < 60; ++i) {
    world.step(FRAME);
    begun += world.contacts('begun').length;
  }
  assert.equal(begun, 3);
  assert.deepEqual(world.contacts().filter(({b}) => b === boxes[2]).map(({a}) => a), [boxes[1]]);
  assert.equal(world.states.length, 4 * STATE);
  boxes.forEach((box, i) => {
    assert.ok(Math.abs(box.position[2] - 0.5 - i) < 2e-3);
    assert.equal(world.states[(i + 1) * STATE + 2], box.position[2]);
  });
  world.removeBody(boxes[0]);
  assert.equal(world.states.length, 3 * STATE);
  for (let i = 0; i < 120; ++i) world.step(FRAME);
  assert.ok(Math.abs(boxes[2].position[2] - 1.5) < 5e-3);
  world.free();
});

test('the memory may grow under the view', () => {
  const world = new World({gravity: [0, 0, 0]});
  const first = world.addBody({shape: BOX, position: [1, 2, 3]});
  for (let i = 0; i < 3000; ++i) world.addBody({shape: BOX, position: [2 * i, 0, 10]});
  world.step(FRAME);
  assert.deepEqual([...first.position], [1, 2, 3]);
  assert.equal(world.states[3000 * STATE], 2 * 2999);
  world.free();
});

test('a snapshot goes on by the same bits', () => {
  const build = () => {
    const world = withGround();
    for (let i = 0; i < 8; ++i) world.addBody({shape: BOX, position: [0.2 * i, 0, 1 + 1.2 * i], restitution: 0.3});
    return world;
  };
  const lived = build();
  const other = build();
  for (let i = 0; i < 60; ++i) lived.step(FRAME);
  other.restore(lived.snapshot());
  for (let i = 0; i < 60; ++i) {
    lived.step(FRAME);
    other.step(FRAME);
    assert.equal(lived.hash(), other.hash());
  }
  assert.throws(() => other.restore(new Uint8Array(7)), /snapshot|bytes/);
  lived.free();
  other.free();
});

test('mass and centre of a shape are those of the body', () => {
  const cone = {type: 'cone', radius: 0.3, halfHeight: 0.4};
  const {mass, centreOfMass} = shapeMass(cone, 500);
  assert.ok(Math.abs(mass - 500 * Math.PI * 0.09 * 0.8 / 3) < 1e-9);
  assert.ok(Math.abs(centreOfMass[2] + 0.2) < 1e-12);
  const world = new World({gravity: [0, 0, 0]});
  const half = Math.SQRT1_2;  // half a turn about x has the apex to -y
  const body = world.addBody({shape: cone, orientation: [half, 0, 0, half]});
  assert.ok(Math.abs(body.position[1] - 0.2) < 1e-12 && Math.abs(body.position[2]) < 1e-12);
  body.applyImpulse([3, 0, 0]);
  world.step(FRAME);
  const solid = shapeMass(cone);
  assert.ok(Math.abs(body.linearVelocity[0] - 3 / solid.mass) < 1e-9);
  world.free();
});

test('a motor turns a hinge at its speed', () => {
  const world = new World({gravity: [0, 0, 0]});
  const body = world.addBody({shape: BOX});
  const joint = world.addJoint('hinge', {b: body, axis: [0, 0, 1], motor: 'velocity', motorTarget: 2});
  for (let i = 0; i < 60; ++i) world.step(FRAME);
  assert.ok(Math.abs(body.angularVelocity[2] - 2) < 1e-6);
  assert.ok(Math.abs(world.jointPosition(joint).position - 2) < 0.05);
  world.free();
});

test('what is wrong is named and changes nothing', () => {
  const world = new World();
  assert.throws(() => world.addBody({shape: BOX, friction: -1}), /friction/);
  assert.throws(() => world.addBody({shape: {type: 'blob'}}), /shape.type must be one of sphere/);
  assert.throws(() => world.addBody({shape: BOX, mass: Number.NaN}), /mass/);
  assert.throws(() => world.step(0), /dt/);
  assert.equal(world.bodies.length, 0);
  world.free();
});

/** Two peers 50 ms apart, of whom one holds a body by a hand for 10 s. */
function holdTogether(options, ids = [1n, 2n]) {
  const now = {ns: 1_000_000_000n, wire: []};
  const site = (self, place) => {
    const world = new World({gravity: [0, 0, 0]});
    const body = world.addBody({shape: BOX, position: place, linearDamping: 1});
    const transport = new Transport({
      self, send: (to, bytes) => now.wire.push({due: now.ns + 50_000_000n, to, from: self, bytes}),
    });
    transport.connected(ids.find((id) => id !== self));
    const peer = new Peer(world, transport, options);
    peer.share('cube', body);
    return {world, body, transport, peer};
  };
  const sites = [site(ids[0], [0, 0, 0]), site(ids[1], [0, 0.4, 0])];
  const hand = [1, 0.2, 0.5];
  const grab = sites[0].peer.grab('cube', {anchor: hand});
  for (let i = 0; i < 600; ++i) {
    sites[0].peer.move(grab, hand, now.ns);
    for (const {peer, world} of sites) {
      peer.beforeStep(now.ns);
      world.step(FRAME);
    }
    now.ns += 16_666_667n;
    for (const {due, to, from, bytes} of now.wire) {
      if (due <= now.ns) sites[ids.indexOf(to)].transport.receive(from, bytes);
    }
    now.wire = now.wire.filter(({due}) => due > now.ns);
    for (const {peer} of sites) peer.afterStep(now.ns);
  }
  return {hand, places: sites.map(({body}) => [...body.position]), stats: sites.map(({peer}) => peer.stats())};
}

test('a page that takes no steps keeps the newest of what comes, within bounds, and no exception crosses the module', () => {
  const transport = Object.assign(Object.create(Transport.prototype),
    {inbox: [], inboxBytes: 0, lost: 0, failure: null, send: () => { throw new Error('mine'); }});
  for (let i = 0; i < 5000; ++i) transport.receive(BigInt(i), new Uint8Array(8192));
  const kept = transport.take();
  assert.equal(kept.length + transport.lost, 5000);
  assert.ok(kept.length * 8192 <= 1 << 24 && kept.length > 1000);
  assert.equal(kept.at(-1).from, 4999n);
  assert.deepEqual(transport.take(), []);
  assert.equal(transport.post(1n, new Uint8Array(1), true), 0);
  assert.match(transport.failure.message, /mine/);
});

test('two peers who exchange bytes hold one body, whatever their ids', () => {
  for (const ids of [[1n, 2n], [1n << 63n, (1n << 64n) - 1n]]) {
    const {hand, places: [one, two], stats} = holdTogether({}, ids);
    assert.ok(Math.hypot(...one.map((x, i) => x - two[i])) < 1e-3);
    assert.ok(Math.hypot(...two.map((x, i) => x - hand[i])) < 1e-2);
    assert.ok(stats[1].updatesReceived > 100n);
  }
  // FNV-1a of "a", as the other machines compute it.
  assert.equal(sharedId('a').high, 0xd228cb696f1a8cafn);
});

test('what is sent compactly, where it is news, takes less than half and agrees as well', () => {
  const full = holdTogether({});
  const {places: [one, two], stats} = holdTogether({compact: true, tolerance: 2e-4, kbitPerS: 256, replayBudget: 1});
  assert.ok(Math.hypot(...one.map((x, i) => x - two[i])) < 1e-3);
  assert.ok(2n * stats[0].bytesSent < full.stats[0].bytesSent);
  assert.throws(() => holdTogether({compact: true, tolerance: -1}), /tolerance/);
  assert.throws(() => holdTogether({replayBudget: 0}), /budget/);
});

test('the compat build is the same with the module in it', async () => {
  const text = readFileSync(new URL('compat.js', folder), 'utf8');
  assert.ok(text.includes(module.toString('base64')));
  const compat = await import(new URL('compat.js', folder));
  await compat.init();
  const drop = (World) => {
    const world = new World();
    world.addBody({type: 'static', shape: {type: 'halfSpace', normal: [0, 0, 1]}});
    world.addBody({shape: BOX, density: 300, position: [0, 0, 1]});
    for (let i = 0; i < 60; ++i) world.step(FRAME);
    return world.hash();
  };
  assert.equal(drop(compat.World), drop(World));
});
