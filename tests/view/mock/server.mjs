// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The server of demos/view/README.md in Node, for work on the page and its tests without the programs:
//   node tests/view/mock/server.mjs [PORT] [balls=1000]
import {randomBytes} from 'node:crypto';
import {createServer} from 'node:http';
import {fileURLToPath} from 'node:url';
import {WebSocketServer} from 'ws';
import {encodeFrame} from './encoder.mjs';
import {answer} from './files.mjs';
import {MockWorld} from './world.mjs';

const FLOOD = 240;         // messages of a second
const LONGEST = 1024;      // bytes of a message

const isPoint = (p) => Array.isArray(p) && p.length === 3 &&
  p.every((v) => Number.isFinite(v) && Math.abs(v) <= 100);

/** Says why a message is refused; undefined where it is good. */
function fault(world, message) {
  if (message.type === 'grab' || message.type === 'move') {
    if (!isPoint(message.point)) return 'point must be three numbers within 100 m';
  }
  if (message.type === 'grab' && !world.peers[message.pane]?.[message.body]) {
    return `body must be one of the scene, is ${message.body}`;
  }
  if (message.type !== 'set') return undefined;
  if (!world.live) return 'set: not in this run';
  const all = world.hello().choices;
  const choices = {...all, paused: [false, true], beside: [null, ...all.scheme]}[message.name];
  if (!choices) return `name = ${message.name} is not known`;
  const {value} = message;
  const good = ['speed', 'influence'].includes(message.name)
    ? value >= choices[0] && value <= choices[1] : choices.includes(value);
  return good ? undefined : `${message.name} must be ${choices.join(', ')}, is ${value}`;
}

/** One page. */
class Client {
  constructor(socket, server) {
    this.socket = socket;
    this.server = server;
    this.overlays = false;
    this.window = {second: 0, count: 0};
    socket.send(JSON.stringify(server.world.hello()));
    socket.on('message', (data, isBinary) => this.receive(data, isBinary));
    socket.on('error', () => {});
    socket.on('close', () => {
      server.clients.delete(this);
      server.world.release((key) => key.startsWith(`${this.id}/`));
    });
  }
  receive(data, isBinary) {
    const second = Math.floor(Date.now() / 1000);
    if (second !== this.window.second) this.window = {second, count: 0};
    if (isBinary || data.length > LONGEST || ++this.window.count > FLOOD) {
      this.socket.terminate();
      return;
    }
    let message;
    try {
      message = JSON.parse(data);
    } catch {
      this.refuse('message must be JSON');
      return;
    }
    this.server.received.push(message);
    const why = fault(this.server.world, message);
    if (why) this.refuse(why);
    else this.server.obey(this, message);
  }
  tell(message) { this.socket.send(JSON.stringify(message)); }
  refuse(text) { this.tell({type: 'refused', text}); }
}

/** @typedef {{url: string, world: MockWorld, received: object[], close: function()}} MockServer */

/**
 * @param {{port?: number, token?: string, every?: number}} options  every so many steps a frame is
 *   sent; and those of MockWorld
 * @returns {Promise<MockServer>}
 */
export async function startMock({port = 0, token = randomBytes(16).toString('hex'), every = 1,
                                 ...rest} = {}) {
  const world = new MockWorld(rest);
  const clients = new Set();
  const http = createServer((request, response) => answer(token, request, response));
  const sockets = new WebSocketServer({server: http, path: `/${token}/socket`});
  const server = {
    world, clients, received: [],
    obey(client, message) {
      const key = `${client.id}/${message.id}`;
      if (message.type === 'grab') world.grab(key, message);
      if (message.type === 'move') world.move(key, message.point);
      if (message.type === 'release') world.release((k) => k === key);
      if (message.type === 'ping') client.tell({type: 'pong', time: message.time});
      if (message.type === 'score') client.tell(server.score(false));
      if (message.type === 'want') client.overlays = message.overlays;
      if (message.type === 'step') server.advance();
      if (message.type === 'restart') world.restart();
      if (message.type === 'set') {
        world.settings[message.name] = message.value;
        if (message.name === 'beside' && message.value) world.restart();
        for (const each of clients) each.tell({type: 'settings', settings: world.settings});
      }
    },
    /** Scores of the pages' peers. */
    score(final) {
      const outcomes = [{hits: 23, plate_lifted_m: 0.215}, {hits: 23, b_tasks_done: 2}, {hits: 2},
                        {hits: 1}];
      return {type: 'score', time: world.time, final,
              outcomes: outcomes.slice(0, world.settings.beside ? 4 : 2)};
    },
    /** The run is over. */
    end() {
      for (const client of clients) client.tell(server.score(true));
    },
    advance() {
      world.step();
      if (world.number % every !== 0) return;
      for (const client of clients) {
        client.socket.send(encodeFrame({...world.frame(client.overlays), key: true}));
      }
    },
  };
  let nextId = 1;
  sockets.on('connection', (socket) => {
    const client = new Client(socket, server);
    client.id = nextId++;
    clients.add(client);
    socket.send(encodeFrame({...world.frame(false), key: true}));
  });
  const timer = setInterval(() => { if (!world.settings.paused) server.advance(); }, 1000 / 60);
  await new Promise((resolve) => http.listen(port, '127.0.0.1', resolve));
  return Object.assign(server, {
    url: `http://127.0.0.1:${http.address().port}/${token}/`,
    port: http.address().port, token,
    /** @param {?number} code  that pages are told; none where it breaks off */
    async close(code = null) {
      clearInterval(timer);
      if (code) {
        await Promise.all([...clients].map(({socket}) => new Promise((resolve) => {
          socket.once('close', resolve);
          socket.close(code);
        })));
      }
      for (const {socket} of clients) socket.terminate();
      sockets.close();
      http.closeAllConnections();
      await new Promise((resolve) => http.close(resolve));
    },
  });
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const options = Object.fromEntries(process.argv.slice(3).map((word) => word.split('=')));
  const balls = Number(options.balls ?? 0);
  const server = await startMock({port: Number(process.argv[2] ?? 8080), balls,
                                  scene: balls ? 'balls' : 'shapes'});
  console.error(`view: ${server.url}`);
}
