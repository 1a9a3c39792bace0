// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Overlays beside the bodies: users' hands, contacts, the positions of remote copies, and this
// page's grabs. World frame, m.
import * as THREE from './three.module.min.js';
import {peerColour} from './colours.js';
import {Dots, Sticks} from './marks.js';

const CONTACT = new THREE.Color('#e5484d');
const ELSEWHERE = new THREE.Color('#8a94a0');  // peers without a pane here

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

export class Overlays extends THREE.Group {
  /** @param {object[]} peers  of hello @param {number} size  m, width of the scene */
  constructor(peers, size) {
    super();
    this.size = size;
    this.materials = {mark: new THREE.MeshStandardMaterial({roughness: 0.5})};
    this.time = NaN;  // s, session time as drawn
    this.seen = [];   // marks of each peer as drawn
    this.peers = peers.map(() => new PeerMarks(this.materials));
    this.colours = peers.map(({id}) => new THREE.Color(peerColour(id - 1)));
    this.add(...this.peers);
  }

  /**
   * @param {import('./timeline.js').Timeline} timeline  gives the playhead
   * @param {import('./scene.js').Bodies} bodies  as they are drawn
   * @param {object[]} grabs  of this page, see input.js
   * @param {boolean} all  more than the hands
   */
  update(timeline, bodies, grabs, all) {
    this.time = timeline.time;
    this.seen = bodies.shown.slice(0, timeline.after.peers.length)
      .map((shown, p) => timeline.marks(p, shown));
    this.peers.forEach((marks, p) => {
      marks.all.forEach((mark) => mark.clear());
      for (const spring of this.seen[p]?.springs ?? []) this.drawHand(marks, spring, all);
      if (all && this.seen[p]) this.drawBehind(marks, p, this.seen[p], bodies);
      for (const grab of grabs) {
        if (grab.peer === p) this.drawGrab(marks, p, grab, bodies);
      }
      marks.all.forEach((mark) => mark.show());
    });
  }

  drawHand(marks, {anchor, attachment, user}, coil) {
    const unit = 0.01 * this.size;
    const colour = this.colours[user] ?? ELSEWHERE;
    const from = new THREE.Vector3(...attachment);
    const to = new THREE.Vector3(...anchor);
    if (coil) marks.sticks.addCoil(from, to, 0.9 * unit, colour);
    else marks.sticks.draw(from, to, 0.35 * unit, colour);
    marks.dots.draw(to, 1.3 * unit, colour);
    marks.dots.draw(from, 0.6 * unit, colour);
  }

  drawBehind(marks, p, {contacts, targets}, bodies) {
    const unit = 0.01 * this.size;
    const from = new THREE.Vector3();
    const to = new THREE.Vector3();
    for (const {point, normal} of contacts) {
      from.fromArray(point);
      to.fromArray(normal).multiplyScalar(1.6 * unit).add(from);
      marks.sticks.draw(from, to, 0.1 * unit, CONTACT);
      marks.dots.draw(from, 0.28 * unit, CONTACT);
    }
    for (const {body, peer, position} of targets) {
      to.fromArray(position);
      const colour = this.colours[peer] ?? ELSEWHERE;
      marks.targets.draw(to, 1.2 * unit, colour);
      marks.sticks.draw(bodies.place(p, body, from), to, 0.25 * unit, colour);
    }
  }

  /** The page's target of its hand; the hand itself is among the peer's springs. */
  drawGrab(marks, p, grab, bodies) {
    const unit = 0.01 * this.size;
    const from = grab.local.clone().applyMatrix4(bodies.bodyMatrix(p, grab.body));
    marks.sticks.draw(from, grab.anchor, 0.15 * unit, this.colours[p]);
    marks.dots.draw(grab.anchor, 0.8 * unit, this.colours[p]);
  }

  /** @param {Set<number>} peers  visible peers */
  show(peers) {
    this.peers.forEach((marks, p) => { marks.visible = peers.has(p); });
  }

  dispose() {
    this.materials.mark.dispose();
    for (const marks of this.peers) marks.all.forEach((mark) => mark.dispose());
  }
}
