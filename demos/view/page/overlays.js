// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What is behind the poses: contacts, springs of users, where others are believed to have a body.
// And what this page's own user holds. World frame, m.
import * as THREE from './three.module.min.js';
import {peerColour} from './colours.js';
import {Dots, Sticks} from './marks.js';

const CONTACT = new THREE.Color('#e5484d');
const ELSEWHERE = new THREE.Color('#8a94a0');  // peers that have no pane here

/** Marks of one peer. */
class PeerMarks extends THREE.Group {
  constructor(materials) {
    super();
    this.sticks = new Sticks(materials.mark);
    this.dots = new Dots(materials.mark);
    this.targets = new Dots(materials.mark, new THREE.OctahedronGeometry(1));
    this.all = [this.sticks, this.dots, this.targets];
    this.add(...this.all);
  }
}

/** The marks of all peers. */
export class Overlays extends THREE.Group {
  /** @param {number} peers @param {number} size  m, how wide the scene is */
  constructor(peers, size) {
    super();
    this.size = size;
    this.materials = {mark: new THREE.MeshStandardMaterial({roughness: 0.5})};
    this.peers = Array.from({length: peers}, () => new PeerMarks(this.materials));
    this.colours = this.peers.map((_, p) => new THREE.Color(peerColour(p)));
    this.add(...this.peers);
  }

  /**
   * @param {?import('./protocol.js').Frame} frame  the last one
   * @param {import('./scene.js').Bodies} bodies
   * @param {object[]} grabs  of this page, see input.js
   */
  update(frame, bodies, grabs) {
    this.peers.forEach((marks, p) => {
      marks.all.forEach((mark) => mark.clear());
      const overlays = frame?.peers[p].overlays;
      if (overlays) this.drawOverlays(marks, p, overlays, bodies);
      for (const grab of grabs) {
        if (grab.peer === p) this.drawGrab(marks, p, grab, bodies, overlays);
      }
      marks.all.forEach((mark) => mark.show());
    });
  }

  drawOverlays(marks, p, overlays, bodies) {
    const unit = 0.01 * this.size;
    const from = new THREE.Vector3();
    const to = new THREE.Vector3();
    for (const {point, normal} of overlays.contacts) {
      from.fromArray(point);
      to.fromArray(normal).multiplyScalar(1.6 * unit).add(from);
      marks.sticks.draw(from, to, 0.1 * unit, CONTACT);
      marks.dots.draw(from, 0.28 * unit, CONTACT);
    }
    for (const {anchor, attachment, user} of overlays.springs) {
      const colour = this.colours[user] ?? ELSEWHERE;
      from.fromArray(attachment);
      to.fromArray(anchor);
      marks.sticks.addCoil(from, to, 0.9 * unit, colour);
      marks.dots.draw(to, 1.3 * unit, colour);
      marks.dots.draw(from, 0.6 * unit, colour);
    }
    for (const {body, peer, position} of overlays.targets) {
      to.fromArray(position);
      const colour = this.colours[peer] ?? ELSEWHERE;
      marks.targets.draw(to, 1.2 * unit, colour);
      marks.sticks.draw(bodies.place(p, body, from), to, 0.25 * unit, colour);
    }
  }

  drawGrab(marks, p, grab, bodies, overlays) {
    const unit = 0.01 * this.size;
    const from = grab.local.clone().applyMatrix4(bodies.bodyMatrix(p, grab.body));
    // With overlays on, the spring is among what the server tells.
    if (!overlays) marks.sticks.addCoil(from, grab.anchor, 0.9 * unit, this.colours[p]);
    marks.dots.draw(grab.anchor, 1.3 * unit, this.colours[p]);
    marks.dots.draw(from, 0.7 * unit, this.colours[p]);
  }

  /** @param {Set<number>} peers  who is seen */
  show(peers) {
    this.peers.forEach((marks, p) => { marks.visible = peers.has(p); });
  }

  dispose() {
    this.materials.mark.dispose();
    for (const marks of this.peers) {
      for (const mark of marks.all) {
        mark.geometry.dispose();
        mark.mesh.dispose();
      }
    }
  }
}
