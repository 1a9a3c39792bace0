// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What a page costs: Mbit/s, frames per second, and how much more of a core the program takes with
// a page than without one.
//   TANDEM_BIN=build/release/bin node tests/view/load.mjs [DEMO [OPTION..]]
import {readFileSync} from 'node:fs';
import {startDemo} from './demo.mjs';
import {Observer, until} from './observer.mjs';

const SPAN = 10;    // s of each measurement
const TICKS = 100;  // per second, of /proc

/** CPU time of a process, s. */
function cpu(pid) {
  const fields = readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ');
  return (Number(fields[11]) + Number(fields[12])) / TICKS;
}

async function measure(pid, what) {
  const begin = {cpu: cpu(pid), wall: performance.now(), ...what()};
  await new Promise((resolve) => setTimeout(resolve, 1000 * SPAN));
  const wall = (performance.now() - begin.wall) / 1000;
  const end = what();
  return {core: (cpu(pid) - begin.cpu) / wall, mbit: 8e-6 * (end.bytes - begin.bytes) / wall,
          fps: (end.frames - begin.frames) / wall, session: (end.time - begin.time) / wall};
}

const [name = 'cliff', ...options] = process.argv.slice(2);
const demo = await startDemo(name, ['--seconds', '3600', ...options]);
try {
  // Each time the same part of the session.
  const from = async () => {
    const one = await new Observer(demo.url).ready();
    one.send({type: 'restart'});
    await until(() => one.last.time < 1, 'the beginning');
    await until(() => one.last.time > 1.5, 'the fall');
    return one;
  };
  const first = await from();
  first.close();
  const none = await measure(demo.pid, () => ({bytes: 0, frames: 0, time: 0}));
  const watcher = await from();
  const one = await measure(demo.pid, () => ({bytes: watcher.bytes, frames: watcher.frames,
                                              time: watcher.last.time}));
  const bodies = watcher.hello.bodies.length;
  const n = (value) => value.toFixed(2);
  console.log(`${name}: ${bodies} bodies, ${watcher.hello.peers.length} peers`);
  console.log(`no page:  ${n(100 * none.core)} % of a core`);
  console.log(`one page: ${n(100 * one.core)} % of a core, ${n(one.mbit)} Mbit/s, ` +
              `${n(one.fps)} frames/s, ${n(one.session)} s of the session per second`);
  watcher.close();
} finally {
  await demo.stop();
}
