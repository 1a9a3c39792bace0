// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A room's server, native peers and pages in it, as processes and browser contexts of their own.
import {spawn} from 'node:child_process';
import {createRequire} from 'node:module';
import {existsSync, mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {createInterface} from 'node:readline';
import {fileURLToPath} from 'node:url';

const root = join(dirname(fileURLToPath(import.meta.url)), '../..');
const view = createRequire(join(root, 'tests/view/package.json'));
const {chromium} = view('playwright-core');
export const {WebSocket} = view('ws');
export const BIN = process.env.TANDEM_BIN ?? join(root, 'build/release/bin');
export const PAGE = process.env.TANDEM_ROOM_PAGE ?? join(root, 'build/web/room');
const PATHS = [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'];
// Candidates by number: the other way needs multicast, which a container may not have.
const ARGUMENTS = ['--headless=new', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader',
                   '--enable-unsafe-swiftshader', '--disable-dev-shm-usage', '--hide-scrollbars',
                   '--disable-features=WebRtcHideLocalIpsWithMdns', '--disable-background-timer-throttling',
                   '--disable-renderer-backgrounding'];

const AT_REST = 1e-3;    // m
const STILL = 1e-3;      // m, in a quarter of a second

export const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
export const distance = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));

/** Waits until `check` gives something. */
export async function until(check, what, seconds = 60) {
  for (const end = Date.now() + 1000 * seconds; Date.now() < end;) {
    const got = await check();
    if (got) return got;
    await pause(50);
  }
  throw new Error(`not within ${seconds} s: ${what}`);
}

/** @param {{core?: string}} where  the only core of all its processes, by number */
export async function startBrowser({core} = {}) {
  const executablePath = PATHS.find((path) => path && existsSync(path));
  if (core === undefined) return chromium.launch({executablePath, args: ARGUMENTS});
  const folder = mkdtempSync(join(tmpdir(), 'tandem-room-'));
  const pinned = join(folder, 'chromium');
  writeFileSync(pinned, `#!/bin/sh\nexec taskset -c ${core} '${executablePath}' "$@"\n`, {mode: 0o755});
  try {
    return await chromium.launch({executablePath: pinned, args: ARGUMENTS});
  } finally {
    rmSync(folder, {recursive: true});
  }
}

/** A program that ends with its test. @returns {Promise<object>}  once its first line is there */
async function start([program, ...options]) {
  const child = spawn(program, options, {stdio: ['pipe', 'pipe', 'inherit']});
  const over = new Promise((resolve) => child.on('close', resolve));
  const lines = createInterface({input: child.stdout});
  return {
    child, lines, over,
    stop: async (signal = 'SIGTERM') => {
      child.kill(signal);
      await over;
    },
  };
}

/** @returns {Promise<{link: string, url: string, stop: function}>}  link: with the key, url: up to the token */
export async function startServer(options = []) {
  const server = await start([join(BIN, 'tandem-room'), '--page', PAGE, ...options]);
  server.link = await new Promise((resolve, reject) => {
    server.lines.once('line', resolve);
    server.over.then((code) => reject(new Error(`tandem-room ended with ${code}`)));
  });
  server.url = server.link.slice(0, server.link.indexOf('?'));
  return server;
}

/** A peer that is no page, told by say() and heard by `heard`. @param command  that runs it, here as a program of this system */
export async function startPeer(link, room = 'sandbox', options = [], command = [join(BIN, 'tandem-room-peer')]) {
  const peer = await start([...command, link, '--scene', join(root, `tools/room/page/room-${room}.json`), ...options]);
  peer.heard = [];
  peer.others = 0;
  peer.track = [];
  peer.lines.on('line', (line) => {
    const said = JSON.parse(line);
    if (said.at) peer.track.push(said);
    else peer.heard.push(said);
    if (said.others !== undefined) peer.others = said.others;
  });
  peer.say = (line) => peer.child.stdin.write(`${line}\n`);
  peer.poses = async () => {
    const count = peer.heard.length;
    peer.say('poses');
    return until(() => peer.heard.slice(count).find(({poses}) => poses)?.poses, 'poses');
  };
  return peer;
}

/** A page in a context of its own, with the options of one, and `before`, a function that runs first in it; page.complaints is what its console and scripts complained of. */
export async function openPage(browser, link, {before, ...options} = {}) {
  const context = await browser.newContext({viewport: {width: 1000, height: 620}, ...options});
  const page = await context.newPage();
  if (before) await page.addInitScript(before);
  page.complaints = [];
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type()) && !/GPU stall due to|GL Driver Message/.test(message.text())) {
      page.complaints.push(message.text());
    }
  });
  page.on('pageerror', (error) => page.complaints.push(String(error)));
  await page.goto(link);
  await page.waitForFunction(() => window.tandemRoom?.drawing?.drawn > 0, null, {timeout: 60000});
  return page;
}

/** Something of the page's session, as `window.tandemRoom.${expression}`. */
export const ask = (page, expression) => page.evaluate(`(() => { const {session, drawing, headset, link} = window.tandemRoom;
  return ${expression}; })()`);
export const others = (page) => ask(page, 'session.members.here.length');
export const direct = (page) => ask(page, 'session.members.here.filter((m) => m.direct?.open).length');
/** By name, m. */
export const poses = (page) => ask(page, `Object.fromEntries(session.world.bodies.filter((b) => b.mass > 0)
  .map((b) => [b.name, [...b.body.position]]))`);
export const pose = (page, name) => ask(page, `[...session.world.find('${name}').body.position]`);

/** The largest distance between bodies of the same name, m. */
export function furthest(a, b) {
  return Math.max(...Object.keys(a).filter((name) => b[name]).map((name) => distance(a[name], b[name])));
}

/** Waits until nothing moves anywhere, and all are as near to each other as they are then to be. */
export async function atRest(pages, natives, what) {
  const peers = [natives ?? []].flat();
  const look = () => Promise.all([...pages.map(poses), ...peers.map((peer) => peer.poses())]);
  let before = await look();
  let apart = Infinity;
  let moved = Infinity;
  const check = async () => {
    await pause(250);
    const now = await look();
    moved = Math.max(...now.map((all, i) => furthest(all, before[i])));
    apart = Math.max(...now.flatMap((all, i) => now.slice(i + 1).map((other) => furthest(all, other))));
    before = now;
    return moved < STILL && (apart <= AT_REST || now.length === 1);
  };
  await until(check, 'rest', 30).catch(async () => {
    const bodies = Object.keys(before[0]).map((name) => [name, before.map((all) => all[name])])
      .filter(([, places]) => places.some((place) => !place || distance(place, places[0]) > AT_REST));
    const steps = await Promise.all(pages.map((page) => ask(page, 'session.steps')));
    throw new Error(`${what}: ${1000 * apart} mm apart, moved by ${1000 * moved} mm, after ${steps} steps: ${JSON.stringify(bodies)}`);
  });
}
