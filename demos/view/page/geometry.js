// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Shapes of hello as three.js geometry. Scalable shapes are made once in unit size, so that solids
// of different sizes share instances.
import * as THREE from './three.module.min.js';

const MANY = 200;  // instances, from which on they have fewer triangles

/** @param {THREE.Vector3} axis  unit @returns {THREE.Vector3}  unit, perpendicular to it */
export function perpendicular(axis) {
  const upright = Math.abs(axis.z) >= 0.9;
  return new THREE.Vector3(upright ? 1 : 0, 0, upright ? 0 : 1).cross(axis).normalize();
}

/** Gives each triangle its own corners and a shade, so that rotation is visible. */
function twoTone(geometry, isDark) {
  const flat = geometry.index ? geometry.toNonIndexed() : geometry;
  const position = flat.attributes.position;
  const colours = new Float32Array(3 * position.count);
  const centre = new THREE.Vector3();
  const corner = new THREE.Vector3();
  for (let i = 0; i < position.count; i += 3) {
    centre.set(0, 0, 0);
    for (let k = 0; k < 3; ++k) centre.add(corner.fromBufferAttribute(position, i + k));
    colours.fill(isDark(centre) ? 0.68 : 1, 3 * i, 3 * i + 9);
  }
  flat.setAttribute('color', new THREE.BufferAttribute(colours, 3));
  return flat;
}

function plain(geometry) {
  const colours = new Float32Array(3 * geometry.attributes.position.count).fill(1);
  geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3));
  return geometry;
}

/** A box with rounded edges, which catch the light. @param {number[]} half  m, half its edges */
function roundedBox(half) {
  const rounds = 2;
  const segments = 2 * rounds + 1;
  const radius = 0.1 * Math.min(...half);
  const geometry = new THREE.BoxGeometry(1, 1, 1, segments, segments, segments);
  const {position, normal} = geometry.attributes;
  const inner = half.map((h) => h - radius);
  const v = new THREE.Vector3();
  const middle = 0.5 / segments;
  for (let i = 0; i < position.count; ++i) {
    v.fromBufferAttribute(position, i);
    const sign = [Math.sign(v.x), Math.sign(v.y), Math.sign(v.z)];
    // The middle strip of each side becomes flat, the rest is the rounding.
    v.set(v.x - sign[0] * middle, v.y - sign[1] * middle, v.z - sign[2] * middle).normalize();
    position.setXYZ(i, sign[0] * inner[0] + radius * v.x, sign[1] * inner[1] + radius * v.y,
                    sign[2] * inner[2] + radius * v.z);
    normal.setXYZ(i, v.x, v.y, v.z);
  }
  return geometry;
}

function triangles(part) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position',
                        new THREE.BufferAttribute(new Float32Array(part.vertices.flat()), 3));
  geometry.setIndex(part.triangles.flat());
  // A mesh of few triangles has sharp edges, one of many is smooth.
  const result = part.triangles.length < 200 ? geometry.toNonIndexed() : geometry;
  result.computeVertexNormals();
  return result;
}

/**
 * @typedef {object} Solid
 * @property {string} key     solids of the same key share a geometry
 * @property {function(number): THREE.BufferGeometry} make  of the number of instances; in the
 *   solid's own frame before scaling, with a colour to multiply with the body's
 * @property {number[]} scale  of the geometry along x, y, z
 * @property {number} radius   m, of its bounding sphere about the origin
 */

/**
 * @param {object} part   of hello; not a half-space
 * @param {string} name   key of a unique shape
 * @param {boolean} turns  whether its body turns
 * @returns {?Solid}  null for an unknown shape
 */
export function solidOf(part, name, turns) {
  const r = part.radius;
  const h = part.half_height;
  switch (part.shape) {
    case 'box': {
      const half = part.half_extents;
      return {key: `box ${half}`, make: () => plain(roundedBox(half)), scale: [1, 1, 1],
              radius: Math.hypot(...half)};
    }
    case 'sphere': {
      const make = (count) => {
        const [w, n] = count > MANY ? [16, 10] : [48, 24];
        const ball = new THREE.SphereGeometry(1, w, n).rotateX(Math.PI / 2);
        return turns ? twoTone(ball, (c) => (c.x > 0) !== (c.y > 0)) : plain(ball);
      };
      return {key: `sphere ${turns}`, make, scale: [r, r, r], radius: r};
    }
    case 'capsule':
      return {key: `capsule ${r} ${h}`, scale: [1, 1, 1], radius: r + h,
              make: (count) => plain(new THREE.CapsuleGeometry(r, 2 * h, count > MANY ? 4 : 12,
                                                               count > MANY ? 12 : 32)
                .rotateX(Math.PI / 2))};
    case 'cylinder':
      return {key: 'cylinder', scale: [r, r, h], radius: Math.hypot(r, h),
              make: () => twoTone(new THREE.CylinderGeometry(1, 1, 2, 48).rotateX(Math.PI / 2),
                                  (c) => c.x * c.y > 0)};
    case 'cone':
      return {key: 'cone', scale: [r, r, h], radius: Math.hypot(r, h),
              make: () => twoTone(new THREE.ConeGeometry(1, 2, 48).rotateX(Math.PI / 2),
                                  (c) => c.x * c.y > 0)};
    default:
      if (!part.vertices || !part.triangles) return null;
      return {key: name, make: () => plain(triangles(part)), scale: [1, 1, 1],
              radius: Math.max(...part.vertices.map((v) => Math.hypot(...v)))};
  }
}
