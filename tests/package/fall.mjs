// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A cube of 0.1 m falls from 1 m, by the installed package: freely at first, and it lies on the ground in the end.
import assert from 'node:assert';
import {World, init} from 'tandem-physics';

const dt = 1 / 240;  // s
const gravity = 9.81;  // m/s^2
await init();
const world = new World();
world.addBody({type: 'static', shape: {type: 'halfSpace', normal: [0, 0, 1]}});
const cube = world.addBody({shape: {type: 'box', halfExtents: [0.05, 0.05, 0.05]}, position: [0, 0, 1]});
let error = 0;  // over that of one velocity for each step
for (let step = 1; step <= 480; ++step) {
  world.step(dt);
  const time = step * dt;
  if (time > 0.4) continue;
  const height = 1 - gravity * time ** 2 / 2;
  error = Math.max(error, Math.abs(cube.position[2] - height) / (gravity * time * dt / 2));
}
assert(error < 1, `the fall is wrong: ${error}`);
assert(Math.abs(cube.position[2] - 0.05) < 1e-3, `the cube lies at ${cube.position[2]}`);
console.log(`the cube lies at ${cube.position[2].toFixed(3)} m; it fell with ${error.toFixed(2)} of the error allowed`);
