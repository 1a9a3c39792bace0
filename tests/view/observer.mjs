// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A page without a picture: it takes every frame as it comes, however slowly a browser draws.
import WebSocket from 'ws';
import {FrameDecoder} from '../../demos/view/page/protocol.js';

/** Waits until a condition holds. @param {function(): any} condition @param {string} what
 *  @param {number} seconds  s, at most */
export async function until(condition, what, seconds = 60) {
  const end = Date.now() + 1000 * seconds;
  for (;;) {
    const result = await condition();
    if (result) return result;
    if (Date.now() > end) throw new Error(`${what}: not within ${seconds} s`);
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
}

/** A connection to /TOKEN/socket. */
export class Observer {
  /** @param {string} url  of the page @param {object} headers  of the request */
  constructor(url, headers = {}) {
    this.socket = new WebSocket(new URL('socket', url.replace(/^http/, 'ws')), {headers});
    this.frames = 0;
    this.bytes = 0;
    this.last = null;
    this.settings = null;
    this.refusals = [];
    this.pongs = [];
    this.closed = false;
    this.watched = [];
    this.socket.on('message', (data, isBinary) => this.receive(data, isBinary));
    this.socket.on('close', () => { this.closed = true; });
    this.socket.on('error', (error) => { this.error = error; });
  }

  receive(data, isBinary) {
    this.bytes += data.length;
    if (!isBinary) {
      const message = JSON.parse(data);
      if (message.type === 'hello') {
        this.hello = message;
        this.settings = message.settings;
        this.decoder = new FrameDecoder(message);
      }
      if (message.type === 'settings') this.settings = message.settings;
      if (message.type === 'refused') this.refusals.push(message.text);
      if (message.type === 'pong') this.pongs.push(message.time);
      return;
    }
    const buffer = data.buffer.slice(data.byteOffset, data.byteOffset + data.length);
    this.last = this.decoder.decode(buffer);
    ++this.frames;
    for (const watch of this.watched) {
      watch.places.push({time: this.last.time, at: this.places(watch.body)});
    }
  }

  /** @param {string} name @returns {number}  index of a body */
  index(name) { return this.hello.bodies.findIndex((body) => body.name === name); }
  /** @param {string} name @returns {number[][]}  m: where each peer has a body */
  places(name) {
    const b = this.index(name);
    return this.last.peers.map(({positions}) => [...positions.subarray(3 * b, 3 * b + 3)]);
  }
  /** @returns {{time: number, at: number[][]}[]}  where a body is from now on: s, m */
  watch(body) {
    const places = [];
    this.watched.push({body, places});
    return places;
  }

  send(message) { this.socket.send(JSON.stringify(message)); }
  set(name, value) { this.send({type: 'set', name, value}); }
  /** @returns {Promise<Observer>} */
  async ready() {
    await until(() => this.last || this.error || this.closed, 'the first frame');
    if (!this.last) throw this.error ?? new Error('closed before the first frame');
    return this;
  }
  /** @param {number} seconds  s, of session time */
  async pass(seconds) {
    const end = this.last.time + seconds;
    await until(() => this.last.time >= end, `${seconds} s of session time`);
  }
  close() { this.socket.terminate(); }
}

/**
 * When a body has gone half of its way, at each peer.
 * @param {{time: number, at: number[][]}[]} places  see Observer.watch
 * @param {number} axis  0..2
 * @param {number} from  m
 * @param {number} to    m
 * @returns {{times: number[], unsure: number}}  s, session time; and by how much a difference of two
 *   of them may be off, as no frame came between: where the machine is busy, frames are left out
 */
export function halfWay(places, axis, from, to) {
  const middle = (from + to) / 2;
  const first = places[0].at.map((_, peer) => places.findIndex(
    ({at}) => (to > from) === (at[peer][axis] > middle)));
  const gaps = first.map((i) => (i > 0 ? places[i].time - places[i - 1].time : Infinity));
  return {times: first.map((i) => places[i]?.time ?? Infinity), unsure: Math.max(...gaps)};
}

/** @param {number[]} a @param {number[]} b @returns {number} */
export const distance = (a, b) => Math.hypot(...a.map((v, i) => v - b[i]));
