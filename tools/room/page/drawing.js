// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The room as a picture: bodies as instances of few solids, hands as lines with a name. World frame, z up, m.
import * as THREE from './three.module.min.js';
import {STATE} from './tandem.js';
import {rotated} from './hand.js';
import {plainMaterial} from './plain.js';
import {drawsInSoftware} from './software.js';

const MOST = 1024;          // instances of one solid
const SKY = 0xe9eef2;
const HAND_RADIUS = 0.025;  // m
const SHADOWS = 1024;       // pixels
const SLOW_MS = 30;         // from picture to picture
const SETTLING = 15;        // pictures
// Pictures give way to steps: where these are late by more than one on average, pictures come more seldom.
const LATE_MS = 16;
const SLOWEST_MS = 250;
const SPARING_MS = 60;      // what computes the picture is the processor that steps the world
const COARSER_MS = 120;     // from where on pictures are coarser
// Of the picture's quality, from the least: pixels each CSS pixel at most. The best has shadows.
const RATIOS = [0.5, 0.75, 2, 2];
const BEST = 3;
const PLAIN = 1;
const FULL = new THREE.Vector3(1, 1, 1);

const SOLIDS = {
  box: {make: () => new THREE.BoxGeometry(2, 2, 2), scale: ({halfExtents}) => halfExtents},
  sphere: {make: () => new THREE.SphereGeometry(1, 28, 18).rotateX(Math.PI / 2), scale: ({radius: r}) => [r, r, r]},
  cylinder: {make: () => new THREE.CylinderGeometry(1, 1, 2, 32).rotateX(Math.PI / 2),
             scale: ({radius: r, halfHeight: h}) => [r, r, h]},
};

/** One kind of solid. */
class Solid {
  constructor(type, scene, plain) {
    this.type = SOLIDS[type];
    this.parts = [];  // {row, local: Matrix4}
    const material = plain ? plainMaterial() : new THREE.MeshLambertMaterial();
    this.mesh = new THREE.InstancedMesh(this.type.make(), material, MOST);
    this.mesh.count = 0;
    this.mesh.castShadow = this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false;
    scene.add(this.mesh);
  }
  add(row, {shape, position = [0, 0, 0], orientation = [0, 0, 0, 1]}, colour) {
    if (this.parts.length >= MOST) return;
    const local = new THREE.Matrix4().compose(new THREE.Vector3(...position), new THREE.Quaternion(...orientation),
                                              new THREE.Vector3(...this.type.scale(shape)));
    this.mesh.setColorAt(this.parts.length, new THREE.Color(colour));
    this.mesh.instanceColor.needsUpdate = true;
    this.mesh.count = this.parts.push({row, local});
  }
}

/** A name over a hand. */
function label(text, colour) {
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [256, 48];
  const pen = canvas.getContext('2d');
  pen.font = '600 30px system-ui, sans-serif';
  const width = Math.min(248, pen.measureText(text).width + 20);
  pen.fillStyle = colour;
  pen.beginPath();
  pen.roundRect(128 - width / 2, 2, width, 44, 12);
  pen.fill();
  pen.fillStyle = '#ffffff';
  pen.textAlign = 'center';
  pen.fillText(text, 128, 35, 236);
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({map: new THREE.CanvasTexture(canvas), depthTest: false}));
  sprite.scale.set(0.42, 0.42 * 48 / 256, 1);
  sprite.renderOrder = 2;
  return sprite;
}

class HandMark {
  constructor(name, colour, scene) {
    this.key = name + colour;
    const material = new THREE.MeshBasicMaterial({color: colour});
    this.ball = new THREE.Mesh(new THREE.SphereGeometry(HAND_RADIUS, 16, 12), material);
    this.line = new THREE.Line(new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3()]),
                               new THREE.LineBasicMaterial({color: colour}));
    this.line.frustumCulled = false;
    this.name = label(name, colour);
    this.group = new THREE.Group().add(this.ball, this.line, this.name);
    scene.add(this.group);
  }
  place(anchor, point) {
    this.ball.position.set(...anchor);
    this.name.position.set(anchor[0], anchor[1], anchor[2] + 0.1);
    const {position} = this.line.geometry.attributes;
    position.setXYZ(0, ...anchor);
    position.setXYZ(1, ...point);
    position.needsUpdate = true;
  }
}

export class Drawing {
  #solids = new Map();
  #marks = new Map();
  #ray = new THREE.Raycaster();
  #matrix = new THREE.Matrix4();
  #body = new THREE.Matrix4();
  #place = new THREE.Vector3();
  #turn = new THREE.Quaternion();
  #interval = 16;  // ms, from picture to picture beyond the pause, smoothed
  #pause = 0;      // ms
  #last = 0;
  #settled = 0;

  /** @param {HTMLCanvasElement} canvas @param {object} camera  target, distance, azimuth, elevation (degrees) */
  constructor(canvas, camera) {
    this.plain = drawsInSoftware();
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: !this.plain});
    this.renderer.shadowMap.enabled = !this.plain;
    this.quality = this.plain ? PLAIN : BEST;
    this.#pause = this.plain ? SPARING_MS : 0;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(SKY);
    this.scene.fog = new THREE.Fog(SKY, 12, 40);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x99938a, 2.1));
    const sun = new THREE.DirectionalLight(0xfff4e0, 1.8);
    sun.position.set(2.5, -2, 6);
    sun.castShadow = true;
    sun.shadow.mapSize.set(SHADOWS, SHADOWS);
    Object.assign(sun.shadow.camera, {left: -4, right: 4, top: 4, bottom: -4, near: 1, far: 14});
    sun.shadow.bias = -0.002;
    this.scene.add(sun);
    this.sun = sun;
    const colour = 0xcfd3c9;
    const ground = new THREE.Mesh(new THREE.PlaneGeometry(80, 80),
                                  this.plain ? plainMaterial(colour) : new THREE.MeshLambertMaterial({color: colour}));
    ground.receiveShadow = true;
    this.scene.add(ground);
    const grid = new THREE.GridHelper(20, 40, 0xb3b8ae, 0xbfc4ba).rotateX(Math.PI / 2);
    grid.position.z = 1e-3;
    this.scene.add(grid);
    this.camera = new THREE.PerspectiveCamera(45, 1, 0.05, 100);
    this.camera.up.set(0, 0, 1);
    this.look = {...camera, target: [...camera.target]};
    this.drawn = 0;
  }

  add(row, def) {
    const colour = def.colour ?? '#4f8f8b';
    for (const part of [{shape: def.shape}, ...def.parts ?? []]) {
      const {type} = part.shape;
      if (!SOLIDS[type]) continue;  // the ground is drawn anyway
      if (!this.#solids.has(type)) this.#solids.set(type, new Solid(type, this.scene, this.plain));
      this.#solids.get(type).add(row, part, colour);
    }
  }

  /** @param {Float64Array} states @param {Iterable<object>} hands  key, name, colour, anchor, attachment, held */
  draw(states, hands) {
    for (const {mesh, parts} of this.#solids.values()) {
      for (let i = 0; i < parts.length; ++i) {
        const at = parts[i].row * STATE;
        this.#body.compose(this.#place.fromArray(states, at), this.#turn.fromArray(states, at + 3), FULL);
        mesh.setMatrixAt(i, this.#matrix.multiplyMatrices(this.#body, parts[i].local));
      }
      mesh.instanceMatrix.needsUpdate = true;
      mesh.boundingSphere = null;  // else rays are tried against where it once was
    }
    this.#drawHands(hands);
    this.#aim();
    this.renderer.render(this.scene, this.camera);
    ++this.drawn;
  }

  /** Whether it is time for a picture. @param {number} now  ms @param {number} late  ms, of the world's steps */
  due(now, late) {
    const since = now - this.#last;
    if (since < this.#pause) return false;
    this.#last = now;
    if (since < 1000) this.#interval += 0.05 * (since - this.#pause - this.#interval);
    if (late > LATE_MS) this.#pause = Math.min(SLOWEST_MS, 1.5 * Math.max(this.#pause, LATE_MS));
    else if (late < LATE_MS / 2) this.#pause = Math.max(this.plain ? SPARING_MS : 0, 0.9 * this.#pause - 1);
    const slow = this.#interval > SLOW_MS || this.#pause > COARSER_MS;
    if (slow && this.quality > 0 && this.drawn > this.#settled + SETTLING) this.#spare();
    return true;
  }
  /** A picture that is quicker, for good. */
  #spare() {
    --this.quality;
    this.#settled = this.drawn;
    this.renderer.shadowMap.autoUpdate = false;
    this.sun.castShadow = false;
  }

  #drawHands(hands) {
    const seen = new Set();
    for (const {key, name, colour, anchor, attachment, held} of hands) {
      seen.add(key);
      let mark = this.#marks.get(key);
      if (mark && mark.key !== name + colour) {
        this.scene.remove(mark.group);
        mark = null;
      }
      mark ??= new HandMark(name, colour, this.scene);
      this.#marks.set(key, mark);
      const {position, orientation} = held.body;
      mark.place(anchor, rotated([...orientation], attachment).map((x, i) => x + position[i]));
    }
    for (const [key, mark] of this.#marks) {
      if (seen.has(key)) continue;
      this.scene.remove(mark.group);
      this.#marks.delete(key);
    }
  }
  #aim() {
    const canvas = this.renderer.domElement;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const ratio = Math.min(devicePixelRatio, RATIOS[this.quality]);
    if (canvas.width !== Math.floor(width * ratio) || canvas.height !== Math.floor(height * ratio)) {
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
    }
    const {target, distance, azimuth, elevation} = this.look;
    // A tall picture shows as much across as a wide one.
    const away = distance * Math.max(1, 1.25 / this.camera.aspect);
    const [a, e] = [azimuth * Math.PI / 180, elevation * Math.PI / 180];
    this.camera.position.set(target[0] + away * Math.cos(e) * Math.cos(a), target[1] + away * Math.cos(e) * Math.sin(a),
                             target[2] + away * Math.sin(e));
    this.camera.lookAt(...target);
    this.camera.updateMatrixWorld();
  }

  /** @param {number} x  CSS pixels @returns {?{row: number, point: number[]}}  what is there, m */
  pick(x, y) {
    this.#aimRay(x, y);
    const meshes = [...this.#solids.values()].map(({mesh}) => mesh);
    const [hit] = this.#ray.intersectObjects(meshes, false);
    if (!hit) return null;
    const solid = [...this.#solids.values()].find(({mesh}) => mesh === hit.object);
    return {row: solid.parts[hit.instanceId].row, point: hit.point.toArray()};
  }
  /** The point at these pixels on the plane through `through` that faces the camera, m; no lower than the ground. */
  pointAt(x, y, through) {
    this.#aimRay(x, y);
    const normal = this.camera.getWorldDirection(new THREE.Vector3());
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(normal, new THREE.Vector3(...through));
    const point = this.#ray.ray.intersectPlane(plane, new THREE.Vector3());
    return point ? [point.x, point.y, Math.max(0.02, point.z)] : null;
  }
  /** CSS pixels of a point, m. */
  project(point) {
    const canvas = this.renderer.domElement;
    const v = new THREE.Vector3(...point).project(this.camera);
    return [(v.x + 1) / 2 * canvas.clientWidth, (1 - v.y) / 2 * canvas.clientHeight];
  }
  #aimRay(x, y) {
    const {clientWidth, clientHeight} = this.renderer.domElement;
    this.#ray.setFromCamera(new THREE.Vector2(2 * x / clientWidth - 1, 1 - 2 * y / clientHeight), this.camera);
  }
}
