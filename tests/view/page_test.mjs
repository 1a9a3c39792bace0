// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The page against the mock server: what it draws, what it says, what it bears.
import assert from 'node:assert/strict';
import {after, afterEach, before, describe, test} from 'node:test';
import {openPage, startBrowser} from './browser.mjs';
import {dragFinger, dragMouse, pinch} from './gestures.mjs';
import {startMock} from './mock/server.mjs';
import {PACE, PACE_START} from './mock/world.mjs';
import {distance, until} from './observer.mjs';

const PHONE = {viewport: {width: 390, height: 844}, hasTouch: true, isMobile: true};
/** A click that waits for no pictures, which come seldom where the machine is busy. */
const press = (page, id) => page.$eval(`#${id}`, (button) => button.click());
const view = (page, expression) => page.evaluate(`window.tandemView.${expression}`);

describe('the page', {timeout: 600000}, () => {
  let browser;
  let server;
  let page;
  before(async () => { browser = await startBrowser(); });
  after(async () => { await browser?.close(); });
  afterEach(async () => {
    await page?.context().close();
    await server?.close();
    page = server = null;
  });

  const open = async ({mock = {}, query = '', ...options} = {}) => {
    server = await startMock(mock);
    page = await openPage(browser, server.url + query, options);
    return page;
  };
  const said = (type) => server.received.filter((message) => message.type === type);

  test('draws every shape in two panes and has nothing to complain about', async () => {
    await open({query: '?marks=1'});
    await until(() => view(page, 'drawn > 3'), 'pictures');
    assert.equal(await view(page, 'panes.length'), 2);
    assert.equal(await view(page, 'errors'), 0);
    const poses = await view(page, 'poses(0)');
    assert.ok(distance(poses.cube.slice(0, 3), [0, -0.3, 0.15]) < 1e-3);
    await until(() => view(page, 'peers[0].contacts > 0'), 'overlays');
    // Each body is drawn where the page says it is: there is something else than around it.
    for (const body of ['box', 'sphere', 'capsule', 'cylinder', 'cone', 'mesh', 'cube']) {
      const hit = await page.evaluate((name) => {
        const [x, y] = window.tandemView.project(name, 1);
        return window.tandemView.bodyAt(x, y);
      }, body);
      assert.equal(hit, body);
    }
    assert.deepEqual(page.complaints, []);
  });

  test('a drag holds the body where it was touched and moves it in the plane before one',
       async () => {
    await open();
    const before = await view(page, 'poses(0)');
    await dragMouse(page, 'cube', 0, [60, 0]);
    await until(() => said('move').length > 0, 'a move');
    await page.mouse.up();
    await until(() => said('release').length > 0, 'the release');
    const [grab] = said('grab');
    assert.equal(grab.pane, 0);
    assert.equal(server.world.bodies[grab.body].name, 'cube');
    // On the cube's surface.
    assert.ok(distance(grab.point, before.cube.slice(0, 3)) < 0.15 * Math.sqrt(3) + 1e-6);
    const last = said('move').at(-1);
    assert.equal(last.id, grab.id);
    assert.equal(said('release')[0].id, grab.id);
    // To the right of the picture: the same height, and where the pointer is.
    assert.ok(Math.abs(last.point[2] - grab.point[2]) < 1e-6);
    const place = async (point) => page.evaluate((p) => window.tandemView.project(0, 0, p), point);
    const [x0, y0] = await place(grab.point);
    const [x1, y1] = await place(last.point);
    assert.ok(Math.abs(x1 - x0 - 60) < 0.1 && Math.abs(y1 - y0) < 0.1, `${[x0, y0, x1, y1]}`);
    assert.deepEqual(page.complaints, []);
  });

  test('what a user owns cannot be held, nor the ground; there one turns the view', async () => {
    await open();
    const before = await view(page, "project('cube', 0)");
    await dragMouse(page, 'hand', 0, [80, 0]);
    await page.mouse.up();
    const after = await view(page, "project('cube', 0)");
    assert.deepEqual(said('grab'), []);
    assert.ok(distance(before, after) > 1);
  });

  test('keys and fields ask the server, and show what it says', async () => {
    await open();
    await page.keyboard.press('Space');
    await until(() => view(page, 'settings.paused'), 'a pause');
    assert.equal(await page.getAttribute('#pause', 'aria-pressed'), 'true');
    const {number} = server.world;
    await page.keyboard.press('.');
    await until(() => server.world.number === number + 1, 'one step');
    await page.keyboard.press('Space');
    await until(async () => !(await view(page, 'settings.paused')), 'a run');
    await page.selectOption('#profile', '5');
    await until(() => view(page, 'settings.profile === 5'), 'profile 5');
    await page.selectOption('#scheme', 'two-step');
    await until(() => view(page, "settings.scheme === 'two-step'"), 'a scheme');
    await page.focus('#influence');
    await page.keyboard.press('ArrowRight');
    await until(() => view(page, 'settings.influence > 0.085'), 'an influence');
    await page.keyboard.press('Escape');
    await page.locator('#view').focus();
    await page.keyboard.press('o');
    assert.equal(await view(page, 'panes.length'), 1);
    // A setting of another page is shown here.
    server.obey({id: 99}, {type: 'set', name: 'speed', value: 0.25});
    await until(async () => (await page.textContent('#speed-value')) === '0.25×', 'a speed');
    assert.deepEqual(await view(page, 'messages'), []);
    assert.deepEqual(page.complaints, []);
  });

  test('two windows are two users: each shows and pulls its own peer', async () => {
    await open({query: '?pane=1'});
    assert.deepEqual(await view(page, 'panes.map((pane) => pane.peer)'), [1]);
    await dragMouse(page, 'cube', 1, [40, 0]);
    await page.mouse.up();
    await until(() => said('grab').length, 'a grab');
    assert.equal(said('grab')[0].pane, 1);
  });

  test('on a phone a finger pulls, two zoom, and the settings come up', async () => {
    await open(PHONE);
    const panes = await view(page, 'panes');
    assert.equal(panes[0].x, panes[1].x, 'one above the other');
    assert.ok(await page.evaluate('document.documentElement.scrollWidth <= innerWidth'));
    await dragFinger(page, 'cube', 1, [0, -60]);
    await until(() => said('release').length, 'a release');
    assert.equal(said('grab')[0].pane, 1);
    assert.ok(said('move').at(-1).point[2] > said('grab')[0].point[2] + 0.05);
    const size = async () => distance(...(await Promise.all(
      ["'cube'", "'box'"].map((name) => view(page, `project(${name}, 0)`)))));
    const before = await size();
    await pinch(page, [195, 120], 2);
    const factor = await size() / before;
    assert.ok(factor > 1.6 && factor < 2.4, `${factor}`);
    await page.tap('#more');
    assert.ok(await page.isVisible('#plot-latency'));
    assert.deepEqual(page.complaints, []);
  });

  test('comes back when the server does, and lets go of what it held', async () => {
    await open();
    await dragMouse(page, 'cube', 0, [30, 0]);
    await until(() => said('grab').length, 'a grab');
    const {port, token} = server;
    await server.close();
    await until(async () => !(await view(page, 'connected')), 'the loss');
    assert.match(await page.textContent('#state'), /no connection/);
    server = await startMock({port, token, balls: 20, scene: 'balls'});
    await until(() => view(page, "scene === 'balls'"), 'the return');
    await until(() => view(page, "poses(0)['ball/19'] !== undefined"), 'a frame');
    await page.mouse.move(500, 300);
    await page.mouse.up();
    const frames = await view(page, 'frames');
    await until(() => view(page, `frames > ${frames} + 5`), 'more frames');
    const hands = server.received.filter(({type}) => ['grab', 'move', 'release'].includes(type));
    assert.deepEqual(hands, []);
  });

  test('rubbish from the server is counted and borne', async () => {
    await open();
    const [client] = server.clients;
    const rubbish = [new Uint8Array(0), new Uint8Array(100).fill(255), 'no JSON', '7', 'null'];
    for (const each of rubbish) client.socket.send(each);
    // A later server may say more than this page knows.
    client.socket.send('{"type":"news"}');
    const frames = await view(page, 'frames');
    await until(() => view(page, `frames > ${frames} + 5`), 'more frames');
    assert.equal(await view(page, 'errors'), rubbish.length);
    assert.deepEqual(page.complaints, []);
  });

  test('a thousand balls are drawn', async () => {
    await open({mock: {balls: 1000, scene: 'balls'}});
    await until(() => view(page, 'drawn > 3'), 'pictures');
    assert.equal(await view(page, 'errors'), 0);
    assert.deepEqual(page.complaints, []);
  });

  test('a session over a network is shown, and nothing can be switched', async () => {
    await open({mock: {live: false}});
    assert.ok(await page.isVisible('#not-live'));
    for (const id of ['pause', 'step', 'restart', 'profile', 'speed']) {
      assert.ok(await page.isDisabled(`#${id}`), id);
    }
    await page.keyboard.press('Space');
    await dragMouse(page, 'cube', 0, [40, 0]);
    await page.mouse.up();
    await until(() => said('grab').length, 'a grab');
    assert.deepEqual(said('set'), []);
  });

  test('one click shows the run without agreement beside it, and a hand acts in both', async () => {
    await open({mock: {settings: {profile: 5}}, viewport: {width: 760, height: 380}});
    await press(page, 'compare');
    await until(() => view(page, 'panes.length === 4'), 'four panes');
    const drawn = await view(page, 'drawn');
    await until(() => view(page, `drawn > ${drawn} + 1`), 'two pictures');
    assert.deepEqual(said('set'), [{type: 'set', name: 'beside', value: 'none'}]);
    const panes = await view(page, 'panes');
    // Side by side: the same peer at the same height.
    for (const p of [0, 1]) {
      assert.equal(panes[p].y, panes[p + 2].y);
      assert.ok(panes[p + 2].x >= panes[p].x + panes[p].width);
    }
    assert.match(await page.textContent('.run-0'), /^Agreement/);
    assert.match(await page.textContent('.run-1'), /^No agreement/);
    const start = await Promise.all([0, 1, 2, 3].map((p) => view(page, `poses(${p}).cube`)));
    await dragMouse(page, 'cube', 2, [0, -50]);
    await until(async () => distance((await view(page, 'poses(0).cube')).slice(0, 3),
                                     start[0].slice(0, 3)) > 0.1, 'the pull in the other run');
    assert.equal(said('grab')[0].pane, 2);
    await until(async () => (await view(page, 'furthest'))[1] > 0.05, 'copies apart');
    assert.match(await page.textContent('#apart-1'), /furthest apart .*cube/);
    await page.mouse.up();
    await press(page, 'compare');
    await until(() => view(page, 'panes.length === 2'), 'two panes');
    assert.equal(said('set').at(-1).value, null);
    assert.deepEqual(page.complaints, []);
  });

  test('what is drawn is of one instant, however seldom frames come', async () => {
    const every = 9;
    await open({mock: {every}, query: '?marks=1', viewport: {width: 480, height: 320}});
    await until(() => view(page, 'peers[0].contacts > 0'), 'marks');
    const pace = server.world.bodies.findIndex(({name}) => name === 'pace');
    const between = new Set();
    await until(async () => {
      const {time, peers} = await view(page, 'drawnNow');
      for (const {positions, contacts} of peers) {
        const x = PACE_START + PACE * time;
        assert.ok(Math.abs(positions[3 * pace] - x) < 1e-4, `${positions[3 * pace]} is not ${x}`);
        const mark = contacts.find(({body}) => body === pace);
        if (mark) assert.ok(Math.abs(mark.point[0] - x) < 2e-4, `${mark.point[0]} is not ${x}`);
      }
      const frames = 60 * time / every;
      if (peers[0].contacts.length && Math.abs(frames - Math.round(frames)) > 0.05) between.add(time);
      return between.size > 3;
    }, 'instants between frames', 120);
  });

  test('a run that is over tells the score, and begins again when asked', async () => {
    await open();
    server.end();
    await until(() => page.isVisible('#ending'), 'the score');
    assert.match(await page.textContent('#ending'), /The run is over/);
    const score = await page.textContent('#ending-score');
    assert.match(score, /hits23/);
    assert.match(score, /plate lifted22 cm/);
    assert.match(score, /B: tasks done2/);
    assert.equal(await page.evaluate('document.activeElement.id'), 'ending-again');
    await press(page, 'ending-again');
    await until(() => said('restart').length === 1, 'a restart');
    assert.ok(await page.isHidden('#ending'));
    // A program that ends says so, and is not asked again.
    const {port, token} = server;
    await server.close(1001);
    await until(async () => !(await view(page, 'connected')), 'the end');
    assert.match(await page.textContent('#state'), /has ended/);
    assert.ok(await page.isVisible('#ending'));
    assert.ok(await page.isHidden('#ending-again'));
    server = await startMock({port, token});
    await new Promise((resolve) => setTimeout(resolve, 2500));
    assert.equal(server.clients.size, 0);
  });

  test('a program that does not answer is given up, until somebody asks for it', async () => {
    await open();
    // The page waits for a tenth of what it asks for, and says what that was.
    await page.evaluate(() => {
      const wait = window.setTimeout;
      window.waits = [];
      window.setTimeout = (then, ms, ...more) => {
        if (ms >= 500) window.waits.push(ms);
        return wait(then, ms >= 500 ? ms / 10 : ms, ...more);
      };
    });
    const {port, token} = server;
    await server.close();
    await until(async () => /does not answer/.test(await page.textContent('#state')), 'the end', 90);
    assert.deepEqual(await page.evaluate('window.waits'), [500, 1000, 2000, 4000, 8000, 8000]);
    server = await startMock({port, token});
    await press(page, 'ending-again');
    await until(() => view(page, 'connected'), 'the return');
    assert.ok(await page.isHidden('#ending'));
  });

  test('by keys a body is chosen, held and moved', async () => {
    await open();
    await page.locator('#view').focus();
    await page.keyboard.press('2');
    for (let i = 0; i < 7; ++i) await page.keyboard.press('n');
    assert.match(await page.textContent('#spoken'), /^cube: enter/);
    await page.keyboard.press('Enter');
    await until(() => said('grab').length, 'a grab');
    const [grab] = said('grab');
    assert.equal(server.world.bodies[grab.body].name, 'cube');
    assert.equal(grab.pane, 1);
    for (let i = 0; i < 5; ++i) await page.keyboard.press('ArrowUp');
    await until(() => said('move').length && said('move').at(-1).point[2] > grab.point[2] + 0.05,
                'a move up');
    await page.keyboard.press('Enter');
    await until(() => said('release').length === 1, 'the release');
    // Now arrows turn the view.
    const before = await view(page, "project('cube', 0)");
    await page.keyboard.press('ArrowLeft');
    assert.ok(distance(before, await view(page, "project('cube', 0)")) > 1);
    assert.deepEqual(page.complaints, []);
  });

  for (const [name, options] of Object.entries({desktop: {}, phone: PHONE})) {
    test(`${name}: what is pressed is 44 px, what is drawn has a name`, async () => {
      await open(options);
      if (name === 'phone') await press(page, 'more');
      const small = await page.$$eval('button, select, input', (all) => all
        .filter((element) => element.offsetParent !== null)
        .map((element) => ({id: element.id, ...element.getBoundingClientRect().toJSON()}))
        .filter(({width, height}) => width < 44 || height < 44));
      assert.deepEqual(small, []);
      assert.ok(await page.evaluate('document.documentElement.scrollWidth <= innerWidth'));
      await until(async () => (await page.$$eval('canvas', (all) => all.map(
        (canvas) => canvas.getAttribute('aria-label')))).every(Boolean), 'names of all canvases');
      assert.match(await page.getAttribute('#plot-latency canvas', 'aria-label'), /95 % below/);
      await until(async () => /There and back: peers 57 ms, this page/.test(
        await page.textContent('#facts')), 'round trips');
      assert.ok((await page.textContent('#sentence')).length > 40);
    });
  }
});
