// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// People in the picture: hands as balls with a line to the held body, heads with a name. World frame, z up, m.
import * as THREE from './three.module.min.js';
import {poseOf, toWorld} from './poses.js';

const HAND_RADIUS = 0.025;  // m
const SIDES = ['left', 'right'];

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
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = THREE.SRGBColorSpace;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({map, depthTest: false}));
  sprite.scale.set(0.42, 0.42 * 48 / 256, 1);
  sprite.renderOrder = 2;
  return sprite;
}

function line(colour) {
  const made = new THREE.Line(new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3()]),
                              new THREE.LineBasicMaterial({color: colour}));
  made.frustumCulled = false;
  return made;
}
function draw({geometry: {attributes: {position}}}, from, to) {
  position.setXYZ(0, ...from);
  position.setXYZ(1, ...to);
  position.needsUpdate = true;
}
function put(thing, {position, orientation}) {
  thing.position.set(...position);
  thing.quaternion.set(...orientation);
}

/** A pointer's grasp. */
class HandMark {
  constructor(name, colour, scene) {
    this.key = name + colour;
    this.ball = new THREE.Mesh(new THREE.SphereGeometry(HAND_RADIUS, 16, 12),
                               new THREE.MeshBasicMaterial({color: colour}));
    this.line = line(colour);
    this.name = label(name, colour);
    this.group = new THREE.Group().add(this.ball, this.line, this.name);
    scene.add(this.group);
  }
  place({anchor, attachment, held}) {
    this.ball.position.set(...anchor);
    this.name.position.set(anchor[0], anchor[1], anchor[2] + 0.1);
    draw(this.line, anchor, toWorld(poseOf(held.body), attachment));
  }
}

/** A headset's user; for the own one only the hands. Parts face -z with y up, as in headsets. */
class PersonMark {
  constructor(name, colour, scene, whole) {
    this.key = name + colour;
    this.group = new THREE.Group();
    const material = new THREE.MeshLambertMaterial({color: colour});
    const dark = new THREE.MeshLambertMaterial({color: 0x22303a});
    const solid = (geometry, of = material) => new THREE.Mesh(geometry, of);
    this.head = new THREE.Group().add(
      solid(new THREE.SphereGeometry(1, 20, 14).scale(0.085, 0.115, 0.1)),
      solid(new THREE.BoxGeometry(0.16, 0.07, 0.05).translate(0, 0.015, -0.095), dark));
    this.name = label(name, colour);
    if (whole) this.group.add(this.head, this.name);
    this.hands = new Map(SIDES.map((side) => [side, new THREE.Group().add(
      solid(new THREE.SphereGeometry(1, 14, 10).scale(0.035, 0.02, 0.05)),
      solid(new THREE.ConeGeometry(0.012, 0.05, 8).rotateX(-Math.PI / 2).translate(0, 0, -0.065), dark))]));
    this.lines = new Map(SIDES.map((side) => [side, line(colour)]));
    this.group.add(...this.hands.values(), ...this.lines.values());
    scene.add(this.group);
  }
  place({head, ...hands}) {
    this.head.visible = this.name.visible = Boolean(head);
    if (head) {
      put(this.head, head);
      this.name.position.set(head.position[0], head.position[1], head.position[2] + 0.22);
    }
    for (const side of SIDES) {
      const hand = hands[side];
      this.hands.get(side).visible = Boolean(hand);
      this.lines.get(side).visible = Boolean(hand?.held);
      if (hand) put(this.hands.get(side), hand.pose);
      if (hand?.held) draw(this.lines.get(side), hand.pose.position, toWorld(poseOf(hand.held.body), hand.attachment));
    }
  }
}

/** All people by key. */
export class Marks {
  #marks = new Map();

  constructor(scene) { this.scene = scene; }
  /** @param {Iterable<object>} people  key, name, colour; of a pointer anchor, attachment, held, else person and own */
  draw(people) {
    const seen = new Set();
    for (const {key, name, colour, person, own, ...hand} of people) {
      seen.add(key);
      const Mark = person ? PersonMark : HandMark;
      let mark = this.#marks.get(key);
      if (mark && (mark.key !== name + colour || !(mark instanceof Mark))) {
        this.scene.remove(mark.group);
        mark = null;
      }
      mark ??= new Mark(name, colour, this.scene, !own);
      this.#marks.set(key, mark);
      mark.place(person ?? hand);
    }
    for (const [key, mark] of this.#marks) {
      if (seen.has(key)) continue;
      this.scene.remove(mark.group);
      this.#marks.delete(key);
    }
  }
}
