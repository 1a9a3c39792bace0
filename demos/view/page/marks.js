// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Instanced sticks and dots for overlays.
import * as THREE from './three.module.min.js';
import {perpendicular} from './geometry.js';

const UP = new THREE.Vector3(0, 0, 1);

/** Instances of one geometry that are set again for each frame; grows as needed. */
class Marks extends THREE.Group {
  constructor(geometry, material, shadows) {
    super();
    this.shadows = shadows;
    this.geometry = geometry;
    this.material = material;
    this.count = 0;
    this.reserve(64);
  }
  reserve(capacity) {
    const old = this.mesh;
    this.mesh = new THREE.InstancedMesh(this.geometry, this.material, capacity);
    this.mesh.instanceColor =
      new THREE.InstancedBufferAttribute(new Float32Array(3 * capacity), 3);
    this.mesh.frustumCulled = false;
    this.mesh.castShadow = this.mesh.receiveShadow = this.shadows;
    this.mesh.raycast = () => {};
    if (old) {
      this.mesh.instanceMatrix.array.set(old.instanceMatrix.array);
      this.mesh.instanceColor.array.set(old.instanceColor.array);
      this.remove(old);
      old.dispose();
    }
    this.add(this.mesh);
  }
  clear() { this.count = 0; }
  put(matrix, colour) {
    if (this.count === this.mesh.instanceMatrix.count) this.reserve(2 * this.count);
    this.mesh.setMatrixAt(this.count, matrix);
    this.mesh.setColorAt(this.count, colour);
    ++this.count;
  }
  /** After the last put() of a frame. */
  show() {
    this.mesh.count = this.count;
    this.mesh.instanceMatrix.needsUpdate = true;
    this.mesh.instanceColor.needsUpdate = true;
    this.visible = this.count > 0;
  }
  dispose() {
    this.geometry.dispose();
    this.mesh.dispose();
  }
}

/** Cylinders from one point to another. */
export class Sticks extends Marks {
  /** @param {THREE.Material} material @param {boolean} shadows  cast and receive */
  constructor(material, shadows = false) {
    super(new THREE.CylinderGeometry(1, 1, 1, 12).rotateX(Math.PI / 2), material, shadows);
    this.middle = new THREE.Vector3();
    this.along = new THREE.Vector3();
    this.turn = new THREE.Quaternion();
    this.size = new THREE.Vector3();
    this.matrix = new THREE.Matrix4();
  }
  /**
   * @param {THREE.Vector3} from  m, world
   * @param {THREE.Vector3} to    m, world
   * @param {number} radius       m
   * @param {THREE.Color} colour
   */
  draw(from, to, radius, colour) {
    this.along.subVectors(to, from);
    const length = this.along.length();
    if (!(length > 1e-9)) return;
    this.turn.setFromUnitVectors(UP, this.along.divideScalar(length));
    this.middle.addVectors(from, to).multiplyScalar(0.5);
    this.put(this.matrix.compose(this.middle, this.turn, this.size.set(radius, radius, length)),
             colour);
  }

  /**
   * A helical spring from one place to another, with straight ends.
   * @param {THREE.Vector3} from    m, world
   * @param {THREE.Vector3} to      m, world
   * @param {number} width          m, radius of the helix
   * @param {THREE.Color} colour
   */
  addCoil(from, to, width, colour) {
    const axis = new THREE.Vector3().subVectors(to, from);
    const length = axis.length();
    if (length < 2 * width) {
      this.draw(from, to, 0.3 * width, colour);
      return;
    }
    axis.divideScalar(length);
    const side = perpendicular(axis);
    const other = new THREE.Vector3().crossVectors(axis, side);
    const turns = 8;
    const pieces = 12 * turns;
    let last = from.clone();
    for (let i = 1; i <= pieces; ++i) {
      const t = i / pieces;
      const wide = width * Math.max(0, Math.min(1, 9 * t - 1, 9 * (1 - t) - 1));
      const angle = 2 * Math.PI * turns * t;
      const next = from.clone().addScaledVector(axis, length * t)
        .addScaledVector(side, wide * Math.cos(angle))
        .addScaledVector(other, wide * Math.sin(angle));
      this.draw(last, next, 0.24 * width, colour);
      last = next;
    }
  }
}

export class Dots extends Marks {
  /** @param {THREE.Material} material @param {THREE.BufferGeometry} geometry  of radius 1
   *  @param {boolean} shadows  cast and receive */
  constructor(material, geometry = new THREE.SphereGeometry(1, 16, 10), shadows = false) {
    super(geometry, material, shadows);
    this.turn = new THREE.Quaternion();
    this.size = new THREE.Vector3();
    this.matrix = new THREE.Matrix4();
  }
  /** @param {THREE.Vector3} place  m, world @param {number} radius  m */
  draw(place, radius, colour) {
    this.put(this.matrix.compose(place, this.turn, this.size.setScalar(radius)), colour);
  }
}
