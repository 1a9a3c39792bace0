// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Colours of bodies and of peers: the same in all panes, plots and overlays.
import {Color} from './three.module.min.js';

const BODIES = ['#4c78d8', '#f0a03c', '#3fa98c', '#e0645c', '#8b6fd0', '#e8c547', '#56b4dc',
                '#d77aa8', '#86b94e', '#c98a5e'];
const PEERS = ['#2f7bf6', '#f2811d', '#16a37b', '#d6409f', '#8b5cf6', '#b59a00', '#0ea5b7',
               '#e5484d'];

/** @param {number} peer  index @returns {string}  its colour, as CSS has it */
export function peerColour(peer) {
  return PEERS[peer % PEERS.length];
}

/** @param {number} peer  index @returns {string}  its name on the page: A, B, .. */
export function peerName(peer) {
  return peer < 26 ? String.fromCharCode(65 + peer) : `#${peer + 1}`;
}

/**
 * @param {object} body   of hello
 * @param {number} index  in hello
 * @returns {Color}  its colour; neighbours differ, and owned bodies have the peer's
 */
export function bodyColour(body, index) {
  if (body.owner !== null && body.owner !== undefined) return new Color(peerColour(body.owner));
  // Later rounds of the palette begin elsewhere and are slightly lighter or darker.
  const round = Math.floor(index / BODIES.length);
  const colour = new Color(BODIES[(index + 3 * round) % BODIES.length]);
  return colour.offsetHSL(0, 0, [0, 0.05, -0.05, 0.09][round % 4]);
}
