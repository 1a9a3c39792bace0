// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The bounds of what a scene shows, for its first view. World frame, m.
import * as THREE from './three.module.min.js';

/** A part's bounds in its own frame. @returns {?THREE.Box3}  null for a half-space */
function boundsOf(part) {
  if (part.shape === 'half_space') return null;
  if (part.vertices) {
    return new THREE.Box3().setFromPoints(part.vertices.map((v) => new THREE.Vector3(...v)));
  }
  const r = part.radius;
  const h = (part.half_height ?? 0) + (part.shape === 'capsule' || part.shape === 'sphere' ? r : 0);
  const half = new THREE.Vector3(...(part.half_extents ?? [r, r, h]));
  return new THREE.Box3(half.clone().negate(), half);
}

function matrixOf([x, y, z, qx, qy, qz, qw]) {
  return new THREE.Matrix4().compose(new THREE.Vector3(x, y, z),
                                     new THREE.Quaternion(qx, qy, qz, qw).normalize(),
                                     new THREE.Vector3(1, 1, 1));
}

/**
 * Around the moving bodies, and around static parts that are not much larger than these: the base of an arm is shown
 * whole, the hall around it is not.
 * @param {object} hello  the server's first message
 * @param {{positions: Float32Array, orientations: Float32Array}} peer  of a frame
 * @returns {THREE.Box3}
 */
export function extentOf(hello, {positions, orientations}) {
  const box = new THREE.Box3();
  hello.bodies.forEach((body, b) => {
    const place = matrixOf([...positions.subarray(3 * b, 3 * b + 3),
                            ...orientations.subarray(4 * b, 4 * b + 4)]);
    for (const part of body.parts) {
      const own = boundsOf(part);
      if (own) box.union(own.applyMatrix4(place.clone().multiply(matrixOf(part.pose))));
    }
  });
  const size = box.isEmpty() ? Infinity : 2 * box.getSize(new THREE.Vector3()).length();
  for (const part of hello.fixed) {
    const own = boundsOf(part)?.applyMatrix4(matrixOf(part.pose));
    if (own && own.getSize(new THREE.Vector3()).length() < size) box.union(own);
  }
  return box;
}
