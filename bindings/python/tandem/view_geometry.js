// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Vectors and quaternions, and the triangles of shapes.

// Vectors are arrays of three, quaternions x, y, z, w.
export const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const turn = (q, v) => { const t = cross(q, v); return add(add(v, t, 2 * q[3]), cross(q, t), 2); };
export const times = (p, q) => [...add(add(cross(p, q), q, p[3]), p, q[3]), p[3] * q[3] - dot(p, q)];
/** @returns a quaternion that turns z into the unit vector n */
export const upTo = (n) => {
  if (n[2] < -0.9999) return [1, 0, 0, 0];
  const q = [-n[1], n[0], 0, 1 + n[2]];
  const l = Math.hypot(...q);
  return q.map((x) => x / l);
};

// --- Geometry: corners with normals, in the shape's frame.
/** Round about z. @param profile  from below: radius, z, and the normal's parts outwards and upwards */
export function lathe(profile, around = 40) {
  const corners = [], normals = [], triangles = [];
  profile.forEach(([r, z, out, up], k) => {
    for (let i = 0; i <= around; ++i) {
      const a = 2 * Math.PI * i / around, c = Math.cos(a), s = Math.sin(a);
      corners.push(r * c, r * s, z);
      normals.push(out * c, out * s, up);
      if (k === 0 || i === 0) continue;
      const d = k * (around + 1) + i, b = d - around - 1;
      triangles.push(b - 1, b, d, b - 1, d, d - 1);
    }
  });
  return {corners, normals, triangles};
}
/** Half circles about -half and half. */
export function capsule(radius, half, steps = 12) {
  const profile = [];
  for (const end of [-1, 1]) {
    for (let i = 0; i <= steps; ++i) {
      const a = Math.PI / 2 * (i / steps + (end < 0 ? -1 : 0));
      profile.push([radius * Math.cos(a), end * half + radius * Math.sin(a), Math.cos(a), Math.sin(a)]);
    }
  }
  return lathe(profile);
}
export function box() {
  const corners = [], normals = [], triangles = [];
  for (let axis = 0; axis < 3; ++axis) {
    for (const side of [-1, 1]) {
      const first = corners.length / 3;
      for (const [u, v] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
        const corner = [0, 0, 0], normal = [0, 0, 0];
        corner[axis] = normal[axis] = side;
        corner[(axis + 1) % 3] = u * side;
        corner[(axis + 2) % 3] = v;
        corners.push(...corner);
        normals.push(...normal);
      }
      triangles.push(first, first + 1, first + 2, first, first + 2, first + 3);
    }
  }
  return {corners, normals, triangles};
}
export function mesh(vertices, indices, smooth) {
  const corner = (i) => vertices.subarray(3 * i, 3 * i + 3);
  const normalOf = (t) => {
    const [a, b, c] = [0, 1, 2].map((k) => corner(indices[t + k]));
    return cross(add(b, a, -1), add(c, a, -1));
  };
  if (smooth) {
    const normals = new Float32Array(vertices.length);
    for (let t = 0; t < indices.length; t += 3) {
      const n = normalOf(t);
      for (let k = 0; k < 9; ++k) normals[3 * indices[t + (k / 3 | 0)] + k % 3] += n[k % 3];
    }
    return {corners: vertices, normals, triangles: indices};
  }
  const corners = new Float32Array(3 * indices.length), normals = new Float32Array(3 * indices.length);
  for (let i = 0; i < indices.length; ++i) {
    corners.set(corner(indices[i]), 3 * i);
    normals.set(normalOf(i - i % 3), 3 * i);
  }
  return {corners, normals, triangles: Uint32Array.from(indices.keys())};
}
