// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Where the processor time of a page's step goes: three sessions of the room's page in one process and in virtual
// time, without pictures, with 200 bodies that each of the three stirs, as heap.mjs does it. What it counts does not
// depend on what else the machine does, but for its caches.
//   node tests/room/step_cost.mjs [--page build/web/room] [--seconds 10] [--way 8] [--late 0] [--bodies 200] [--seed 1]
// --way: ms one way; --late: ms, from time to time nobody steps for so long.
import {mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {parseArgs} from 'node:util';
import {gunzipSync} from 'node:zlib';
import {PAGE} from './support.mjs';

const {values: options} = parseArgs({options: {
  page: {type: 'string', default: PAGE}, seconds: {type: 'string', default: '10'}, way: {type: 'string', default: '8'},
  late: {type: 'string', default: '0'}, bodies: {type: 'string', default: '200'},
  seed: {type: 'string', default: '1'},
}});
const PEOPLE = 3;
const EVERY_MS = 4;      // as the page asks for steps
const SETTLE_MS = 4000;
const LATE_EVERY_MS = 500;

let now = 1000;          // ms, virtual
const due = [];          // {at, work}
const later = (ms, work) => due.push({at: now + ms, work});
performance.now = () => now;
const seed = Number(options.seed);
let drawn = BigInt(seed);
crypto.getRandomValues = (into) => {
  const bytes = new Uint8Array(into.buffer, into.byteOffset, into.byteLength);
  for (let i = 0; i < bytes.length; ++i) {
    drawn = BigInt.asUintN(64, drawn * 6364136223846793005n + 1442695040888963407n);
    bytes[i] = Number(drawn >> 56n);
  }
  return into;
};
globalThis.setTimeout = (work, ms) => later(ms, work);

/** A room's server in this process: who is there, and what they say to each other. */
const sockets = [];
globalThis.WebSocket = class {
  static OPEN = 1;
  readyState = 1;
  bufferedAmount = 0;
  constructor() {
    later(0, () => this.onopen());
  }
  close() {}
  send(bytes) {
    const {buffer} = bytes;
    const view = new DataView(buffer);
    const [kind, id] = [view.getUint8(0), view.getBigUint64(1, true)];
    const tell = (socket, data) => later(Number(options.way), () => socket.onmessage({data}));
    if (kind === 1) {
      this.id = id;
      const welcome = new DataView(new ArrayBuffer(1 + 8 * sockets.length));
      welcome.setUint8(0, 5);
      sockets.forEach((other, i) => {
        welcome.setBigUint64(1 + 8 * i, other.id, true);
        const came = new DataView(new ArrayBuffer(9));
        came.setUint8(0, 6);
        came.setBigUint64(1, id, true);
        tell(other, came.buffer);
      });
      sockets.push(this);
      tell(this, welcome.buffer);
    } else if (kind === 4) {
      const time = new DataView(new ArrayBuffer(17));
      for (let i = 0; i < 9; ++i) time.setUint8(i, view.getUint8(i));
      time.setBigInt64(9, BigInt(Math.round(1e6 * now)), true);
      tell(this, time.buffer);
    } else {
      for (const other of sockets) {
        if (other === this || (id !== 0n && other.id !== id)) continue;
        const copy = new Uint8Array(buffer.slice(0));
        new DataView(copy.buffer).setBigUint64(1, this.id, true);
        tell(other, copy.buffer);
      }
    }
  }
};

const used = () => {
  const {user, system} = process.cpuUsage();
  return (user + system) / 1000;
};
const spent = {};        // ms of the processor
let inside = null;
/** What `name` does is counted as `what`, and not as that of who calls it. */
function count(prototype, name, what) {
  const original = prototype[name];
  prototype[name] = function counted(...words) {
    const [outer, start] = [inside, used()];
    inside = {nested: 0};
    try {
      return original.apply(this, words);
    } finally {
      const all = used() - start;
      spent[what] = (spent[what] ?? 0) + all - inside.nested;
      inside = outer;
      if (inside) inside.nested += all;
    }
  };
}

const folder = mkdtempSync(join(tmpdir(), 'tandem-cost-'));
try {
  for (const name of readdirSync(options.page).filter((file) => /[.](js|wasm|json)[.]gz$/.test(file))) {
    writeFileSync(join(folder, name.slice(0, -3)), gunzipSync(readFileSync(join(options.page, name))));
  }
  writeFileSync(join(folder, 'package.json'), '{"type": "module"}');
  const load = (name) => import(join(folder, name));
  const {init, Peer} = await load('tandem.js');
  const {Cipher, initCipher} = await load('cipher.js');
  const {Session} = await load('session.js');
  const {RoomWorld} = await load('world.js');
  await init(readFileSync(join(folder, 'tandem.wasm')));
  await initCipher(readFileSync(join(folder, 'cipher.wasm')));
  count(Session.prototype, 'advance', 'other JavaScript of a step');
  count(RoomWorld.prototype, 'step', 'the world');
  count(Peer.prototype, 'beforeStep', 'agreement: news and replay');
  count(Peer.prototype, 'afterStep', 'agreement: snapshots and packets');
  count(Cipher.prototype, 'seal', 'cipher');
  count(Cipher.prototype, 'open', 'cipher');
  for (const name of ['remember', 'digest', 'compare']) count(RoomWorld.prototype, name, 'how far apart');

  const room = JSON.parse(readFileSync(join(folder, 'room-sandbox.json'), 'utf8'));
  const key = new Uint8Array(32).fill(7);
  const sessions = Array.from({length: PEOPLE}, (_, i) => (
    new Session(room, {key, room: 'sandbox', url: ''}, {name: `${i}`, colour: '#888888'}, () => {})));
  const run = (ms, each = () => {}) => {
    let held = 0;
    for (const end = now + ms; now < end; ++now) {
      due.sort((a, b) => a.at - b.at);
      while (due.length && due[0].at <= now) {
        const start = used();
        due.shift().work();
        spent['what is heard'] = (spent['what is heard'] ?? 0) + used() - start;
      }
      each();
      if (Number(options.late) > 0 && now % LATE_EVERY_MS === 0) held = now + Number(options.late);
      if (now >= held && now % EVERY_MS < PEOPLE) sessions[now % EVERY_MS].advance();
    }
  };
  run(500);
  const [first] = sessions;
  for (let k = first.world.bodies.length - 1; k < Number(options.bodies); ++k) {
    first.make({type: 'box', halfExtents: [0.08, 0.08, 0.08]},
               [0.22 * (k % 6) - 0.6 + 0.06 * Math.sin(k + seed),
                0.22 * (Math.floor(k / 6) % 6) - 1.6 + 0.06 * Math.cos(k), 0.6]);
    if (k % 12 === 0) run(300);
  }
  const stir = () => sessions.forEach((session, i) => {
    const turn = now / 700 + 2 * i;
    if (session.hand) session.hand.wanted = [0.6 * Math.cos(turn), -1 + 0.6 * Math.sin(turn), 0.15];
  });
  run(1000);
  sessions.forEach((session, i) => session.grab(session.world.find(`cube/${9 - i}`), [0, 0, 0]));
  run(SETTLE_MS, stir);
  for (const what of Object.keys(spent)) spent[what] = 0;
  const steps = () => sessions.reduce((sum, session) => sum + session.steps, 0);
  const before = steps();
  const start = used();
  let awake = 0;
  let most = 0;
  let typical = 0;
  let looks = 0;
  run(1000 * Number(options.seconds), () => {
    stir();
    if (now % 500 !== 0) return;
    ++looks;
    awake += first.world.world.bodies.filter((body) => body.awake).length;
    const apart = [...first.apart.values()];
    most += Math.max(0, ...apart.map((one) => one.most));
    typical += Math.max(0, ...apart.map((one) => one.typical));
  });
  const all = used() - start;
  const made = steps() - before;
  const mean = (sum) => (1000 * sum / looks).toFixed(2);
  console.log(`${made} steps of one of ${PEOPLE}, ${(awake / looks).toFixed(0)} bodies awake, typically ${mean(typical)} ` +
    `and at most ${mean(most)} mm apart in the mean; ms of the processor each step:`);
  for (const [what, ms] of Object.entries(spent)) console.log(`  ${(ms / made).toFixed(2).padStart(6)}  ${what}`);
  console.log(`  ${(all / made).toFixed(2).padStart(6)}  all of it`);
  const placed = sessions.map((session) => session.peerStats().bodiesPlaced);
  console.log(`bodies put where others have them: ${placed.join(', ')}`);
} finally {
  rmSync(folder, {recursive: true});
}
