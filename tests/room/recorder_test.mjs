// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// "Record my hand": what the file has, and that the demos' own reader takes it.
import assert from 'node:assert/strict';
import {spawnSync} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {readFile} from 'node:fs/promises';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {test} from 'node:test';
import {Recorder} from '../../tools/room/page/recorder.js';
import {BIN, ask, openPage, startBrowser, startServer, until} from './support.mjs';

const CUBE = 'cube/9';  // the uppermost one
const STEP_MS = 1000 / 60;

/** What a demo's users did by that record, by its own account: lines of words. */
function played(text, seconds) {
  const folder = mkdtempSync(join(tmpdir(), 'tandem-hand-'));
  try {
    const [hand, inputs] = ['hand.txt', 'inputs.txt'].map((name) => join(folder, name));
    writeFileSync(hand, text);
    const options = ['--script', `hands=${hand}`, '--peers', '1', '--seconds', String(seconds), '--print', 'nothing', '--record', inputs];
    const {status, stderr, error} = spawnSync(join(BIN, 'cubes'), options, {encoding: 'utf8'});
    assert.equal(error, undefined);
    assert.ok(status === 0, stderr);
    return readFileSync(inputs, 'utf8').trim().split('\n').map((line) => line.split(' '));
  } finally {
    rmSync(folder, {recursive: true});
  }
}

const hand = (name, wanted) => ({held: {name}, attachment: [0, 0, 0.1], wanted});

test('a record has grabs, moves and releases, and whose a made body is it does not tell', () => {
  const recorder = new Recorder('sandbox');
  const first = hand('cube/9', [1, 2, 3]);
  recorder.step(5000, null);
  recorder.step(5100, first);
  first.wanted = [1, 2, 3.25];
  recorder.step(5200, first);
  recorder.step(5300, hand('made/7f00deadbeef-3', [0, 0, 1 / 3]));
  assert.equal(recorder.end(), ['tandem-hand 1', 'room sandbox', 'rate 60', '0.1 grab cube/9 0 0 0.1 1 2 3',
                                '0.2 move 1 2 3.25', '0.3 let', '0.3 grab made 0 0 0.1 0 0 0.3333', '0.3 let', '0.3 end',
                                ''].join('\n'));
  assert.equal(new Recorder('piano').end(), 'tandem-hand 1\nroom piano\nrate 60\n0 end\n');
});

test('a record is bounded, and the demos read the longest', () => {
  const recorder = new Recorder('sandbox');
  const held = hand('cube/9', [-12.34567, -12.34567, -12.34567]);
  for (let i = 0; i < 60 * 700; ++i) recorder.step(i * STEP_MS, held);
  recorder.step(1e9, held);
  const text = recorder.end();
  assert.ok(text.endsWith('\n600 let\n600 end\n'));
  assert.ok(text.length < 2.5e6);
  assert.ok(played(text, 0.2).some(([, , kind]) => kind === 'grab'));
});

test('the button keeps a drag, and the demos read its file', {timeout: 120000}, async () => {
  const server = await startServer();
  const browser = await startBrowser();
  try {
    const page = await openPage(browser, server.link);
    await until(() => ask(page, 'session.running'), 'steps');
    const button = page.locator('#record');
    assert.equal(await button.getAttribute('aria-pressed'), 'false', 'off at first');
    await page.click('#recording summary');
    assert.match(await page.textContent('#recording'), /nothing of others/);
    await button.click();
    assert.equal(await button.getAttribute('aria-pressed'), 'true');
    const [x, y] = await ask(page, `drawing.project([...session.world.find('${CUBE}').body.position])`);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await until(() => ask(page, 'session.hand?.held.name'), 'a hand');
    const from = await ask(page, 'session.hand.wanted');
    const begun = await ask(page, 'session.steps');
    await until(() => ask(page, `session.steps > ${begun} + 1`), 'a step that grabs');
    for (let i = 1; i <= 8; ++i) await page.mouse.move(x + 6 * i, y - 12 * i);
    // The last of them has come, and steps have been made with it.
    const to = await until(() => ask(page, `session.hand.wanted[2] > ${from[2]} + 0.1 && session.hand.wanted`), 'a move');
    const steps = await ask(page, 'session.steps');
    await until(() => ask(page, `session.steps > ${steps} + 5`), 'steps');
    const last = await ask(page, 'session.hand.wanted');
    await page.mouse.up();
    await until(() => ask(page, `session.hand === null && session.steps > ${steps} + 10`), 'a release');
    const [download] = await Promise.all([page.waitForEvent('download'), button.click()]);
    assert.equal(download.suggestedFilename(), 'hand-sandbox.txt');
    assert.equal(await button.getAttribute('aria-pressed'), 'false', 'off again');
    const text = await readFile(await download.path(), 'utf8');
    const words = text.trim().split('\n').slice(3).map((line) => line.split(' '));
    assert.deepEqual(words.map(([, kind]) => kind).filter((kind) => kind !== 'move'), ['grab', 'let', 'end']);
    assert.equal(words[0][2], CUBE);
    const close = (a, b) => assert.ok(a.every((v, i) => Math.abs(Number(v) - b[i]) < 1e-4), `${a} is not ${b}`);
    close(words[0].slice(6), from);
    close(words.at(-3).slice(2), last);
    assert.ok(to[2] - from[2] > 0.1);

    // As the demo has it: it holds its first body, and its hand goes as far up.
    const inputs = played(text, Number(words.at(-1)[0]) + 1);
    const grab = inputs.find(([, , kind]) => kind === 'grab');
    const rise = inputs.filter(([, , kind]) => kind === 'move').map((line) => Number(line[7]) - Number(grab[10]));
    assert.ok(inputs.some(([, , kind]) => kind === 'let'), 'it lets go');
    assert.ok(Math.max(...rise) > 0.05, `the drag is found: ${Math.max(...rise)}`);
    assert.deepEqual(page.complaints, []);
  } finally {
    await browser.close();
    await server.stop();
  }
});
