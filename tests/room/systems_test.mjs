// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// One room of a page, a native peer, one of Windows on wine and one of ARM on qemu, as far as their programs are built:
// what one lifts is lifted at all, and at rest all are within 1 mm.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {existsSync, mkdirSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {after, before, describe, test} from 'node:test';
import {fileURLToPath} from 'node:url';
import {atRest, openPage, others, pose, startBrowser, startPeer, startServer, until} from './support.mjs';

const build = join(dirname(fileURLToPath(import.meta.url)), '../../build');
const SYSTEMS = [
  {name: 'Windows', program: join(build, 'windows/bin/tandem-room-peer.exe'), emulator: ['wine']},
  {name: 'ARM', program: join(build, 'arm64/bin/tandem-room-peer'), emulator: ['qemu-aarch64', '-L', '/usr/aarch64-linux-gnu']},
].filter(({program}) => existsSync(program));
const LIFTED = 0.2;  // m
// Wine's files lie in the build folder; of the 32 bit half that it misses it says nothing.
process.env.WINEPREFIX ??= join(build, 'wine');
process.env.WINEDEBUG ??= '-all';

describe('a room of all systems', {timeout: 300000, skip: SYSTEMS.length === 0 && 'no programs for other systems'}, () => {
  let server;
  let browser;
  let page;
  let peers;
  before(async () => {
    if (SYSTEMS.some(({emulator}) => emulator[0] === 'wine')) {
      mkdirSync(process.env.WINEPREFIX, {recursive: true});
      execFileSync('wine', ['wineboot', '--init'], {stdio: 'ignore'});
    }
    server = await startServer();
    browser = await startBrowser();
    page = await openPage(browser, server.link);
    peers = await Promise.all([
      startPeer(server.link, 'sandbox', ['--name', 'native']),
      ...SYSTEMS.map(({name, program, emulator}) => startPeer(server.link, 'sandbox', ['--name', name], [...emulator, program])),
    ]);
    let met;
    await until(async () => {
      met = [await others(page), ...peers.map((peer) => peer.others)];
      return met.every((count) => count === peers.length);
    }, 'that all meet').catch((problem) => {
      throw new Error(`${problem.message}: page and peers have met ${met}`);
    });
  });
  after(async () => {
    for (const peer of peers ?? []) peer.say('quit');
    await Promise.all((peers ?? []).map((peer) => peer.over));
    await browser?.close();
    await server?.stop();
  });

  for (const [i, name] of ['native', ...SYSTEMS.map((system) => system.name)].entries()) {
    test(`what the peer of ${name} lifts is lifted at all`, async () => {
      const body = `domino/${i}`;
      const [x, y, z] = await pose(page, body);
      peers[i].say(`pull ${body} ${x} ${y - 0.3} ${z + 0.4}`);
      const heights = async () => [(await pose(page, body))[2],
                                   ...await Promise.all(peers.map(async (peer) => (await peer.poses())[body][2]))];
      await until(async () => (await heights()).every((height) => height > z + LIFTED), `${body} lifted at all`);
      peers[i].say('release');
      await atRest([page], peers, `after ${name}`);
    });
  }
  test('nobody complains', () => {
    assert.deepEqual(page.complaints, []);
    assert.deepEqual(peers.flatMap((peer) => peer.heard.filter(({refused}) => refused)), []);
  });
});
