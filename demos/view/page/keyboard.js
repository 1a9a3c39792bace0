// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Keys on the canvas: arrows turn the view, with shift they move it, + and - zoom; n and b step through the bodies,
// enter holds the chosen one or releases it; arrows, page up and page down then move the hand; 1 to 9 choose the pane.
import * as THREE from './three.module.min.js';

const TURN = 30;     // CSS pixels of a drag, per press
const ZOOM = 1.15;
const STEP = 0.02;   // fraction of the visible size, per press

const WAYS = {ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0],
              ArrowDown: [0, -1, 0], PageUp: [0, 0, 1], PageDown: [0, 0, -1]};

export class Keyboard {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {import('./input.js').Input} input
   * @param {object} page  panes(), bodies() or null, names() of holdable bodies, orbit,
   *   redraw(), say(text)
   */
  constructor(canvas, input, page) {
    Object.assign(this, {canvas, input, page, pane: 0, body: -1, pointer: null});
    canvas.addEventListener('keydown', (event) => this.key(event));
    canvas.addEventListener('blur', () => this.letGo());
  }

  get holds() { return this.pointer !== null && this.pointer.grab !== null; }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (!this.act(event.key, event.shiftKey)) return;
    event.preventDefault();
    this.page.redraw();
  }

  /** @returns {boolean}  whether the key was handled */
  act(key, shift) {
    const pane = this.page.panes()[this.pane] ?? this.page.panes()[0];
    if (!pane || !this.page.bodies()) return false;
    const way = WAYS[key];
    if (way && this.holds) this.pull(pane, way);
    else if (way && way[2] === 0) this.look(pane, way, shift);
    else if (key === '+' || key === '=') this.page.orbit.zoomBy(ZOOM);
    else if (key === '-') this.page.orbit.zoomBy(1 / ZOOM);
    else if (key === 'n' || key === 'b') this.choose(key === 'n' ? 1 : -1);
    else if (key === 'Enter' && this.holds) this.letGo();
    else if (key === 'Enter') this.take(pane);
    else if (/^[1-9]$/.test(key) && this.page.panes()[key - 1]) this.enter(Number(key) - 1);
    else return false;
    return true;
  }

  look(pane, [right, up], shift) {
    const {orbit} = this.page;
    if (shift) orbit.pan(-TURN * right, TURN * up, pane);
    else orbit.turn(-TURN * right, TURN * up);
  }

  enter(pane) {
    this.letGo();
    this.pane = pane;
    this.page.say(`Pane ${pane + 1}`);
  }

  /** The next holdable body. */
  choose(by) {
    const free = this.page.names();
    if (!free.length || this.holds) return;
    const at = free.findIndex(({body}) => body === this.body);
    const next = free[(Math.max(at, by > 0 ? -1 : 0) + by + free.length) % free.length];
    this.body = next.body;
    this.page.say(`${next.name}: enter to hold it`);
  }

  take(pane) {
    if (this.body < 0) this.choose(1);
    if (this.body < 0) return;
    const point = this.page.bodies().place(pane.peer, this.body).clone();
    this.pointer = this.input.hold('keys', pane, this.body, point);
    if (this.holds) this.page.say('Held: arrows, page up and page down move it, enter lets go');
  }

  pull(pane, [right, up, near]) {
    const camera = this.page.orbit.at(pane.width / pane.height);
    const step = STEP * this.page.orbit.home.height / this.page.orbit.zoom;
    const axis = (k) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, k);
    const {anchor} = this.pointer.grab;
    this.input.pullTo(this.pointer, anchor.clone().addScaledVector(axis(0), step * right)
      .addScaledVector(axis(1), step * up).addScaledVector(axis(2), step * near));
  }

  letGo() {
    if (!this.pointer) return;
    this.input.release('keys');
    this.pointer = null;
    this.page.say('Let go');
    this.page.redraw();
  }
}
