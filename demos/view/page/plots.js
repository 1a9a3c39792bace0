// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Lines over session time on a canvas.
import {peerColour} from './colours.js';

const SPAN = 15;     // s that are seen
const PERIOD = 100;  // ms between drawings

/** The least of 1, 2, 5, 10, 20, .. that is not below a value. */
function roundUp(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((f) => f * decade).find((v) => v >= value * 0.999);
}

/** One plot of a value of each peer. */
class Plot {
  /**
   * @param {HTMLElement} figure  holds a figcaption and a canvas
   * @param {function(import('./protocol.js').PeerFrame): number} value
   * @param {number} least  the top of the scale is never lower
   */
  constructor(figure, value, least) {
    this.canvas = figure.querySelector('canvas');
    this.output = figure.querySelector('output');
    this.value = value;
    this.least = least;
    this.clear();
  }
  clear() { this.samples = []; }

  push(frame) {
    // A restart begins anew.
    if (this.samples.length && frame.time < this.samples.at(-1).time) this.clear();
    this.samples.push({time: frame.time, values: frame.peers.map(this.value)});
    while (this.samples[0].time < frame.time - SPAN - 1) this.samples.shift();
  }

  draw(colours) {
    const ratio = window.devicePixelRatio || 1;
    const {clientWidth: width, clientHeight: height} = this.canvas;
    if (!width || !this.samples.length) return;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    const paper = this.canvas.getContext('2d');
    paper.scale(ratio, ratio);
    const known = this.samples.flatMap((s) => s.values.filter(Number.isFinite));
    const top = roundUp(Math.max(this.least, ...known));
    const end = this.samples.at(-1).time;
    const x = (time) => width * (1 - (end - time) / SPAN);
    const y = (value) => (height - 3) * (1 - value / top) + 2;
    paper.font = '10px system-ui, sans-serif';
    paper.fillStyle = colours.text;
    paper.strokeStyle = colours.line;
    paper.lineWidth = 1;
    for (const value of [0, top / 2, top]) {
      paper.beginPath();
      paper.moveTo(0, Math.round(y(value)) + 0.5);
      paper.lineTo(width, Math.round(y(value)) + 0.5);
      paper.stroke();
    }
    paper.fillText(String(top), 2, 13);
    paper.lineWidth = 1.75;
    paper.lineJoin = 'round';
    const last = this.samples.at(-1).values;
    last.forEach((_, peer) => this.drawLine(paper, peer, x, y));
    this.output.textContent = last.map((v) => this.text(v)).join(' · ');
  }

  drawLine(paper, peer, x, y) {
    paper.strokeStyle = peerColour(peer);
    paper.beginPath();
    let drawing = false;
    for (const {time, values} of this.samples) {
      const value = values[peer];
      if (!Number.isFinite(value)) {
        drawing = false;
      } else if (drawing) {
        paper.lineTo(x(time), y(value));
      } else {
        paper.moveTo(x(time), y(value));
        drawing = true;
      }
    }
    paper.stroke();
  }

  text(value) {
    if (!Number.isFinite(value)) return '–';
    return value >= 100 ? value.toFixed(0) : value >= 10 ? value.toFixed(1) : value.toFixed(2);
  }
}

/** Divergence, latency, step time. */
export class Plots {
  /** @param {HTMLElement} parent  with a figure of each id */
  constructor(parent) {
    this.parent = parent;
    const figure = (name) => parent.querySelector(`#plot-${name}`);
    this.plots = [new Plot(figure('divergence'), (peer) => peer.divergenceMaxMm, 0.1),
                  new Plot(figure('latency'), (peer) => peer.latencyMs, 10),
                  new Plot(figure('step'), (peer) => peer.stepMs, 0.5)];
    this.last = 0;
  }
  clear() { this.plots.forEach((plot) => plot.clear()); }
  /** @param {import('./protocol.js').Frame} frame */
  push(frame) { this.plots.forEach((plot) => plot.push(frame)); }
  /** @param {number} now  ms */
  draw(now) {
    if (now - this.last < PERIOD || this.parent.offsetParent === null) return;
    this.last = now;
    const style = getComputedStyle(this.parent);
    const colours = {text: style.getPropertyValue('--soft'),
                     line: style.getPropertyValue('--rule')};
    this.plots.forEach((plot) => plot.draw(colours));
  }
}
