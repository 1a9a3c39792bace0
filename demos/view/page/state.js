// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Read-only state of the page for tests, as window.tandemView.
import * as THREE from './three.module.min.js';

/**
 * @param {Window} window
 * @param {object} parts  page, connection, orbit, canvas, input
 */
export function publish(window, {page, connection, orbit, canvas, input}) {
  const indexOf = (body) => (typeof body === 'number'
    ? body : page.hello.bodies.findIndex((b) => b.name === body));
  const view = {
    /** Frames received, pictures drawn, invalid messages. */
    get frames() { return page.frames; },
    get drawn() { return page.drawn; },
    get errors() { return connection.errors; },
    get connected() { return page.connected; },
    get settled() { return page.settled && !page.dirty; },
    get scene() { return page.hello?.scene ?? null; },
    get settings() { return {...page.settings}; },
    /** Refusals by the server. */
    get messages() { return [...page.messages]; },
    /** m: largest distance between copies of each run so far, as drawn. */
    get furthest() { return [...page.furthest]; },
    get roundTrip() { return page.roundTrip; },
    /** The drawn instant: s, session time; and each peer's drawn marks, m, world. */
    get drawnNow() {
      const {overlays, bodies} = page;
      return {time: overlays.time, peers: overlays.seen.map((marks, p) => (
        {positions: [...bodies.peers[p].shown.positions], ...marks}))};
    },
    /** s, session time of the last frame. */
    get time() { return page.frame?.time ?? NaN; },
    get panes() { return page.panes.map((pane) => ({...pane, peers: [...pane.peers]})); },
    /** Latency ms, step ms, divergence mm of each peer. */
    get peers() {
      return (page.frame?.peers ?? []).map(({positions, orientations, overlays, springs, ...rest}) => ({
        ...rest, contacts: overlays?.contacts.length ?? null,
        springs: springs.length, targets: overlays?.targets.length ?? null}));
    },
    /**
     * @returns {Object<string, number[]>}  x y z qx qy qz qw of each body of a peer, by name, in the last frame, m,
     * world
     */
    poses(peer) {
      const {positions: p, orientations: q} = page.frame.peers[peer];
      return Object.fromEntries(page.hello.bodies.map((body, b) => (
        [body.name, [...p.subarray(3 * b, 3 * b + 3), ...q.subarray(4 * b, 4 * b + 4)]])));
    },
    /** @returns {?string}  name of the body that a pointer there would grab */
    bodyAt(clientX, clientY) {
      const box = canvas.getBoundingClientRect();
      const hit = input.hitAt(clientX - box.left, clientY - box.top);
      return hit && page.hello.bodies[hit.body].name;
    },
    /** @returns {number[]}  clientX, clientY of a body's centre, or of a point (m, world) */
    project(body, peer, point = null) {
      const pane = page.panes.find((p) => p.peers.has(peer));
      const place = point ? new THREE.Vector3(...point)
                          : page.bodies.place(peer, indexOf(body));
      place.project(orbit.at(pane.width / pane.height));
      const box = canvas.getBoundingClientRect();
      return [box.left + pane.x + 0.5 * (1 + place.x) * pane.width,
              box.top + pane.y + 0.5 * (1 - place.y) * pane.height];
    },
  };
  Object.defineProperty(window, 'tandemView', {value: Object.freeze(view)});
}
