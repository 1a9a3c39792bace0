// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Makes a record of a hand without a person: drives the page of the sandbox with a pointer that moves as people's do,
// and writes what the page's button gives. Moves are minimum-jerk segments of varying lengths that end too far or too
// short and are corrected, with pauses and a tremor of 8 to 12 Hz. The page's time passes at a quarter of its pace, so that
// a busy machine gives it an event in most steps. What is drawn depends on the seed alone; when the events reach the page
// depends on the machine, so that two records of one seed differ a little.
//   node tests/room/synthetic_hands.mjs --seed 1 > benchmarks/data/hands/synthetic-pointer-1.txt
import {readFile} from 'node:fs/promises';
import {parseArgs} from 'node:util';
import {ask, openPage, pause, startBrowser, startServer, until} from './support.mjs';

const {values: {seed}} = parseArgs({options: {seed: {type: 'string', default: '1'}}});
const BODIES = ['cube/9', 'cube/7', 'cube/8', 'cube/6', 'ball/0', 'ball/1', 'domino/7', 'domino/4', 'plank/0'];
const HOLDS = 6;
// Pixels: what no panel covers, in the viewport that openPage gives.
const FIELD = {left: 350, right: 690, top: 60, bottom: 560};
const EVENT_MS = 8;        // from one event of the pointer to the next, at least
const ON_WAY = 4;          // events that the page has not answered, at most
const TREMOR = 0.7;        // pixels, rms of each axis
const PICTURE_MS = 125;    // nobody looks: the processor that draws is the one that moves the pointer
const TOO_LONG = 24;       // s
const SLOWER = 4;

/** mulberry32: numbers from 0 up to 1. */
function randomOf(state) {
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}
const random = randomOf(Number(seed));
const between = (low, high) => low + (high - low) * random();
const normal = () => Math.sqrt(-2 * Math.log(1 - random())) * Math.cos(2 * Math.PI * random());
const clamp = (x, low, high) => Math.min(high, Math.max(low, x));
/** s, of the page's time. */
const time = () => performance.now() / 1000 / SLOWER;
const rest = (seconds) => pause(1000 * SLOWER * seconds);
const minJerk = (s) => s * s * s * (10 + s * (6 * s - 15));

/** Sines on each axis, pixels at a time in s. */
function tremor() {
  const sines = [0, 1].map(() => Array.from({length: 4}, () => [between(8, 12), between(0, 2 * Math.PI)]));
  return (t) => sines.map((axis) => axis.reduce((sum, [hz, phase]) =>
    sum + TREMOR / Math.SQRT2 * Math.sin(2 * Math.PI * hz * t + phase), 0));
}
const shake = tremor();

/** The segments from one point to another: {to, seconds}. */
function reach(from, to) {
  const way = [to[0] - from[0], to[1] - from[1]];
  const length = Math.hypot(...way);
  // As long as Fitts's law has it, for a thing of 20 pixels, and not always the same.
  const seconds = (0.2 + 0.13 * Math.log2(length / 20 + 1)) * Math.exp(0.2 * normal());
  const share = 1 + 0.08 * normal();
  const aside = 0.04 * normal();
  const first = [from[0] + share * way[0] - aside * way[1], from[1] + share * way[1] + aside * way[0]];
  return [{to: first, seconds}, {to: first, seconds: between(0.05, 0.15)},
          {to, seconds: between(0.15, 0.35)}, {to, seconds: between(0.1, 0.7)}];
}

class Pointer {
  #page;
  constructor(page, at) { Object.assign(this, {at}).#page = page; }
  async go(to) {
    for (const {to: end, seconds} of reach(this.at, to)) await this.#segment(end, seconds);
  }
  async #segment(end, seconds) {
    const from = this.at;
    const start = time();
    const sent = [];
    for (let s = 0; s < 1;) {
      s = Math.min(1, (time() - start) / seconds);
      const [x, y] = shake(time());
      const done = minJerk(s);
      const next = performance.now() + EVENT_MS;
      sent.push(this.#page.mouse.move(from[0] + done * (end[0] - from[0]) + x, from[1] + done * (end[1] - from[1]) + y));
      if (sent.length >= ON_WAY) await sent.shift();
      if (next > performance.now()) await pause(next - performance.now());
    }
    await Promise.all(sent);
    this.at = end;
  }
}

/** Pulls one body about and lets go. @returns {Promise<boolean>}  whether it could be held */
async function pull(page, pointer, name) {
  const place = await ask(page, `drawing.project([...session.world.find('${name}').body.position])`);
  if (place[0] < FIELD.left || place[0] > FIELD.right || place[1] < FIELD.top || place[1] > FIELD.bottom) return false;
  await pointer.go([place[0] + 4 * normal(), place[1] + 4 * normal()]);
  await page.mouse.down();
  const held = await until(() => ask(page, 'session.hand?.held.name'), 'a hand', 1).catch(() => null);
  for (let moves = held ? 2 + Math.floor(3 * random()) : 0; moves > 0; --moves) {
    await pointer.go([clamp(pointer.at[0] + 110 * normal(), FIELD.left, FIELD.right),
                      clamp(pointer.at[1] - 40 + 80 * normal(), FIELD.top, FIELD.bottom)]);
  }
  await page.mouse.up();
  await rest(between(0.2, 0.9));
  return held !== null;
}

async function main() {
  const server = await startServer();
  const browser = await startBrowser();
  try {
    const slow = `{ const now = performance.now.bind(performance); performance.now = () => now() / ${SLOWER}; }`;
    const page = await openPage(browser, server.link, {before: slow});
    await until(() => ask(page, 'session.running'), 'steps');
    await page.evaluate((most) => {
      const {drawing, session} = window.tandemRoom;
      session.clock.take = () => {};  // the server's time has another pace
      let last = 0;
      drawing.due = (now) => now - last > most && (last = now) > 0;
    }, PICTURE_MS);
    const pointer = new Pointer(page, [520, 300]);
    await page.click('#recording summary');
    await page.click('#record');
    const end = time() + TOO_LONG;
    for (let holds = 0; holds < HOLDS && time() < end;) {
      const name = BODIES[Math.floor(BODIES.length * random())];
      if (await pull(page, pointer, name)) ++holds;
    }
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('#record')]);
    process.stdout.write(`# Synthetic pointer through the page: tests/room/synthetic_hands.mjs --seed ${seed}. No person moved.\n`);
    process.stdout.write(await readFile(await download.path(), 'utf8'));
  } finally {
    await browser.close();
    await server.stop();
  }
}

await main();
