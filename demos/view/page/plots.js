// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Lines over session time on a canvas, with the median and 95th percentile of all values. The scale fits 99 %: spikes
// are cut off, and the maximum is written beside it.
import {peerColour} from './colours.js';

const SPAN = 15;     // s visible
const PERIOD = 100;  // ms between drawings
const LEFT = 34;     // CSS pixels, for the scale's numbers
const BELOW = 14;    // CSS pixels, for the times

/** The least of 1, 2, 5, 10, 20, .. that is not below a value. */
function roundUp(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((f) => f * decade).find((v) => v >= value * 0.999);
}

/** @param {number[]} sorted  ascending, not empty @param {number} share  0..1 */
export function percentile(sorted, share) {
  return sorted[Math.max(0, Math.ceil(share * sorted.length) - 1)];
}

function text(value) {
  if (!Number.isFinite(value)) return '–';
  return value >= 100 ? value.toFixed(0) : value >= 10 ? value.toFixed(1) : value.toFixed(2);
}

class Plot {
  /**
   * @param {HTMLElement} figure  holds a figcaption with an output, a canvas and a p
   * @param {string} unit
   * @param {function(import('./protocol.js').PeerFrame): number} value
   * @param {number} least  lower bound of the scale's top
   */
  constructor(figure, unit, value, least) {
    this.title = figure.querySelector('figcaption b').textContent;
    this.canvas = figure.querySelector('canvas');
    this.output = figure.querySelector('output');
    this.facts = figure.querySelector('p');
    this.canvas.setAttribute('role', 'img');
    Object.assign(this, {unit, value, least});
    this.clear();
  }
  clear() { this.samples = []; }

  push(frame) {
    // Time going backwards means a restart.
    if (this.samples.length && frame.time < this.samples.at(-1).time) this.clear();
    this.samples.push({time: frame.time, values: frame.peers.map(this.value)});
    while (this.samples[0].time < frame.time - SPAN - 1) this.samples.shift();
  }

  /** Percentiles of the visible values, and the top of the scale. */
  measure() {
    const known = this.samples.flatMap((s) => s.values.filter(Number.isFinite));
    known.sort((a, b) => a - b);
    if (!known.length) return {top: this.least};
    const [half, most, almost] = [0.5, 0.95, 0.99].map((share) => percentile(known, share));
    return {half, most, largest: known.at(-1), top: roundUp(Math.max(this.least, almost))};
  }

  draw(colours, peers) {
    const ratio = window.devicePixelRatio || 1;
    const {clientWidth: width, clientHeight: height} = this.canvas;
    if (!width || !this.samples.length) return;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    const paper = this.canvas.getContext('2d');
    paper.scale(ratio, ratio);
    const {half, most, largest, top} = this.measure();
    const end = this.samples.at(-1).time;
    const x = (time) => LEFT + (width - LEFT) * (1 - (end - time) / SPAN);
    const y = (value) => (height - BELOW - 6) * (1 - Math.min(value, top) / top) + 4;
    this.drawScale(paper, colours, top, x, y, end, height);
    if (largest > top) {
      paper.textAlign = 'right';
      paper.fillText(`▲ ${text(largest)}`, width - 2, 13);
    }
    const last = this.samples.at(-1).values;
    paper.save();
    paper.beginPath();
    paper.rect(LEFT, 0, width - LEFT, height);
    paper.clip();
    last.forEach((_, p) => this.drawLine(paper, p, peers[p], x, y));
    paper.restore();
    this.output.textContent = `${last.map(text).join(' · ')} ${this.unit}`;
    this.facts.textContent = half === undefined ? '' : `half below ${text(half)} · 95 % below ` +
      `${text(most)} · largest ${text(largest)} ${this.unit}`;
    this.canvas.setAttribute('aria-label', `${this.title}, last ${SPAN} s: ${this.facts.textContent}`);
  }

  drawScale(paper, colours, top, x, y, end, height) {
    paper.font = '10px system-ui, sans-serif';
    paper.fillStyle = colours.text;
    paper.strokeStyle = colours.line;
    paper.lineWidth = 1;
    for (const value of [0, top / 2, top]) {
      const at = Math.round(y(value)) + 0.5;
      paper.beginPath();
      paper.moveTo(LEFT, at);
      paper.lineTo(x(end), at);
      paper.stroke();
      paper.textAlign = 'right';
      paper.fillText(String(Number(value.toPrecision(3))), LEFT - 4, at + 3);
    }
    for (const ago of [SPAN, 10, 5, 0]) {
      paper.textAlign = ago === SPAN ? 'left' : ago ? 'center' : 'right';
      paper.fillText(ago ? `−${ago} s` : 'now', x(end - ago), height - 2);
    }
  }

  drawLine(paper, p, {id, beside}, x, y) {
    paper.strokeStyle = peerColour(id - 1);
    paper.lineWidth = 1.75;
    paper.lineJoin = 'round';
    paper.setLineDash(beside ? [3, 3] : []);
    paper.beginPath();
    let drawing = false;
    for (const {time, values} of this.samples) {
      const value = values[p];
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
}

/** Divergence, latency, step time. */
export class Plots {
  /** @param {HTMLElement} parent  with a figure per id */
  constructor(parent) {
    this.parent = parent;
    const figure = (name) => parent.querySelector(`#plot-${name}`);
    this.plots = [new Plot(figure('divergence'), 'mm', (peer) => peer.divergenceMaxMm, 0.1),
                  new Plot(figure('latency'), 'ms', (peer) => peer.latencyMs, 10),
                  new Plot(figure('step'), 'ms', (peer) => peer.stepMs, 0.5)];
    this.last = 0;
  }
  clear() { this.plots.forEach((plot) => plot.clear()); }
  /** @param {import('./protocol.js').Frame} frame */
  push(frame) { this.plots.forEach((plot) => plot.push(frame)); }
  /** @param {number} now  ms @param {object[]} peers  of hello */
  draw(now, peers) {
    if (now - this.last < PERIOD || this.parent.offsetParent === null) return;
    this.last = now;
    const style = getComputedStyle(this.parent);
    const colours = {text: style.getPropertyValue('--soft'),
                     line: style.getPropertyValue('--rule')};
    this.plots.forEach((plot) => plot.draw(colours, peers));
  }
}
