// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What docs/room.md says of 200 bodies and three people: steps and pictures a second of a page whose browser has one
// core, while two native peers, the server and this program have another. Each of the three holds a cube and stirs the
// heap with it, in a circle of 0.6 m in 4.4 s.
//   taskset -c 1 node tests/room/heap.mjs [--core 0] [--seconds 20] [--cpuprofile FILE]
import {writeFileSync} from 'node:fs';
import {parseArgs} from 'node:util';
import {ask, openPage, others, pause, startBrowser, startPeer, startServer, until} from './support.mjs';

const BODIES = 200;
const STIR_MS = 100;
const SETTLE_MS = 3000;

const {values: options} = parseArgs({options: {
  core: {type: 'string', default: '0'}, seconds: {type: 'string', default: '20'}, cpuprofile: {type: 'string'},
}});

/** Position of a stirring hand, m. */
const stirred = (phase) => {
  const turn = performance.now() / 700 + phase;
  return [0.6 * Math.cos(turn), -1 + 0.6 * Math.sin(turn), 0.15];
};

const look = (page) => page.evaluate(() => {
  const {session, drawing} = window.tandemRoom;
  const apart = [...session.apart.values()];
  return {
    at: performance.now(), steps: session.steps, drawn: drawing.drawn, late: session.late,
    sent: session.members.bytesSent, apart: Math.max(...apart.map(({typical}) => typical)),
    awake: session.world.world.bodies.filter((body) => body.awake).length,
  };
});

/** Between two looks. */
function rates(from, to) {
  const seconds = (to.at - from.at) / 1000;
  return {
    steps: (to.steps - from.steps) / seconds, pictures: (to.drawn - from.drawn) / seconds,
    kbit: 8e-3 * (to.sent - from.sent) / seconds / 2,
  };
}

const server = await startServer();
const browser = await startBrowser({core: options.core});
try {
  const page = await openPage(browser, server.link);
  await until(() => ask(page, 'session.running'), 'steps');
  const natives = [await startPeer(server.link), await startPeer(server.link)];
  await until(async () => await others(page) === 2, 'three');
  const count = await ask(page, 'session.world.bodies.length - 1');
  // A few at a time, so that they fall onto each other.
  for (let k = count; k < BODIES; ++k) {
    await ask(page, `session.make({type: 'box', halfExtents: [0.08, 0.08, 0.08]},
      [${0.25 * (k % 6) - 0.7}, ${0.25 * (Math.floor(k / 6) % 6) - 1.6}, ${0.4 + 0.2 * Math.floor(k / 36)}])`);
  }
  await until(async () => Object.keys(await natives[1].poses()).length >= BODIES, 'all bodies');
  await ask(page, "session.grab(session.world.find('cube/9'), [0, 0, 0])");
  const stirring = setInterval(() => {
    ask(page, `session.hand.wanted = ${JSON.stringify(stirred(0))}`).catch(() => {});
    natives.forEach((native, i) => native.say(`pull cube/${8 - i} ${stirred(2 * (i + 1)).join(' ')}`));
  }, STIR_MS);
  await pause(SETTLE_MS);
  const profiler = await page.context().newCDPSession(page);
  if (options.cpuprofile) {
    await profiler.send('Profiler.enable');
    await profiler.send('Profiler.start');
  }
  const system = await browser.newBrowserCDPSession();
  const processes = async () => (await system.send('SystemInfo.getProcessInfo')).processInfo;
  const before = await processes();
  const first = await look(page);
  let last = first;
  for (let k = 0; k < Number(options.seconds); ++k) {
    await pause(1000);
    const now = await look(page);
    const {steps, pictures} = rates(last, now);
    console.log(`${steps.toFixed(1)} steps/s, ${pictures.toFixed(1)} pictures/s, ${now.awake} awake, ` +
      `${now.late.toFixed(1)} ms late, typically ${(1000 * now.apart).toFixed(2)} mm apart`);
    last = now;
  }
  const {steps, pictures, kbit} = rates(first, last);
  console.log(`all: ${steps.toFixed(1)} steps/s, ${pictures.toFixed(1)} pictures/s, ${kbit.toFixed(0)} kbit/s to each`);
  for (const {type, id, cpuTime} of await processes()) {
    const share = (cpuTime - (before.find((one) => one.id === id)?.cpuTime ?? 0)) / (last.at - first.at) * 1000;
    if (share > 0.01) console.log(`${type}: ${(100 * share).toFixed(0)} % of the core`);
  }
  if (options.cpuprofile) {
    const {profile} = await profiler.send('Profiler.stop');
    writeFileSync(options.cpuprofile, JSON.stringify(profile));
  }
  clearInterval(stirring);
  for (const native of natives) {
    native.say('quit');
    await native.over;
  }
} finally {
  await browser.close();
  await server.stop();
}
