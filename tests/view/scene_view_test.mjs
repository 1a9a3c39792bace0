// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// scene_view: a scene file on the page of the live view.
import assert from 'node:assert/strict';
import {spawnSync} from 'node:child_process';
import {mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, describe, test} from 'node:test';
import {openPage, startBrowser} from './browser.mjs';
import {startDemo} from './demo.mjs';
import {dragMouse} from './gestures.mjs';
import {distance, Observer, until} from './observer.mjs';

/** A long hull on a low table in a hall: corners far from the body's centre. */
const LONG = [[0, 0, 0], [3, 0, 0], [0, 0.2, 0], [0, 0, 0.2]];
const SCENE = {bodies: [
  {name: 'ground', type: 'static', shape: {type: 'halfSpace'}},
  {name: 'hall', type: 'static', shape: {type: 'box', halfExtents: [60, 60, 0.1]}, position: [0, 0, 40]},
  {name: 'table', type: 'static', shape: {type: 'box', halfExtents: [1, 0.5, 0.05]}, position: [0, 0, 0.05]},
  {name: 'long', shape: {type: 'hull', points: LONG}, mass: 1, position: [0, 0, 0.1]},
  {name: 'ball', shape: {type: 'sphere', radius: 0.2}, mass: 1, position: [-0.5, 0, 0.3]},
]};

const view = (page, expression) => page.evaluate(`window.tandemView.${expression}`);

describe('a scene file', {timeout: 600000}, () => {
  let folder;
  let browser;
  let shown;
  let observer;
  let page;
  before(async () => {
    folder = mkdtempSync(join(tmpdir(), 'tandem-'));
    writeFileSync(join(folder, 'long.json'), JSON.stringify(SCENE));
    shown = await startDemo('scene_view', ['--paused', '--ground', '--scene', join(folder, 'long.json')]);
    observer = await new Observer(shown.url).ready();
    browser = await startBrowser();
    page = await openPage(browser, shown.page);
  });
  after(async () => {
    observer?.close();
    await browser?.close();
    await shown?.stop();
    rmSync(folder, {recursive: true});
  });

  test('its bodies and static parts are there, under its name', async () => {
    assert.equal(observer.hello.scene, 'long.json');
    assert.equal(observer.hello.alone, true);
    assert.deepEqual(observer.hello.bodies.map(({name}) => name), ['long', 'ball']);
    assert.deepEqual(observer.hello.fixed.map(({shape}) => shape), ['half_space', 'box', 'box']);
    assert.deepEqual(page.complaints, []);
    assert.equal(await view(page, 'errors'), 0);
  });

  test('all of it is in the picture and fills most of it, the hall aside', async () => {
    const corners = [...LONG.map(([x, y, z]) => [x, y, z + 0.1]), [-1, -0.5, 0], [-1, 0.5, 0]];
    const places = [];
    for (const corner of corners) {
      places.push(await page.evaluate((p) => window.tandemView.project(0, 0, p), corner));
    }
    const box = await page.locator('#view').boundingBox();
    const [xs, ys] = [0, 1].map((k) => places.map((place) => place[k]));
    assert.ok(Math.min(...xs) > box.x && Math.max(...xs) < box.x + box.width, `${xs}`);
    assert.ok(Math.min(...ys) > box.y && Math.max(...ys) < box.y + box.height, `${ys}`);
    const share = Math.max((Math.max(...xs) - Math.min(...xs)) / box.width,
                           (Math.max(...ys) - Math.min(...ys)) / box.height);
    assert.ok(share > 0.5, `${share}`);
  });

  test('it stands still until it is run, and a hand pulls a body', async () => {
    const before = observer.places('ball')[0];
    await new Promise((resolve) => setTimeout(resolve, 300));
    assert.equal(observer.last.time, 0);
    observer.set('paused', false);
    await observer.pass(0.2);
    await dragMouse(page, 'ball', 0, [0, -80]);
    await until(() => observer.places('ball')[0][2] > before[2] + 0.1, 'the lift');
    await page.mouse.up();
    observer.send({type: 'restart'});
    observer.set('paused', true);
    await until(() => observer.settings.paused && observer.last.time < 0.2, 'the start');
    assert.ok(distance(observer.places('ball')[0], before) < 0.05);
  });

  test('there is nothing of a session', async () => {
    for (const id of ['compare', 'score']) assert.equal(await page.isDisabled(`#${id}`), true, id);
    for (const id of ['compare', 'profile', 'plot-divergence']) {
      assert.equal(await page.isVisible(`#${id}`), false, id);
    }
    for (const id of ['pause', 'speed', 'plot-step']) assert.equal(await page.isVisible(`#${id}`), true, id);
    observer.set('scheme', 'none');
    await until(() => observer.refusals.length > 0, 'a refusal');
    assert.match(observer.refusals[0], /must be paused or speed/);
  });

  test('a file that cannot be shown ends the program with its name', () => {
    const program = join(process.env.TANDEM_BIN, 'scene_view');
    for (const [words, status, rule] of [
      [[], 2, /--scene FILE must be given/],
      [['--scene', 'model.step'], 2, /--scene must be a file that ends in .*'model.step'/],
      [['--scene', join(folder, 'none.json')], 1, /none\.json: file must be one that is there/],
      [['--scene', join(folder, 'long.json'), '--keyframe', 'home'], 2, /--keyframe must be left out/],
    ]) {
      const done = spawnSync(program, words, {encoding: 'utf8', timeout: 20000});
      assert.equal(done.status, status, `${words}: ${done.stderr}`);
      assert.match(done.stderr, rule);
    }
  });
});
