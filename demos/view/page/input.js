// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Mouse, pen and fingers on the canvas. Pressing on a body grabs it and drags it in the plane that
// faces the camera; elsewhere dragging turns the view; two fingers or the wheel zoom.
import * as THREE from './three.module.min.js';
import {paneAt} from './panes.js';

const MOST_GRABS = 8;      // per connection
const MOVES = 120;         // per second, of all grabs; the server accepts twice as many messages
const FARTHEST = 99;       // m, bound on an anchor's coordinates

/**
 * @typedef {object} Grab
 * @property {number} id
 * @property {number} peer    of the user who holds
 * @property {number} body    index in hello
 * @property {THREE.Vector3} local   m, frame of the body: the held point
 * @property {THREE.Vector3} anchor  m, world: the target
 */

/** Turns pointers into grabs and views. */
export class Input {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {object} page  panes(), bodies() or null, orbit, send(message), redraw()
   */
  constructor(canvas, page) {
    this.canvas = canvas;
    this.page = page;
    this.pointers = new Map();
    this.nextId = 1;
    this.ray = new THREE.Raycaster();
    const on = (name, handle) => canvas.addEventListener(name, handle.bind(this));
    on('pointerdown', this.down);
    on('pointermove', this.move);
    on('pointerup', this.up);
    on('pointercancel', this.up);
    on('lostpointercapture', this.up);
    canvas.addEventListener('wheel', this.wheel.bind(this), {passive: false});
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('dblclick', this.double.bind(this));
  }

  /** @returns {Grab[]}  present grabs */
  grabs() {
    return [...this.pointers.values()].flatMap((pointer) => pointer.grab ?? []);
  }
  /** The connection is gone, and all grabs with it. */
  letGo() {
    for (const pointer of this.pointers.values()) pointer.grab = null;
  }

  /** Aims the ray through a point of a pane. @param {number} x  CSS pixels of the canvas */
  aim(pane, x, y) {
    const camera = this.page.orbit.at(pane.width / pane.height);
    this.ray.setFromCamera(new THREE.Vector2(2 * (x - pane.x) / pane.width - 1,
                                             1 - 2 * (y - pane.y) / pane.height), camera);
    this.ray.near = camera.near;
    this.ray.far = camera.far;
    return camera;
  }
  /** @param {number} x  CSS pixels of the canvas @param {number} y
   *  @returns {?{body: number, point: THREE.Vector3}}  the body and point to grab there */
  hitAt(x, y) {
    const pane = paneAt(this.page.panes(), x, y);
    if (!pane || !this.page.bodies()) return null;
    this.aim(pane, x, y);
    return this.page.bodies().hit(this.ray, pane.peer);
  }
  at(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  down(event) {
    const [x, y] = this.at(event);
    const pane = paneAt(this.page.panes(), x, y);
    if (!pane) return;
    event.preventDefault();
    this.canvas.focus({preventScroll: true});
    this.canvas.setPointerCapture(event.pointerId);
    const pointer = {x, y, pane, grab: null, pans: event.button === 2 || event.shiftKey};
    this.pointers.set(event.pointerId, pointer);
    if (event.button === 0 && !event.shiftKey) this.take(pointer);
    this.canvas.classList.toggle('holding', this.grabs().length > 0);
    this.page.redraw();
  }

  take(pointer) {
    const bodies = this.page.bodies();
    if (!bodies || this.grabs().length >= MOST_GRABS) return;
    const {pane} = pointer;
    const camera = this.aim(pane, pointer.x, pointer.y);
    const hit = bodies.hit(this.ray, pane.peer);
    if (!hit) return;
    const facing = camera.getWorldDirection(new THREE.Vector3());
    pointer.plane = new THREE.Plane().setFromNormalAndCoplanarPoint(facing, hit.point);
    pointer.grab = this.grab(pane.peer, hit.body, hit.point);
  }

  grab(peer, body, point) {
    const toLocal = this.page.bodies().bodyMatrix(peer, body).clone().invert();
    const grab = {id: this.nextId++, peer, body, anchor: point.clone(), sent: 0,
                  local: point.clone().applyMatrix4(toLocal)};
    this.page.send({type: 'grab', id: grab.id, pane: peer, body, point: point.toArray()});
    return grab;
  }

  /**
   * Holds a body without a pointer.
   * @param {string} id  of the hand
   * @returns {?object}  null if there are too many grabs
   */
  hold(id, pane, body, point) {
    if (this.grabs().length >= MOST_GRABS) return null;
    const pointer = {x: NaN, y: NaN, pane, grab: this.grab(pane.peer, body, point)};
    this.pointers.set(id, pointer);
    return pointer;
  }

  move(event) {
    const pointer = this.pointers.get(event.pointerId);
    const [x, y] = this.at(event);
    if (!pointer) {
      this.hover(event, x, y);
      return;
    }
    const dx = x - pointer.x;
    const dy = y - pointer.y;
    const old = {x: pointer.x, y: pointer.y};
    pointer.x = x;
    pointer.y = y;
    if (pointer.grab) {
      this.pull(pointer);
    } else {
      this.look(event.pointerId, pointer, dx, dy, old);
    }
    this.page.redraw();
  }

  /** Shows a hand cursor over bodies that can be held. */
  hover(event, x, y) {
    const now = performance.now();
    if (event.pointerType !== 'mouse' || now - (this.hovered ?? 0) < 80) return;
    this.hovered = now;
    this.canvas.classList.toggle('over', this.hitAt(x, y) !== null);
  }

  pull(pointer) {
    this.aim(pointer.pane, pointer.x, pointer.y);
    const place = this.ray.ray.intersectPlane(pointer.plane, new THREE.Vector3());
    if (place) this.pullTo(pointer, place);
  }

  /** @param {object} pointer  with a grab @param {THREE.Vector3} place  m, world */
  pullTo(pointer, place) {
    if (place.toArray().some((v) => Math.abs(v) > FARTHEST)) return;
    pointer.grab.anchor.copy(place);
    pointer.grab.moved = true;
    this.flush();
  }

  /** Sends anchors to the server at a limited rate; call it regularly. */
  flush() {
    const grabs = this.grabs();
    const now = performance.now();
    for (const grab of grabs) {
      if (!grab.moved || now - grab.sent < 1000 * grabs.length / MOVES) continue;
      grab.moved = false;
      grab.sent = now;
      this.page.send({type: 'move', id: grab.id, point: grab.anchor.toArray()});
    }
  }

  look(id, pointer, dx, dy, old) {
    const {orbit} = this.page;
    const other = [...this.pointers].find(([key, p]) => key !== id && !p.grab)?.[1];
    if (other) {
      const before = Math.hypot(old.x - other.x, old.y - other.y);
      const after = Math.hypot(pointer.x - other.x, pointer.y - other.y);
      if (before > 1 && after > 1) orbit.zoomBy(after / before);
      orbit.pan(dx / 2, dy / 2, pointer.pane);
    } else if (pointer.pans) {
      orbit.pan(dx, dy, pointer.pane);
    } else {
      orbit.turn(dx, dy);
    }
  }

  up(event) {
    this.release(event.pointerId);
  }

  /** @param {number|string} id  of a pointer, or of a hand without one */
  release(id) {
    const pointer = this.pointers.get(id);
    if (!pointer) return;
    this.pointers.delete(id);
    if (pointer.grab) {
      if (pointer.grab.moved) {
        this.page.send({type: 'move', id: pointer.grab.id, point: pointer.grab.anchor.toArray()});
      }
      this.page.send({type: 'release', id: pointer.grab.id});
    }
    this.canvas.classList.toggle('holding', this.grabs().length > 0);
    this.page.redraw();
  }

  wheel(event) {
    event.preventDefault();
    const steps = event.deltaY * (event.deltaMode === 1 ? 33 : 1) / 500;
    const holding = [...this.pointers.values()].filter((pointer) => pointer.grab && pointer.plane);
    // With a grab, the held body moves away or nearer.
    for (const pointer of holding) {
      const {camera} = this.page.orbit;
      const reach = camera.position.distanceTo(pointer.grab.anchor);
      pointer.plane.translate(pointer.plane.normal.clone().multiplyScalar(-0.3 * steps * reach));
      this.pull(pointer);
    }
    if (!holding.length) this.page.orbit.zoomBy(2 ** -steps);
    this.page.redraw();
  }

  double(event) {
    const [x, y] = this.at(event);
    if (this.hitAt(x, y)) return;
    this.page.orbit.reset();
    this.page.redraw();
  }
}
