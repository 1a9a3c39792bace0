// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Mouse and fingers: on a body they hold it, elsewhere they turn the picture; two fingers or the wheel zoom.
import {poseOf, toLocal} from './poses.js';

const DEGREES = 0.35;  // each pixel

const limited = (value, low, high) => Math.min(high, Math.max(low, value));

/** @param {HTMLCanvasElement} canvas @param {object} drawing @param {object} session */
export function listen(canvas, drawing, session) {
  const down = new Map();  // by pointer: [x, y]
  let holds = null;        // the pointer of the holding hand
  let depth = null;        // m, a point at the depth of the hand
  let span = 0;            // pixels between two fingers

  const spread = () => {
    const [a, b] = [...down.values()];
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  };
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, [event.offsetX, event.offsetY]);
    if (down.size === 2) span = spread();
    if (down.size > 1 || event.button !== 0) return;
    const hit = drawing.pick(event.offsetX, event.offsetY);
    const held = hit && session.world.bodies[hit.row];
    if (!held || !(held.mass > 0) || !session.running) return;
    session.grab(held, toLocal(poseOf(held.body), hit.point));
    holds = event.pointerId;
    depth = hit.point;
  });
  canvas.addEventListener('pointermove', (event) => {
    const before = down.get(event.pointerId);
    if (!before) return;
    const now = [event.offsetX, event.offsetY];
    down.set(event.pointerId, now);
    const {look} = drawing;
    if (holds === event.pointerId) {
      const point = session.hand && drawing.pointAt(...now, depth);
      if (point) session.hand.wanted = point;
    } else if (down.size === 1) {
      look.azimuth -= DEGREES * (now[0] - before[0]);
      look.elevation = limited(look.elevation + DEGREES * (now[1] - before[1]), 3, 85);
    } else if (down.size === 2 && holds === null) {
      const wide = spread();
      if (span > 0 && wide > 0) look.distance = limited(look.distance * span / wide, 0.8, 15);
      span = wide;
    }
  });
  const up = (event) => {
    down.delete(event.pointerId);
    if (holds !== event.pointerId) return;
    holds = null;
    session.release();
  };
  for (const type of ['pointerup', 'pointercancel']) canvas.addEventListener(type, up);
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const {look} = drawing;
    look.distance = limited(look.distance * Math.exp(0.001 * event.deltaY), 0.8, 15);
  }, {passive: false});
}
