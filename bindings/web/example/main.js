// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A heap of boxes. A click or a tap throws a ball at it. docs/web.md says how to serve this folder.
import * as THREE from 'three';
import {STATE, World, init} from 'tandem-physics';

const FRAME = 1 / 60;  // s
const MOST_BODIES = 400;

await init();
const world = new World();
world.addBody({type: 'static', shape: {type: 'halfSpace', normal: [0, 0, 1]}});
for (let k = 0; k < 6; ++k) {
  for (let i = 0; i < 25; ++i) {
    world.addBody({
      shape: {type: 'box', halfExtents: [0.2, 0.2, 0.2]}, density: 200,
      position: [0.45 * (i % 5 - 2), 0.45 * (Math.floor(i / 5) - 2), 0.3 + 0.42 * k],
    });
  }
}
const boxes = world.bodies.length;

const renderer = new THREE.WebGLRenderer({antialias: true});
document.body.append(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color(0xdfe6ee);
scene.add(new THREE.HemisphereLight(0xffffff, 0x887766, 2));
const sun = new THREE.DirectionalLight(0xffffff, 2);
sun.position.set(3, -2, 6);
scene.add(sun);
scene.add(new THREE.Mesh(new THREE.PlaneGeometry(60, 60), new THREE.MeshLambertMaterial({color: 0xb8c0b0})));
const camera = new THREE.PerspectiveCamera(50, 1, 0.1, 100);
camera.up.set(0, 0, 1);
camera.position.set(6, -6, 4);
camera.lookAt(0, 0, 1);

// One call draws all boxes, one all balls.
const drawn = (geometry, colour) => {
  const mesh = new THREE.InstancedMesh(geometry, new THREE.MeshLambertMaterial({color: colour}), MOST_BODIES);
  mesh.frustumCulled = false;
  scene.add(mesh);
  return mesh;
};
const boxMesh = drawn(new THREE.BoxGeometry(0.4, 0.4, 0.4), 0x3f78b5);
const ballMesh = drawn(new THREE.SphereGeometry(0.25, 24, 16), 0xc8553d);

const matrix = new THREE.Matrix4();
const place = new THREE.Vector3();
const turn = new THREE.Quaternion();
const one = new THREE.Vector3(1, 1, 1);

/** The bodies of rows from..to of world.states: the engine's own memory, read once a frame. */
function show(mesh, from, to) {
  const states = world.states;
  for (let row = from; row < to; ++row) {
    place.fromArray(states, row * STATE);
    turn.fromArray(states, row * STATE + 3);
    mesh.setMatrixAt(row - from, matrix.compose(place, turn, one));
  }
  mesh.count = to - from;
  mesh.instanceMatrix.needsUpdate = true;
}

addEventListener('pointerdown', ({clientX, clientY}) => {
  if (world.bodies.length - boxes >= MOST_BODIES) return;
  const ray = new THREE.Raycaster();
  ray.setFromCamera(new THREE.Vector2(2 * clientX / innerWidth - 1, 1 - 2 * clientY / innerHeight), camera);
  world.addBody({
    shape: {type: 'sphere', radius: 0.25}, density: 2000, position: camera.position.toArray(),
    linear: ray.ray.direction.multiplyScalar(15).toArray(), bullet: true,
  });
});

function resize() {
  renderer.setSize(innerWidth, innerHeight);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
}
addEventListener('resize', resize);
resize();

let last = performance.now();
let due = 0;  // s that are not stepped yet
renderer.setAnimationLoop((now) => {
  due = Math.min(due + (now - last) / 1000, 0.1);
  last = now;
  for (; due >= FRAME; due -= FRAME) world.step(FRAME);
  show(boxMesh, 1, boxes);
  show(ballMesh, boxes, world.bodies.length);
  renderer.render(scene, camera);
  document.body.dataset.frames = 1 + Number(document.body.dataset.frames ?? 0);
});
