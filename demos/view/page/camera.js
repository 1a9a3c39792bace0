// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A camera that orbits a target; all panes share it. World frame, z up, m and degrees.
import * as THREE from './three.module.min.js';

const VIEW = 32;  // degrees, vertical

/**
 * @typedef {object} Look
 * @property {number[]} target   m, the target
 * @property {number} azimuth    degrees, of the camera: from +x towards +y
 * @property {number} elevation  degrees above the horizon
 * @property {number} width      m, visible in a pane at the target
 * @property {number} height     m, visible at the target
 */

/** @type {Object<string, Look>}  by scene; others are shown whole */
const LOOKS = {
  cubes: {target: [0.3, -0.14, 0.2], azimuth: -72, elevation: 20, width: 2.75, height: 1.3},
  cliff: {target: [1, 0, 3.6], azimuth: -52, elevation: 30, width: 18, height: 14.5},
  room: {target: [0, 0, 0.72], azimuth: -90, elevation: 22, width: 5, height: 2.9},
  tennis: {target: [0.05, 0, 0.75], azimuth: -78, elevation: 16, width: 5.1, height: 2.2},
  piano: {target: [0, 0, 0.03], azimuth: -90, elevation: 54, width: 0.96, height: 0.7},
  pile: {target: [0, 0, 0.1], azimuth: -60, elevation: 30, width: 5.6, height: 4.2},
};

const radians = (degrees) => degrees * Math.PI / 180;

/** @param {string} text  "azimuth,elevation,width,height,x,y,z" @returns {?Look} */
export function parseLook(text) {
  const n = (text ?? '').split(',').map(Number);
  if (n.length !== 7 || !n.every(Number.isFinite)) return null;
  return {azimuth: n[0], elevation: n[1], width: n[2], height: n[3], target: n.slice(4)};
}

/** @param {string} scene @param {THREE.Box3} box  m, around all that is to be seen @returns {Look} */
export function lookAt(scene, box) {
  if (LOOKS[scene]) return structuredClone(LOOKS[scene]);
  const [azimuth, elevation] = [-52, 16];
  if (box.isEmpty()) return {target: [0, 0, 0], azimuth, elevation, width: 2, height: 1.5};
  const [x, y, z] = box.getSize(new THREE.Vector3()).toArray();
  const [a, e] = [radians(azimuth), radians(elevation)];
  const deep = Math.abs(x * Math.cos(a)) + Math.abs(y * Math.sin(a));
  const width = Math.abs(x * Math.sin(a)) + Math.abs(y * Math.cos(a));
  const height = z * Math.cos(e) + deep * Math.sin(e);
  // What is nearer than the centre looks larger.
  const margin = (length) => Math.max(0.1, 1.12 * length + 0.12 * deep);
  return {target: box.getCenter(new THREE.Vector3()).toArray(), azimuth, elevation,
          width: margin(width), height: margin(height)};
}

/** Turns, moves and zooms; gives a pane its camera. */
export class Orbit {
  constructor() {
    this.camera = new THREE.PerspectiveCamera(VIEW, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.set({target: [0, 0, 0], azimuth: -60, elevation: 22, width: 2, height: 1.5});
  }
  /** @param {Look} look */
  set(look) {
    this.home = look;
    this.target = new THREE.Vector3(...look.target);
    this.azimuth = look.azimuth;
    this.elevation = look.elevation;
    this.zoom = 1;
  }
  reset() { this.set(this.home); }

  /** @param {number} aspect  width / height of the pane @returns {number}  m, to the target */
  distance(aspect) {
    const half = Math.tan(radians(VIEW / 2));
    const {width, height} = this.home;
    return Math.max(height / 2 / half, width / 2 / half / aspect) / this.zoom;
  }
  /** A tall pane is filled from a higher elevation. @returns {number}  degrees */
  lift(aspect) {
    const tall = this.home.width / this.home.height / aspect;
    return tall > 1 ? Math.min(24, 24 * Math.log2(tall)) : 0;
  }
  /** @param {number} aspect @returns {THREE.PerspectiveCamera}  valid until the next call */
  at(aspect) {
    const distance = this.distance(aspect);
    const elevation = radians(Math.min(89, this.elevation + this.lift(aspect)));
    const flat = Math.cos(elevation);
    const from = new THREE.Vector3(flat * Math.cos(radians(this.azimuth)),
                                   flat * Math.sin(radians(this.azimuth)), Math.sin(elevation));
    this.camera.position.copy(this.target).addScaledVector(from, distance);
    this.camera.lookAt(this.target);
    this.camera.aspect = aspect;
    this.camera.near = distance / 60;
    this.camera.far = 14 * distance;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    return this.camera;
  }

  /** @param {number} dx  CSS pixels to the right @param {number} dy  down */
  turn(dx, dy) {
    this.azimuth -= 0.3 * dx;
    this.elevation = Math.min(89, Math.max(-5, this.elevation + 0.3 * dy));
  }
  /** @param {number} factor  > 1: nearer */
  zoomBy(factor) {
    this.zoom = Math.min(20, Math.max(0.15, this.zoom * factor));
  }
  /**
   * Moves the target. @param {number} dx  CSS pixels @param {number} dy
   * @param {{width: number, height: number}} pane
   */
  pan(dx, dy, pane) {
    const camera = this.at(pane.width / pane.height);
    const metres = 2 * Math.tan(radians(VIEW / 2)) * this.distance(camera.aspect) / pane.height;
    const right = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 0);
    const up = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 1);
    this.target.addScaledVector(right, -dx * metres).addScaledVector(up, dy * metres);
  }
}
