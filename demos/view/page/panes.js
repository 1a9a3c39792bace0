// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Layout of the peers' worlds: side by side, one above another on a tall screen, or all in one pane. Rectangles are in
// CSS pixels from the canvas's upper left corner.
import {peerColour, peerName} from './colours.js';

const GAP = 2;       // CSS pixels between panes
const RUN_GAP = 6;   // CSS pixels, between runs

/**
 * @typedef {object} Pane
 * @property {number} peer       of the user who grabs here; index in hello
 * @property {Set<number>} peers  visible peers
 * @property {number} run        0, or 1: second run
 * @property {number} x
 * @property {number} y
 * @property {number} width
 * @property {number} height
 */

/** Equal rectangles, in the grid that brings them nearest to 4 : 3. */
function grid(count, width, height) {
  let best = null;
  for (let columns = 1; columns <= count; ++columns) {
    const rows = Math.ceil(count / columns);
    const w = (width - GAP * (columns - 1)) / columns;
    const h = (height - GAP * (rows - 1)) / rows;
    const size = Math.min(w / 4, h / 3);
    if (!best || size > best.size) best = {columns, w, h, size};
  }
  return Array.from({length: count}, (_, i) => ({
    x: (i % best.columns) * (best.w + GAP), y: Math.floor(i / best.columns) * (best.h + GAP),
    width: best.w, height: best.h}));
}

/**
 * @param {number[][]} runs   the peers of each run; the runs are side by side
 * @param {?number} only      the only visible peer
 * @param {boolean} overlay   all of a run in one pane
 * @param {number} width      CSS pixels
 * @param {number} height     CSS pixels
 * @returns {Pane[]}
 */
export function layOut(runs, only, overlay, width, height) {
  const chosen = runs.map((peers) => (only !== null && only < peers.length ? [peers[only]] : peers));
  const each = overlay ? 1 : chosen[0]?.length ?? 0;
  if (each === 0) return [];
  const wide = runs.length === 1 || width > height;
  const across = wide ? runs.length : 1;
  const down = wide ? 1 : runs.length;
  const w = (width - RUN_GAP * (across - 1)) / across;
  const h = (height - RUN_GAP * (down - 1)) / down;
  return chosen.flatMap((peers, run) => grid(each, w, h).map((place, i) => ({
    peer: peers[i], peers: new Set(overlay ? peers : [peers[i]]), run, ...place,
    x: place.x + (wide ? run * (w + RUN_GAP) : 0), y: place.y + (wide ? 0 : run * (h + RUN_GAP))})));
}

/**
 * Labels each pane with its peers.
 * @param {HTMLElement} parent
 * @param {Pane[]} panes
 * @param {object[]} peers   of hello
 * @param {string[]} titles  of the runs; empty for one run
 */
export function label(parent, panes, peers, titles) {
  const make = (tag, name, ...children) => {
    const element = document.createElement(tag);
    element.className = name;
    element.append(...children);
    return element;
  };
  parent.replaceChildren(...panes.map((pane, i) => {
    const box = make('div', 'pane');
    Object.assign(box.style, {left: `${pane.x}px`, top: `${pane.y}px`,
                              width: `${pane.width}px`, height: `${pane.height}px`});
    if (i === 0 || panes[i - 1].run !== pane.run) {
      const apart = make('output', '');
      apart.id = `apart-${pane.run}`;
      box.append(make('span', `run run-${pane.run}`, titles[pane.run] ?? '', apart));
    }
    for (const peer of pane.peers) {
      const {id, hz, engine} = peers[peer];
      const dot = make('i', '');
      dot.style.background = peerColour(id - 1);
      box.append(make('span', 'peer', dot, `Peer ${peerName(id - 1)}`,
                      make('small', '', `${hz} Hz${engine && engine !== 'tandem' ? `, ${engine}` : ''}`)));
    }
    return box;
  }));
}

/** @param {Pane[]} panes @param {number} x @param {number} y @returns {?Pane} */
export function paneAt(panes, x, y) {
  return panes.find((p) => x >= p.x && y >= p.y && x < p.x + p.width && y < p.y + p.height) ?? null;
}
