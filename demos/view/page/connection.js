// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The WebSocket to the server, with reconnection.
import {FrameDecoder, PROTOCOL, ProtocolError} from './protocol.js';

const FIRST_PAUSE = 0.5;  // s, before the first retry
const LONGEST_PAUSE = 8;  // s
const TRIES = 6;          // in a row before giving up: 0.5 + 1 + 2 + 4 + 8 + 8 s
const GOING_AWAY = 1001;  // close code of a program that ends
const PING = 1000;        // ms

/** Calls handlers: hello(message), frame(Frame), text(message), state('open' | 'lost' |
 *  'ended' | 'dead'), roundTrip(ms). */
export class Connection {
  /**
   * @param {string} url  of the socket
   * @param {object} handlers
   */
  constructor(url, handlers) {
    this.url = url;
    this.handlers = handlers;
    this.pause = FIRST_PAUSE;
    this.errors = 0;  // invalid messages
    this.tries = 0;
    this.open();
    setInterval(() => this.send({type: 'ping', time: performance.now()}), PING);
  }

  open() {
    this.decoder = null;
    this.socket = new WebSocket(this.url);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onmessage = (event) => this.receive(event.data);
    this.socket.onclose = ({code}) => {
      const dead = ++this.tries > TRIES;
      this.handlers.state(code === GOING_AWAY ? 'ended' : dead ? 'dead' : 'lost');
      if (code === GOING_AWAY || dead) return;
      setTimeout(() => this.open(), 1000 * this.pause);
      this.pause = Math.min(2 * this.pause, LONGEST_PAUSE);
    };
  }

  receive(data) {
    try {
      // Frames cannot be decoded without a hello: it has the number of bodies.
      if (typeof data === 'string') this.receiveText(JSON.parse(data));
      else if (this.decoder) this.handlers.frame(this.decoder.decode(data));
    } catch (error) {
      if (!(error instanceof ProtocolError) && !(error instanceof SyntaxError)) throw error;
      ++this.errors;
    }
  }

  receiveText(message) {
    if (typeof message?.type !== 'string') throw new ProtocolError('a message without a type');
    if (message.type === 'pong') {
      this.handlers.roundTrip(performance.now() - message.time);
      return;
    }
    if (message.type !== 'hello') {
      this.handlers.text(message);
      return;
    }
    if (message.protocol !== PROTOCOL) {
      this.handlers.text({type: 'refused',
                          text: `the server speaks protocol ${message.protocol}`});
      return;
    }
    this.pause = FIRST_PAUSE;
    this.tries = 0;
    this.decoder = new FrameDecoder(message);
    this.handlers.hello(message);
    this.handlers.state('open');
  }

  /** Retries on the user's request. */
  again() {
    this.tries = 0;
    this.pause = FIRST_PAUSE;
    this.open();
  }

  /** @param {object} message  as demos/view/README.md has it; lost without a connection */
  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }
}
