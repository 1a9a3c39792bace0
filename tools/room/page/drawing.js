// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Draws the room, on a screen or in a headset: bodies as instances of few solids. World frame, z up, m.
import * as THREE from './three.module.min.js';
import {STATE} from './tandem.js';
import {Budget} from './budget.js';
import {Marks} from './marks.js';
import {plainMaterial} from './plain.js';
import {drawsInSoftware} from './software.js';

const MOST = 1024;          // instances per solid
const SKY = 0xe9eef2;
const SHADOWS = 1024;       // pixels
const SLOW_MS = 30;         // per picture
const SETTLING = 15;        // pictures
// Steps have priority: pictures become rarer if the mean delay of steps exceeds one step.
const LATE_MS = 16;
const SLOWEST_MS = 250;
const SPARING_MS = 60;      // pause if the processor that steps the world also draws
const COARSER_MS = 120;     // above which pictures are coarser
// Quality levels, ascending: maximum of pixels per CSS pixel. The best has shadows.
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

class Solid {
  constructor(type, scene, plain) {
    this.type = SOLIDS[type];
    this.parts = [];  // {row, local: Matrix4}
    this.lit = new THREE.MeshLambertMaterial();
    this.plain = plainMaterial();
    this.mesh = new THREE.InstancedMesh(this.type.make(), plain ? this.plain : this.lit, MOST);
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

export class Drawing {
  #solids = new Map();
  #simple;         // true: lighting per corner
  #marks;
  #ground;
  #budget = null;  // of a headset's pictures
  #scale = 1;      // of the headset's framebuffer
  #ray = new THREE.Raycaster();
  #matrix = new THREE.Matrix4();
  #body = new THREE.Matrix4();
  #place = new THREE.Vector3();
  #turn = new THREE.Quaternion();
  #interval = 16;  // ms, per picture without the pause, smoothed
  #pause = 0;      // ms
  #last = 0;
  #settled = 0;

  /** @param {HTMLCanvasElement} canvas @param {object} camera  target, distance, azimuth, elevation (degrees) */
  constructor(canvas, camera) {
    this.plain = this.#simple = drawsInSoftware();
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
    const ground = new THREE.Mesh(new THREE.PlaneGeometry(80, 80));
    Object.assign(ground, {lit: new THREE.MeshLambertMaterial({color: colour}), plain: plainMaterial(colour)});
    ground.material = this.plain ? ground.plain : ground.lit;
    ground.receiveShadow = true;
    this.#ground = ground;
    this.scene.add(ground);
    const grid = new THREE.GridHelper(20, 40, 0xb3b8ae, 0xbfc4ba).rotateX(Math.PI / 2);
    grid.position.z = 1e-3;
    this.scene.add(grid);
    this.camera = new THREE.PerspectiveCamera(45, 1, 0.05, 100);
    this.camera.up.set(0, 0, 1);
    // For a headset: its floor's place in the room, and its eyes there.
    this.rig = new THREE.Group();
    this.eyes = new THREE.PerspectiveCamera(70, 1, 0.05, 60);
    this.rig.add(this.eyes);
    this.scene.add(this.rig);
    this.aim = new THREE.Mesh(new THREE.RingGeometry(0.18, 0.25, 32),
                              new THREE.MeshBasicMaterial({color: 0x2b6690, depthTest: false}));
    this.aim.renderOrder = 1;
    this.aim.visible = false;
    this.scene.add(this.aim);
    this.#marks = new Marks(this.scene);
    this.look = {...camera, target: [...camera.target]};
    this.drawn = 0;
  }

  add(row, def) {
    const colour = def.colour ?? '#4f8f8b';
    for (const part of [{shape: def.shape}, ...def.parts ?? []]) {
      const {type} = part.shape;
      if (!SOLIDS[type]) continue;  // the ground is drawn anyway
      if (!this.#solids.has(type)) this.#solids.set(type, new Solid(type, this.scene, this.#simple));
      this.#solids.get(type).add(row, part, colour);
    }
  }

  /** Draws on the screen. @param {Float64Array} states @param {Iterable<object>} people  as Marks has them */
  draw(states, people) {
    this.#update(states, people);
    this.#aim();
    this.renderer.render(this.scene, this.camera);
    ++this.drawn;
  }
  #update(states, people) {
    for (const {mesh, parts} of this.#solids.values()) {
      for (let i = 0; i < parts.length; ++i) {
        const at = parts[i].row * STATE;
        this.#body.compose(this.#place.fromArray(states, at), this.#turn.fromArray(states, at + 3), FULL);
        mesh.setMatrixAt(i, this.#matrix.multiplyMatrices(this.#body, parts[i].local));
      }
      mesh.instanceMatrix.needsUpdate = true;
      mesh.boundingSphere = null;  // otherwise rays would test its old bounds
    }
    this.#marks.draw(people);
  }

  /** @param {function(number, ?XRFrame)} frame  draws each picture, at the display's rate */
  loop(frame) { this.renderer.setAnimationLoop(frame); }
  get referenceSpace() { return this.renderer.xr.getReferenceSpace(); }
  /** Switches pictures to a headset. @param {XRSession} xr */
  async enter(xr) {
    const {renderer} = this;
    renderer.xr.enabled = true;
    this.#budget ??= new Budget(this.plain);
    this.#apply(this.#budget.level);
    this.#scale = this.#budget.level.scale;
    renderer.xr.setFramebufferScaleFactor(this.#scale);
    await renderer.xr.setSession(xr);
  }
  leave() {
    this.renderer.xr.enabled = false;
    this.aim.visible = false;
    this.#apply({shadows: this.quality === BEST, plain: this.plain});
  }
  /**
   * Draws in the headset.
   * @param {XRFrame} frame @param {object} stand @param {?number[]} target  m, aimed position of its user
   * @param {number} now  ms @param {number} late  ms, of the world's steps
   */
  drawHeadset(states, people, {frame, stand, target, now, late}) {
    const hz = this.renderer.xr.getSession().frameRate;
    if (this.#budget.took(now, late, hz)) this.#apply(this.#budget.level);
    const scale = this.#budget.level.scale / this.#scale;
    for (const view of frame.getViewerPose(this.referenceSpace)?.views ?? []) view.requestViewportScale?.(scale);
    this.rig.position.set(...stand.position);
    this.rig.quaternion.set(...stand.orientation);
    this.aim.visible = target !== null;
    if (target) this.aim.position.set(target[0], target[1], 0.005);
    this.#update(states, people);
    this.renderer.render(this.scene, this.eyes);
    ++this.drawn;
  }
  /** Applies a level's simplifications. */
  #apply({shadows, plain}) {
    this.#simple = plain;
    this.renderer.shadowMap.autoUpdate = shadows;
    this.sun.castShadow = shadows;
    for (const solid of this.#solids.values()) solid.mesh.material = plain ? solid.plain : solid.lit;
    this.#ground.material = plain ? this.#ground.plain : this.#ground.lit;
  }

  /** True if a picture is due. @param {number} now  ms @param {number} late  ms, of the world's steps */
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
  /** Reduces quality permanently. */
  #spare() {
    --this.quality;
    this.#settled = this.drawn;
    this.renderer.shadowMap.autoUpdate = false;
    this.sun.castShadow = false;
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
    // A tall picture shows the same width as a wide one.
    const away = distance * Math.max(1, 1.25 / this.camera.aspect);
    const [a, e] = [azimuth * Math.PI / 180, elevation * Math.PI / 180];
    this.camera.position.set(target[0] + away * Math.cos(e) * Math.cos(a), target[1] + away * Math.cos(e) * Math.sin(a),
                             target[2] + away * Math.sin(e));
    this.camera.lookAt(...target);
    this.camera.updateMatrixWorld();
  }

  /** @param {number} x  CSS pixels @returns {?{row: number, point: number[]}}  the body and point there, m */
  pick(x, y) {
    this.#aimRay(x, y);
    const meshes = [...this.#solids.values()].map(({mesh}) => mesh);
    const [hit] = this.#ray.intersectObjects(meshes, false);
    if (!hit) return null;
    const solid = [...this.#solids.values()].find(({mesh}) => mesh === hit.object);
    return {row: solid.parts[hit.instanceId].row, point: hit.point.toArray()};
  }
  /** The point at these pixels on the plane through `through` that faces the camera, m; not below ground. */
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
