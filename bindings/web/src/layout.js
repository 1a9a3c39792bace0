// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Structs of tandem/c/tandem.h in the module's memory: members in C's order, each at a multiple of its own
// size, as clang lays them out for wasm32.

const SIZES = {i32: 4, u32: 4, f64: 8, u64: 8};
const SETTERS = {i32: 'setInt32', u32: 'setUint32', f64: 'setFloat64', u64: 'setBigUint64'};
const GETTERS = {i32: 'getInt32', u32: 'getUint32', f64: 'getFloat64', u64: 'getBigUint64'};

/** A struct's layout. @param members  [name, type, count = 1]; a type is i32, u32 (pointers, too), f64 or u64 */
export function struct(members) {
  const offsets = {};
  let at = 0;
  let align = 4;
  for (const [name, type, count = 1] of members) {
    const size = SIZES[type];
    align = Math.max(align, size);
    at = Math.ceil(at / size) * size;
    offsets[name] = {at, type, count};
    at += size * count;
  }
  return {offsets, size: Math.ceil(at / align) * align};
}

/** Writes those members that `values` has. */
export function write(view, base, layout, values) {
  for (const [name, value] of Object.entries(values)) {
    if (value === undefined) continue;
    const {at, type, count} = layout.offsets[name];
    const list = count === 1 ? [value] : value;
    for (let i = 0; i < count; ++i) view[SETTERS[type]](base + at + i * SIZES[type], list[i], true);
  }
}

/** All members as an object; of more than one number, an array. */
export function read(view, base, layout) {
  const values = {};
  for (const [name, {at, type, count}] of Object.entries(layout.offsets)) {
    const list = Array.from({length: count}, (_, i) => view[GETTERS[type]](base + at + i * SIZES[type], true));
    values[name] = count === 1 ? list[0] : list;
  }
  return values;
}

const POSE = [['position', 'f64', 3], ['orientation', 'f64', 4]];
const TWIST = [['linear', 'f64', 3], ['angular', 'f64', 3]];
const HANDLE = [['index', 'u32'], ['generation', 'u32']];
const SHAPE = [
  ['kind', 'i32'], ['radius', 'f64'], ['halfHeight', 'f64'], ['halfExtents', 'f64', 3], ['normal', 'f64', 3],
  ['offset', 'f64'], ['points', 'u32'], ['pointCount', 'u32'], ['triangles', 'u32'], ['triangleCount', 'u32'],
  ['columns', 'u32'], ['rows', 'u32'], ['spacingX', 'f64'], ['spacingY', 'f64'], ['heights', 'u32'],
  ['padding', 'u32'],
];

export const vec3 = struct([['value', 'f64', 3]]);
export const handle = struct(HANDLE);
export const pose = struct(POSE);
export const twist = struct(TWIST);
export const worldDef = struct([
  ['gravity', 'f64', 3], ['substeps', 'i32'], ['threads', 'i32'], ['sleepAfter', 'f64'], ['events', 'i32'],
]);
export const stepReport = struct([['finite', 'i32'], ['bodies', 'i32'], ['awake', 'i32'], ['targets', 'i32']]);
export const bodyDef = struct([
  ['type', 'i32'], ...POSE, ...TWIST, ['mass', 'f64'], ['inertia', 'f64', 9], ['gravityScale', 'f64'],
  ['linearDamping', 'f64'], ['angularDamping', 'f64'], ['bullet', 'i32'], ['canSleep', 'i32'],
]);
export const shape = struct(SHAPE);
export const mass = struct([['mass', 'f64'], ['centreOfMass', 'f64', 3], ['inertia', 'f64', 9]]);
export const colliderDef = struct([
  ...HANDLE, ...SHAPE, ...POSE, ['friction', 'f64'], ['restitution', 'f64'], ['category', 'u32'], ['mask', 'u32'],
  ['group', 'i32'], ['sensor', 'i32'],
]);
export const jointDef = struct([
  ['kind', 'i32'], ['a', 'u32', 2], ['b', 'u32', 2], ['anchor', 'f64', 3], ['axis', 'f64', 3], ['compliance', 'f64'],
  ['limited', 'i32'], ['lower', 'f64'], ['upper', 'f64'], ['motor', 'i32'], ['motorTarget', 'f64'],
  ['motorMaxForce', 'f64'], ['breakForce', 'f64'], ['breakTorque', 'f64'],
]);
export const hit = struct([
  ['colliderA', 'u32', 2], ['colliderB', 'u32', 2], ['bodyA', 'u32', 2], ['bodyB', 'u32', 2], ['point', 'f64', 3],
  ['normal', 'f64', 3], ['speed', 'f64'], ['impulse', 'f64'],
]);
export const peerDef = struct([['updateHz', 'f64'], ['influence', 'f64'], ['authorityRamp', 'f64'],
  ['compact', 'i32'], ['tolerance', 'f64'], ['kbitPerS', 'f64'], ['replayBudget', 'f64']]);
export const sharedId = struct([['high', 'u64'], ['low', 'u64']]);
export const grabDef = struct([
  ['high', 'u64'], ['low', 'u64'], ['attachment', 'f64', 3], ['anchor', 'f64', 3], ['stiffness', 'f64'],
  ['damping', 'f64'], ['maxForce', 'f64'],
]);
export const peerStats = struct([
  ['updatesReceived', 'u64'], ['packetsReceived', 'u64'], ['packetsRejected', 'u64'], ['bytesSent', 'u64'],
  ['bodiesPlaced', 'u64'],
]);
