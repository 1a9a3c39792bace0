// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What docs/room.md says a room costs: bytes, time to the first contact, and steps of 200 bodies with three people.
//   node tests/room/figures.mjs
import {readdirSync, statSync} from 'node:fs';
import {join} from 'node:path';
import {PAGE, ask, openPage, others, pause, startBrowser, startPeer, startServer, until} from './support.mjs';

const BODIES = 200;
const FOR_MS = 10000;

const bytes = readdirSync(PAGE).reduce((sum, name) => sum + statSync(join(PAGE, name)).size, 0);
console.log(`the page, all rooms: ${(bytes / 1000).toFixed(0)} kB gz`);

const server = await startServer();
const browser = await startBrowser();
try {
  const first = await openPage(browser, server.link);
  await until(() => ask(first, 'session.running'), 'steps');
  const times = [];
  for (let k = 0; k < 5; ++k) {
    const page = await openPage(browser, server.link);
    times.push(await page.evaluate(() => new Promise((resolve) => {
      const look = () => {
        const {session} = window.tandemRoom;
        const heard = session.running && Number(session.peerStats().updatesReceived) > 0;
        if (heard) resolve(performance.now());
        else setTimeout(look, 5);
      };
      look();
    })));
    await page.context().close();
  }
  times.sort((a, b) => a - b);
  console.log(`first contact after ${times.map((t) => t.toFixed(0)).join(', ')} ms of opening the page`);

  const second = await openPage(browser, server.link);
  const native = await startPeer(server.link);
  await until(async () => await others(first) === 2 && await others(second) === 2, 'three');
  const count = await ask(first, 'session.world.bodies.length - 1');
  // A few at a time, so that they fall onto each other.
  for (let k = count; k < BODIES; ++k) {
    await ask(first, `session.make({type: 'box', halfExtents: [0.08, 0.08, 0.08]},
      [${0.25 * (k % 6) - 0.7}, ${0.25 * (Math.floor(k / 6) % 6) - 1.6}, ${0.4 + 0.2 * Math.floor(k / 36)}])`);
  }
  await until(async () => await ask(second, 'session.world.bodies.length') > BODIES, 'all bodies');
  const pages = [first, second];
  for (const page of pages) {
    await page.evaluate(() => {
      const {session} = window.tandemRoom;
      const advance = session.advance.bind(session);
      window.spent = {ms: 0, steps: 0, most: 0};
      session.advance = () => {
        const begin = performance.now();
        const steps = advance();
        if (steps > 0) {
          window.spent.ms += performance.now() - begin;
          window.spent.steps += steps;
          window.spent.most = Math.max(window.spent.most, (performance.now() - begin) / steps);
        }
      };
    });
  }
  // Three people stir the heap.
  const stir = (page, name, phase) => page.evaluate(([body, at]) => {
    const {session} = window.tandemRoom;
    session.grab(session.world.find(body), [0, 0, 0]);
    window.stirring = setInterval(() => {
      const turn = performance.now() / 700 + at;
      session.hand.wanted = [0.6 * Math.cos(turn), -1 + 0.6 * Math.sin(turn), 0.15];
    }, 20);
  }, [name, phase]);
  await stir(first, 'cube/9', 0);
  await stir(second, 'cube/8', 2);
  const sent = await Promise.all(pages.map((page) => ask(page, 'session.members.bytesSent')));
  for (let k = 0; k < FOR_MS / 100; ++k) {
    native.say(`pull cube/7 ${0.6 * Math.cos(k / 7 + 4)} ${-1 + 0.6 * Math.sin(k / 7 + 4)} 0.15`);
    await pause(100);
  }
  for (const [i, page] of pages.entries()) {
    const {ms, steps, most} = await page.evaluate(() => window.spent);
    const rate = 8e-3 * (await ask(page, 'session.members.bytesSent') - sent[i]) / (FOR_MS / 1000) / 2;
    const apart = await ask(page, 'Math.max(...[...session.apart.values()].map((one) => one.typical))');
    console.log(`page ${i + 1}: ${(ms / steps).toFixed(2)} ms a step with ${BODIES} bodies, at most ${most.toFixed(1)} ms, ` +
      `${(1000 * steps / FOR_MS).toFixed(1)} steps a second, ${rate.toFixed(0)} kbit/s to each, ` +
      `typically ${(1000 * apart).toFixed(2)} mm apart`);
  }
  native.say('quit');
  await native.over;
} finally {
  await browser.close();
  await server.stop();
}
