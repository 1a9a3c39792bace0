// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Where each peer's world is drawn: side by side, one above another on a tall screen, or all in
// one pane. Rectangles are in CSS pixels from the canvas's upper left corner.
import {peerColour, peerName} from './colours.js';

const GAP = 2;  // CSS pixels between panes

/**
 * @typedef {object} Pane
 * @property {number} peer       whose user grabs here; index in hello
 * @property {Set<number>} peers  who is seen
 * @property {number} x
 * @property {number} y
 * @property {number} width
 * @property {number} height
 */

/**
 * @param {number} peers      how many there are
 * @param {?number} only      a peer that is seen alone
 * @param {boolean} overlay   all in one pane
 * @param {number} width      CSS pixels
 * @param {number} height     CSS pixels
 * @returns {Pane[]}
 */
export function layOut(peers, only, overlay, width, height) {
  if (peers === 0) return [];
  const all = new Set(Array(peers).keys());
  if (only !== null && only < peers) return [{peer: only, peers: new Set([only]), x: 0, y: 0, width,
                                              height}];
  if (overlay) return [{peer: 0, peers: all, x: 0, y: 0, width, height}];
  // As many columns as make panes most like 4 : 3.
  let best = null;
  for (let columns = 1; columns <= peers; ++columns) {
    const rows = Math.ceil(peers / columns);
    const w = (width - GAP * (columns - 1)) / columns;
    const h = (height - GAP * (rows - 1)) / rows;
    const size = Math.min(w / 4, h / 3);
    if (!best || size > best.size) best = {columns, w, h, size};
  }
  return [...all].map((peer) => ({
    peer, peers: new Set([peer]), x: (peer % best.columns) * (best.w + GAP),
    y: Math.floor(peer / best.columns) * (best.h + GAP), width: best.w, height: best.h,
  }));
}

/**
 * Writes who is seen into each pane.
 * @param {HTMLElement} parent
 * @param {Pane[]} panes
 * @param {object[]} peers  of hello
 */
export function label(parent, panes, peers) {
  parent.replaceChildren(...panes.map((pane) => {
    const box = document.createElement('div');
    box.className = 'pane';
    Object.assign(box.style, {left: `${pane.x}px`, top: `${pane.y}px`,
                              width: `${pane.width}px`, height: `${pane.height}px`});
    for (const peer of pane.peers) {
      const name = document.createElement('span');
      name.className = 'peer';
      const dot = document.createElement('i');
      dot.style.background = peerColour(peer);
      const {hz, engine} = peers[peer];
      const small = document.createElement('small');
      small.textContent = `${hz} Hz${engine && engine !== 'tandem' ? `, ${engine}` : ''}`;
      name.append(dot, `Peer ${peerName(peer)}`, small);
      box.append(name);
    }
    return box;
  }));
}

/** @param {Pane[]} panes @param {number} x @param {number} y @returns {?Pane} */
export function paneAt(panes, x, y) {
  return panes.find((p) => x >= p.x && y >= p.y && x < p.x + p.width && y < p.y + p.height) ?? null;
}
