// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The WebSocket to the room's server, with reconnection (../server/wire.h has its messages).

export const JOIN = 1;
export const NEWEST = 2;
export const RELIABLE = 3;
export const TIME = 4;
export const WELCOME = 5;
export const CAME = 6;
export const GONE = 7;

const HEADER = 9;
const AGAIN_MS = 1500;
const MOST_WAITING = 1 << 20;  // bytes queued, above which losable messages are not sent

function message(kind, id, bytes = new Uint8Array(0)) {
  const out = new Uint8Array(HEADER + bytes.length);
  const view = new DataView(out.buffer);
  view.setUint8(0, kind);
  view.setBigUint64(1, id, true);
  out.set(bytes, HEADER);
  return out;
}

export class Server {
  #socket = null;
  #over = false;

  /**
   * @param {string} url
   * @param {bigint} self
   * @param {{opened: function(), closed: function(), heard: function(number, bigint, Uint8Array), time: function(number, number),
   *   welcome: function(bigint[])}} listener  time: ms when sent, ms of the server since 1970
   */
  constructor(url, self, listener) {
    Object.assign(this, {url, self, listener});
    this.#connect();
  }
  get open() { return this.#socket?.readyState === WebSocket.OPEN; }

  send(kind, to, bytes) {
    if (!this.open || (kind === NEWEST && this.#socket.bufferedAmount > MOST_WAITING)) return false;
    this.#socket.send(message(kind, to, bytes));
    return true;
  }
  askTime() {
    if (!this.open) return;
    const bytes = new DataView(new ArrayBuffer(8));
    bytes.setFloat64(0, performance.now(), true);
    this.#socket.send(message(TIME, bytes.getBigUint64(0, true)));
  }
  close() {
    this.#over = true;
    this.#socket?.close();
  }

  #connect() {
    const socket = new WebSocket(this.url);
    this.#socket = socket;
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      socket.send(message(JOIN, this.self));
      this.listener.opened();
    };
    socket.onmessage = ({data}) => {
      if (data instanceof ArrayBuffer && data.byteLength > 0) this.#hear(data);
    };
    socket.onclose = () => {
      this.listener.closed();
      if (!this.#over) setTimeout(() => this.#over || this.#connect(), AGAIN_MS);
    };
  }
  #hear(data) {
    const view = new DataView(data);
    const kind = view.getUint8(0);
    if (kind === WELCOME) {
      const ids = [];
      for (let at = 1; at + 8 <= data.byteLength; at += 8) ids.push(view.getBigUint64(at, true));
      this.listener.welcome(ids);
      return;
    }
    if (data.byteLength < HEADER) return;
    if (kind === TIME) {
      if (data.byteLength === HEADER + 8) {
        this.listener.time(view.getFloat64(1, true), Number(view.getBigInt64(HEADER, true)) / 1e6);
      }
      return;
    }
    this.listener.heard(kind, view.getBigUint64(1, true), new Uint8Array(data, HEADER));
  }
}
