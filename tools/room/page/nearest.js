// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The nearest body within a hand's reach.
import {poseOf, toLocal} from './poses.js';

const beyond = (x, half) => Math.max(0, Math.abs(x) - half);

/** m, from a point in the frame of a shape to its surface; 0 inside. */
function away(shape, [x, y, z]) {
  if (shape.type === 'sphere') return Math.max(0, Math.hypot(x, y, z) - shape.radius);
  if (shape.type === 'box') return Math.hypot(...[x, y, z].map((k, i) => beyond(k, shape.halfExtents[i])));
  if (shape.type === 'cylinder') return Math.hypot(beyond(Math.hypot(x, y), shape.radius), beyond(z, shape.halfHeight));
  return Infinity;
}

/** The nearest holdable body, or null. @param {number[]} point  m, world @param {number} reach  m */
export function nearest(bodies, point, reach) {
  let found = null;
  for (const held of bodies) {
    if (!(held.mass > 0)) continue;
    const inBody = toLocal(poseOf(held.body), point);
    for (const {shape, position = [0, 0, 0], orientation = [0, 0, 0, 1]} of [held.def, ...held.def.parts ?? []]) {
      // For the body's own shape `position` is its start.
      const inShape = shape === held.def.shape ? inBody : toLocal({position, orientation}, inBody);
      const distance = away(shape, inShape);
      if (distance > reach) continue;
      reach = distance;
      found = held;
    }
  }
  return found;
}
