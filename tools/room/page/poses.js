// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Vectors as arrays, unit quaternions as x, y, z, w, and poses {position: m, orientation}.

export const minus = (a, b) => a.map((x, i) => x - b[i]);
export const plus = (a, b) => a.map((x, i) => x + b[i]);
export const scaled = (a, s) => a.map((x) => x * s);
export const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
export const between = (a, b, part) => a.map((x, i) => x + part * (b[i] - x));
export const shortened = (way, most) => {
  const length = Math.hypot(...way);
  return length > most ? way.map((x) => x * most / length) : way;
};

/** v rotated by a unit quaternion. */
export function rotated([x, y, z, w], v) {
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const t = cross([x, y, z], v).map((k) => 2 * k);
  return plus(plus(v, t.map((k) => k * w)), cross([x, y, z], t));
}
export const inverse = ([x, y, z, w]) => [-x, -y, -z, w];
/** First b, then a. */
export const product = ([ax, ay, az, aw], [bx, by, bz, bw]) => [
  aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
  aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz];
export const unit = (q) => scaled(q, 1 / Math.hypot(...q));

export const toWorld = ({position, orientation}, p) => plus(position, rotated(orientation, p));
export const toLocal = ({position, orientation}, p) => rotated(inverse(orientation), minus(p, position));
export const poseOf = (body) => ({position: [...body.position], orientation: [...body.orientation]});
/** From a to b, by the shorter rotation. @param {number} part  0 to 1 */
export function mixed(a, b, part) {
  const dot = a.orientation.reduce((sum, x, i) => sum + x * b.orientation[i], 0);
  const near = dot < 0 ? scaled(b.orientation, -1) : b.orientation;
  return {position: between(a.position, b.position, part), orientation: unit(between(a.orientation, near, part))};
}
