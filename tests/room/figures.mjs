// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What docs/room.md says a room costs: bytes and time to the first contact; heap.mjs has 200 bodies.
//   node tests/room/figures.mjs
import {readdirSync, statSync} from 'node:fs';
import {join} from 'node:path';
import {PAGE, ask, openPage, startBrowser, startServer, until} from './support.mjs';

const bytes = readdirSync(PAGE).reduce((sum, name) => sum + statSync(join(PAGE, name)).size, 0);
console.log(`the page, all rooms: ${(bytes / 1000).toFixed(0)} kB gz`);

/** Runs in a page: when it takes part and has heard of others' bodies, ms after it was opened. */
function watch() {
  const timer = setInterval(() => {
    if (!window.tandemRoom?.session.greeted) return;
    window.contact = performance.now();
    clearInterval(timer);
  }, 5);
}

const server = await startServer();
const browser = await startBrowser();
try {
  const first = await openPage(browser, server.link);
  await until(() => ask(first, 'session.running'), 'steps');
  const times = [];
  for (let k = 0; k < 5; ++k) {
    const page = await openPage(browser, server.link, {before: watch});
    times.push(await until(() => page.evaluate('window.contact'), 'the first contact'));
    await page.context().close();
  }
  times.sort((a, b) => a - b);
  console.log(`first contact after ${times.map((t) => t.toFixed(0)).join(', ')} ms of opening the page`);
} finally {
  await browser.close();
  await server.stop();
}
