// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A figure for each user with a head or a racket, in the user's colour. Figures stand on the ground
// z = 0 and are not part of the world. World frame, m.
import * as THREE from './three.module.min.js';
import {peerColour} from './colours.js';
import {Dots, Sticks} from './marks.js';

const HIP = 0.9;        // m above the ground
const NECK = 0.22;      // m from the centre of the head down to the shoulders
const SHOULDER = 0.2;   // m from the spine
const PLAYER = 1.62;    // m, head of a player with only a racket
const BACK = 2.0;       // m from the net to the players

function partsOf(bodies, user) {
  const find = (name) => bodies.findIndex((body) => body.name === name);
  return {head: find(`head/${user}`), racket: find(`racket/${user}`),
          hands: [0, 1].map((k) => find(`hand/${user}/${k}`)).filter((b) => b >= 0)};
}

export class People extends THREE.Group {
  /** @param {object[]} bodies  of hello */
  constructor(bodies) {
    super();
    this.material = new THREE.MeshStandardMaterial({roughness: 0.7});
    this.sticks = new Sticks(this.material, true);
    this.dots = new Dots(this.material, undefined, true);
    this.add(this.sticks, this.dots);
    const users = [...new Set(bodies.map(({owner}) => owner).filter((u) => Number.isInteger(u)))];
    this.figures = users.map((user) => ({...partsOf(bodies, user),
                                         colour: new THREE.Color(peerColour(user))}))
      .filter(({head, racket}) => head >= 0 || racket >= 0);
  }

  /** @param {Float32Array} positions  of the bodies, as drawn */
  update(positions) {
    this.sticks.clear();
    this.dots.clear();
    const at = (body) => new THREE.Vector3().fromArray(positions, 3 * body);
    for (const {head, racket, hands, colour} of this.figures) {
      if (racket >= 0) this.drawPlayer(at(racket), colour);
      else this.drawPerson(at(head), hands.map(at), colour);
    }
    this.sticks.show();
    this.dots.show();
  }

  drawPlayer(racket, colour) {
    const side = Math.sign(racket.x) || 1;
    // The racket is in the right hand of a player who faces the net, slightly in front of the body.
    const head = new THREE.Vector3(side * Math.max(BACK, Math.abs(racket.x) + 0.25),
                                   0.85 * racket.y - 0.3 * side, PLAYER);
    this.dots.draw(head, 0.115, colour);
    const grip = racket.clone().add(new THREE.Vector3(0.1 * side, 0, -0.1));
    this.limb(racket, grip, 0.014, colour);
    this.draw(head, new THREE.Vector3(-side, 0, 0), [null, grip], colour);
  }

  drawPerson(head, hands, colour) {
    const middle = hands.reduce((sum, hand) => sum.addScaledVector(hand, 1 / hands.length),
                                new THREE.Vector3());
    this.draw(head, hands.length ? middle.sub(head).setZ(0) : new THREE.Vector3(1, 0, 0), hands,
              colour);
  }

  /** @param {THREE.Vector3} facing  level @param {?THREE.Vector3[]} hands  left, right */
  draw(head, facing, hands, colour) {
    const down = (z) => new THREE.Vector3(head.x, head.y, z);
    const chest = head.z - NECK;
    this.limb(down(chest), down(HIP), 0.14, colour);
    this.limb(head, down(chest), 0.05, colour);
    const left = new THREE.Vector3(-facing.y, facing.x, 0).normalize();
    for (const sign of [-1, 1]) {
      const hip = down(HIP).addScaledVector(left, 0.09 * sign);
      this.limb(hip, hip.clone().setZ(0.06), 0.06, colour);
    }
    hands.forEach((hand, k) => {
      const shoulder = down(chest - 0.06).addScaledVector(left, k === 0 ? SHOULDER : -SHOULDER);
      this.limb(shoulder, hand ?? shoulder.clone().setZ(HIP - 0.05), 0.04, colour);
    });
  }

  limb(from, to, radius, colour) {
    this.sticks.draw(from, to, radius, colour);
    this.dots.draw(from, radius, colour);
    this.dots.draw(to, radius, colour);
  }

  dispose() {
    this.material.dispose();
    [this.sticks, this.dots].forEach((marks) => marks.dispose());
  }
}
