// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Static parts: solids, and half-spaces as a ground with a grid or as walls that are visible only
// from inside. World frame, z up, m.
import * as THREE from './three.module.min.js';
import {perpendicular, solidOf} from './geometry.js';

const FAR = 200;  // m, extent of a ground

/** A scene's colours: of the ground, and of static solids, in order. */
const PAINT = {
  tennis: {ground: '#b5654a', solids: ['#1f6fb2', '#eef3f6']},
  room: {ground: '#b08d66', solids: ['#8a5a33', '#8a5a33', '#8a5a33']},
};

/** Cuts a polygon by a half-space and keeps the outside. */
function cut(polygon, normal, offset) {
  const result = [];
  polygon.forEach((a, i) => {
    const b = polygon[(i + 1) % polygon.length];
    const da = normal.dot(a) - offset;
    const db = normal.dot(b) - offset;
    if (da >= -1e-9) result.push(a);
    if ((da > 1e-9 && db < -1e-9) || (da < -1e-9 && db > 1e-9)) {
      result.push(a.clone().lerp(b, da / (da - db)));
    }
  });
  return result;
}

/** The polygon of a plane that remains after all other half-spaces and a ceiling. */
function planePolygon(plane, planes, height) {
  const {normal, offset} = plane;
  const side = perpendicular(normal);
  const up = new THREE.Vector3().crossVectors(normal, side);
  const corner = (a, b) => normal.clone().multiplyScalar(offset)
    .addScaledVector(side, a * FAR).addScaledVector(up, b * FAR);
  let polygon = [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)];
  for (const other of planes) {
    if (other !== plane) polygon = cut(polygon, other.normal, other.offset);
  }
  return cut(polygon, new THREE.Vector3(0, 0, -1), -height);
}

function polygonGeometry(polygon, normal) {
  const geometry = new THREE.BufferGeometry().setFromPoints(polygon);
  const index = [];
  for (let i = 2; i < polygon.length; ++i) index.push(0, i - 1, i);
  geometry.setIndex(index);
  const normals = polygon.flatMap(() => normal.toArray());
  geometry.setAttribute('normal', new THREE.BufferAttribute(new Float32Array(normals), 3));
  return geometry;
}

/** The largest of 1, 2, 5, 10, 20, .. that does not exceed a value. */
function niceStep(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  return decade * [5, 2, 1].find((step) => step * decade <= value * 1.0001);
}

/** Paints grid lines of two spacings (m) in world x and y onto a standard material. */
function withGrid(material, uniforms) {
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', '#include <common>\nvarying vec3 vPlace;')
      .replace('#include <worldpos_vertex>',
               '#include <worldpos_vertex>\nvPlace = (modelMatrix * vec4(position, 1.0)).xyz;');
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', `#include <common>
        varying vec3 vPlace;
        uniform float uCell;
        uniform vec3 uLine;
        float gridLine(vec2 p, float width) {
          vec2 w = fwidth(p);
          vec2 d = abs(fract(p - 0.5) - 0.5) / max(w, 1e-6);
          float line = 1.0 - min(min(d.x, d.y) / width, 1.0);
          return line * (1.0 - smoothstep(0.06, 0.3, max(w.x, w.y)));
        }`)
      .replace('#include <color_fragment>', `#include <color_fragment>
        float fine = gridLine(vPlace.xy / uCell, 1.0);
        float coarse = gridLine(vPlace.xy / (5.0 * uCell), 1.4);
        diffuseColor.rgb = mix(diffuseColor.rgb, uLine, max(0.3 * fine, 0.75 * coarse));`);
  };
  return material;
}

/** Ground, walls and other static parts; visible in all panes. */
export class Fixed extends THREE.Group {
  /**
   * @param {object[]} parts  of hello
   * @param {string} scene    selects the colours
   * @param {number} size     m, width of the scene
   * @param {object} theme    colours, see stage.js
   */
  constructor(parts, scene, size, theme) {
    super();
    this.own = PAINT[scene] ?? {solids: []};
    this.boxes = [];
    this.painted = [];
    this.uniforms = {uCell: {value: niceStep(size / 20)}, uLine: {value: new THREE.Color()}};
    this.solid = new THREE.MeshStandardMaterial({roughness: 0.85, vertexColors: true});
    this.ground = withGrid(new THREE.MeshStandardMaterial({roughness: 1}), this.uniforms);
    this.wall = new THREE.MeshStandardMaterial({roughness: 1});
    this.addPlanes(parts.filter((part) => part.shape === 'half_space'), size);
    const solids = parts.filter((part) => part.shape !== 'half_space');
    solids.forEach((part, k) => this.addSolid(part, k, size));
    if (scene === 'tennis') this.addLines(solids[0]);
    this.paint(theme);
  }

  addSolid(part, k, size) {
    const solid = solidOf(part, `fixed ${k}`, false);
    if (!solid) return;
    const mesh = new THREE.Mesh(solid.make(1), this.materialOf(this.own.solids[k]));
    const [x, y, z, qx, qy, qz, qw] = part.pose;
    mesh.position.set(x, y, z);
    mesh.quaternion.set(qx, qy, qz, qw);
    mesh.scale.set(...solid.scale);
    mesh.receiveShadow = true;
    // Walls around a whole scene would darken it.
    mesh.castShadow = part.shape !== 'box' || solid.radius < 0.7 * size;
    if (part.shape === 'box') this.boxes.push(mesh);
    this.add(mesh);
  }

  /** The material of static solids, or one with a given colour. */
  materialOf(colour) {
    if (!colour) return this.solid;
    const material = new THREE.MeshStandardMaterial({color: colour, roughness: 0.7});
    this.painted.push(material);
    return material;
  }

  /** White lines along the edges of a table and down its middle. */
  addLines({half_extents: [hx, hy, hz], pose: [x, y, z]}) {
    const white = this.materialOf('#f4f7fa');
    const width = 0.02;
    const lines = [[0, hy - width / 2, hx, width / 2], [0, width / 2 - hy, hx, width / 2],
                   [hx - width / 2, 0, width / 2, hy], [width / 2 - hx, 0, width / 2, hy],
                   [0, 0, hx, width / 6]];
    for (const [cx, cy, dx, dy] of lines) {
      const mesh = new THREE.Mesh(new THREE.BoxGeometry(2 * dx, 2 * dy, 0.002), white);
      mesh.position.set(x + cx, y + cy, z + hz + 0.001);
      mesh.receiveShadow = true;
      this.add(mesh);
    }
  }

  /**
   * Hides boxes in front of the target, for a view into rooms with solid walls.
   * @param {THREE.Camera} camera
   * @param {THREE.Vector3} target  m, of the camera
   * @param {number} width          m, visible width at the target
   */
  clearTheWay(camera, target, width) {
    const side = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 0);
    const places = [-0.3, 0, 0.3].map((f) => target.clone().addScaledVector(side, f * width));
    const ray = new THREE.Ray();
    const hit = new THREE.Vector3();
    for (const mesh of this.boxes) {
      mesh.updateMatrixWorld();
      mesh.geometry.boundingBox ?? mesh.geometry.computeBoundingBox();
      const toLocal = mesh.matrixWorld.clone().invert();
      mesh.visible = !places.some((place) => {
        const [from, to] = [camera.position, place].map((p) => p.clone().applyMatrix4(toLocal));
        const length = from.distanceTo(to);
        ray.set(from, to.sub(from).normalize());
        const found = ray.intersectBox(mesh.geometry.boundingBox, hit);
        return found !== null && found.distanceTo(from) < 0.97 * length;
      });
    }
  }

  addPlanes(parts, size) {
    const planes = parts.map((part) => {
      const [x, y, z, qx, qy, qz, qw] = part.pose ?? [0, 0, 0, 0, 0, 0, 1];
      const normal = new THREE.Vector3(...part.normal)
        .applyQuaternion(new THREE.Quaternion(qx, qy, qz, qw)).normalize();
      return {normal, offset: part.offset + normal.dot(new THREE.Vector3(x, y, z))};
    });
    const floor = planes.find((plane) => plane.normal.z > 0.99)?.offset ?? 0;
    for (const plane of planes) {
      const ground = plane.normal.z > 0.7;
      const height = ground ? FAR : floor + 0.45 * size;
      const polygon = planePolygon(plane, planes, height);
      if (polygon.length < 3) continue;
      const mesh = new THREE.Mesh(polygonGeometry(polygon, plane.normal),
                                  ground ? this.ground : this.wall);
      mesh.receiveShadow = true;
      this.add(mesh);
    }
  }

  /** @param {object} theme  colours, see stage.js */
  paint(theme) {
    this.uniforms.uLine.value.set(theme.line);
    this.ground.color.set(this.own.ground ?? theme.ground);
    if (this.own.ground) {
      this.ground.color.multiplyScalar(theme.dim);
      this.uniforms.uLine.value.copy(this.ground.color).lerp(new THREE.Color('#fff'), 0.1);
    }
    // Walls face away from the sun.
    this.wall.color.set(theme.wall);
    this.wall.emissive.set(theme.wall).multiplyScalar(0.3);
    this.solid.color.set(theme.fixed);
  }

  dispose() {
    this.children.forEach((mesh) => mesh.geometry.dispose());
    [this.solid, this.ground, this.wall, ...this.painted].forEach((material) => material.dispose());
  }
}
