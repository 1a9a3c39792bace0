// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Two emulated headsets and a page without one in the piano's room: what docs/room.md promises of headsets.
import assert from 'node:assert/strict';
import {after, before, describe, test} from 'node:test';
import {EYES, enter, handOf, headOf, move, openHeadset, press, put, seen, stick} from './headset.mjs';
import {ask, atRest, distance, furthest, openPage, others, pause, pose, poses, startBrowser, startServer, until}
  from './support.mjs';

const CRATE = 'crate/2';
const TOP = [0, 0, 0.14]; // m, of the crate
const LIFT = 0.4;        // m
const HELD = 0.04;       // m, that a hand's load may stay behind
const CARRIED = 0.35;    // m, up and along
const MOVED = 0.01;      // m: less is at rest
const TURN = Math.PI / 3;
const TRIES = 4;
const SNAP = 30;         // degrees
const SEEN = 0.02;       // m

const holds = (page, side) => ask(page, `session.holding.get('${side}')?.held.name ?? null`);
/** The others in headsets, as a page sees them: head and hands, m. */
const people = (page) => ask(page, `[...session.seenPeople()].map(({member, head, left, right}) => (
  {id: String(member.id), head: head?.position, left: left?.pose.position, right: right?.pose.position}))`);
const id = (page) => ask(page, 'String(session.self)');
/** rad, about z. */
const heading = (page) => ask(page, `(() => { const [x, y, z, w] = headset.seen.head.orientation;
  return Math.atan2(-2 * (x * z + w * y), -2 * (y * z - w * x)); })()`);
/** rad, of a body about z. */
const bodyYaw = (page, name) => ask(page, `(() => { const [x, y, z, w] = session.world.find('${name}').body.orientation;
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)); })()`);
/** Brings the user to a place beside a point, looking at it. */
async function stand(page, [x, y]) {
  await page.evaluate(`(() => { const {headset} = window.tandemRoom;
    headset.stand.jump([${x}, ${y}], headset.seen.head.position); })()`);
  await seen(page);
}
/**
 * A hand takes hold of a body, at a place from the body's middle (m, world). A page that slept for a second has let go
 * of all (docs/room.md): it is tried again, as people do.
 */
async function grab(page, side, from, name, button = 'squeeze') {
  const tried = [];
  for (let i = 0; i < TRIES; ++i) {
    await put(page, side, (await pose(page, name)).map((x, k) => x + from[k]));
    await press(page, side, button, 1);
    const held = await until(() => holds(page, side), `a hand on ${name}`, 3).catch(() => null);
    if (held) return assert.equal(held, name);
    tried.push(await page.evaluate(`(() => { const {session, headset} = window.tandemRoom;
      return {hand: headset.seen?.${side}, body: [...session.world.find('${name}').body.position], steps: session.steps,
              running: session.running, late: session.late, held: [...session.holding.keys()]}; })()`));
    await press(page, side, button, 0);
  }
  throw new Error(`${side} does not hold ${name}: ${JSON.stringify(tried)}`);
}

describe('a room in headsets', {timeout: 240000}, () => {
  let server;
  let browser;
  let a;
  let b;
  let desktop;
  before(async () => {
    server = await startServer(['--room', 'piano']);
    browser = await startBrowser();
    a = await openHeadset(browser, server.link);
    b = await openHeadset(browser, server.link);
    desktop = await openPage(browser, server.link, {viewport: {width: 320, height: 240}});
    for (const page of [a, b, desktop]) await until(async () => await others(page) === 2, 'two others');
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  test('the button is there where a headset is, and nowhere else', async () => {
    assert.equal(await ask(desktop, 'document.getElementById("headset").hidden'), true);
    await a.waitForSelector('#headset:not([hidden])', {state: 'attached'});
  });

  test('heads and hands are seen by everybody where they are, at the room\'s own scale', async () => {
    await Promise.all([enter(a), enter(b)]);
    // The floor of both frames is the same, and y of the headset is z of the room.
    for (const page of [a, b]) assert.ok(Math.abs((await headOf(page))[2] - EYES) < 1e-6);
    await move(a, 'left', [0.1, 0.2, -0.3]);
    for (const [who, by] of [[a, b], [b, a], [a, desktop], [b, desktop]]) {
      const own = {head: await headOf(who), left: await handOf(who, 'left'), right: await handOf(who, 'right')};
      const name = await id(who);
      await until(async () => {
        const one = (await people(by)).find((person) => person.id === name);
        return one && ['head', 'left', 'right'].every((part) => one[part] && distance(one[part], own[part]) < SEEN);
      }, 'where they are', 10);
    }
    assert.equal((await people(a)).length, 1);
    assert.equal((await people(desktop)).length, 2);
  });

  test('a squeeze grabs what is in reach and nothing else; a hand lifts it and lets go', async () => {
    const [x, y, z] = await pose(a, CRATE);
    await stand(a, [x, y - 0.6]);
    await put(a, 'right', [x, y, z + 0.6]);
    await press(a, 'right', 'squeeze', 1);
    assert.equal(await holds(a, 'right'), null);
    await press(a, 'right', 'squeeze', 0);
    await grab(a, 'right', TOP, CRATE);
    // Pictures lie between the last two steps: looked at in the page, within the half second that it moves.
    const between = a.evaluate((name) => new Promise((resolve) => {
      const {world} = window.tandemRoom.session;
      const {body} = world.find(name);
      const timer = setInterval(() => {
        const heights = [0, 0.5, 1].map((part) => world.between(part)[13 * body.row + 2]);
        if (heights[2] - heights[0] < 1e-3) return;
        clearInterval(timer);
        resolve([...heights, body.position[2]]);
      }, 2);
    }), CRATE);
    await move(a, 'right', [0, 0, LIFT]);
    const [first, middle, last, now] = await between;
    assert.equal(last, now);
    assert.ok(Math.abs(middle - (first + last) / 2) < 1e-12);
    await until(async () => Math.abs((await pose(a, CRATE))[2] - z - LIFT) < HELD, 'the lift');
    await until(async () => Math.abs((await pose(desktop, CRATE))[2] - z - LIFT) < HELD, 'the desktop to see it');
    await move(a, 'right', [0, 0, 0.02 - LIFT]);
    await press(a, 'right', 'squeeze', 0);
    assert.equal(await holds(a, 'right'), null);
    await until(async () => (await pose(desktop, CRATE))[2] < z + MOVED, 'it to lie down');
  });

  test('two hands turn a body, each with half of its load', async () => {
    const [x, y] = await pose(a, CRATE);
    const yaw = await bodyYaw(a, CRATE);
    await stand(a, [x, y - 0.6]);
    await grab(a, 'left', [-0.15, 0, 0], CRATE);
    await grab(a, 'right', [0.15, 0, 0], CRATE, 'trigger');
    await Promise.all(['left', 'right'].map((side) => move(a, side, [0, 0, 0.3])));
    // On a circle, in small ways.
    const parts = 6;
    const at = (i) => [0.15 * Math.cos(TURN * i / parts), 0.15 * Math.sin(TURN * i / parts)];
    for (let i = 0; i < parts; ++i) {
      const way = [at(i + 1)[0] - at(i)[0], at(i + 1)[1] - at(i)[1], 0];
      await Promise.all([move(a, 'right', way, 0.1), move(a, 'left', way.map((k) => -k), 0.1)]);
    }
    // The hands themselves keep their direction, as far as three springs of each can: it turns a little less.
    await until(async () => (await bodyYaw(a, CRATE)) - yaw > TURN / 2, 'the turn');
    await until(async () => Math.abs((await bodyYaw(desktop, CRATE)) - await bodyYaw(a, CRATE)) < 0.05, 'the desktop');
    await Promise.all(['left', 'right'].map((side) => move(a, side, [0, 0, -0.28])));
    await press(a, 'left', 'squeeze', 0);
    assert.equal(await holds(a, 'right'), CRATE);
    await press(a, 'right', 'trigger', 0);
    assert.equal(await holds(a, 'right'), null);
  });

  test('a pinch of a hand without controller holds, too', async () => {
    await b.evaluate('void (device.primaryInputMode = "hand")');
    await until(() => handOf(b, 'left'), 'a hand');
    const [x, y, z] = await pose(b, 'stool');
    await stand(b, [x + 0.6, y]);
    await grab(b, 'left', [0, 0, 0.2], 'stool', 'pinch');
    await move(b, 'left', [0, 0, LIFT]);
    await until(async () => Math.abs((await pose(desktop, 'stool'))[2] - z - LIFT) < 2 * HELD, 'the lift');
    await move(b, 'left', [0, 0, -LIFT]);
    await press(b, 'left', 'pinch', 0);
    assert.equal(await holds(b, 'left'), null);
    await b.evaluate('void (device.primaryInputMode = "controller")');
    await until(() => handOf(b, 'left'), 'a controller');
  });

  test('what is unclear lets go: a controller that is lost, a session that is not in front or ends', async () => {
    const ways = {
      'a lost controller': ['device.controllers.right.connected = false', 'device.controllers.right.connected = true'],
      blurred: ['device.updateVisibilityState("visible-blurred")', 'device.updateVisibilityState("visible")'],
      hidden: ['device.updateVisibilityState("hidden")', 'device.updateVisibilityState("visible")'],
      'a second of sleep': ['(() => { for (const end = performance.now() + 1500; performance.now() < end;); })()', '0'],
    };
    for (const [what, [begin, end]] of Object.entries(ways)) {
      await until(() => handOf(a, 'right'), 'a hand');
      const [x, y] = await pose(a, CRATE);
      await stand(a, [x, y - 0.6]);
      await grab(a, 'right', TOP, CRATE);
      await a.evaluate(`void (${begin})`);
      await until(async () => await holds(a, 'right') === null, what, 10);
      await a.evaluate(`void (${end})`);
      await until(() => handOf(a, 'right'), 'the hand again');
      assert.equal(await holds(a, 'right'), null, 'a button that was held all the time grabs nothing anew');
      await press(a, 'right', 'squeeze', 0);
    }
    await grab(a, 'right', TOP, CRATE);
    await a.evaluate(() => window.device.activeSession.end());
    await until(async () => await holds(a, 'right') === null, 'the end');
    const name = await id(a);
    await until(async () => !(await people(desktop)).some((person) => person.id === name), 'no head any more');
    await until(() => ask(a, 'drawing.drawn > 0 && !headset.active'), 'the page');
    await a.evaluate('void device.controllers.right.updateButtonValue("squeeze", 0)');
    await enter(a);
  });

  test('a thumbstick moves its user and not the room', async () => {
    const places = await poses(a);
    await stand(a, [0, 0]);
    const before = await headOf(a);
    await stick(a, 'right', 0, -1);
    const target = await until(() => ask(a, 'headset.target'), 'a target');
    assert.ok(distance(target, before.slice(0, 2)) > 0.5);
    await stick(a, 'right', 0, 0);
    const there = await headOf(a);
    assert.ok(distance(there, [...target, EYES]) < 1e-3, `${there} is not above ${target}`);
    const was = await heading(a);
    await stick(a, 'left', 1, 0);
    await seen(a);
    await stick(a, 'left', 0, 0);
    const turned = ((await heading(a)) - was) * 180 / Math.PI;
    assert.ok(Math.abs((turned + 360) % 360 - SNAP) < 0.1, `turned by ${turned} degrees to the right`);
    assert.ok(distance(there, await headOf(a)) < 1e-3, 'about the head');
    assert.ok(furthest(places, await poses(a)) < MOVED, 'the room stays');
  });

  test('two headsets carry the piano together, and the page without one sees it', async (t) => {
    const [x, y, z] = await pose(a, 'piano');
    await stand(a, [x + 1, y]);
    await stand(b, [x - 0.7, y + 0.9]);
    // Each at one end, with both hands.
    const ends = [[a, 0.55], [b, -0.55]];
    for (const [page, end] of ends) {
      await grab(page, 'left', [end, -0.15, 0], 'piano');
      await grab(page, 'right', [end, 0.15, 0], 'piano');
    }
    const together = (way, seconds) => Promise.all(ends.flatMap(([page]) =>
      ['left', 'right'].map((side) => move(page, side, way, seconds))));
    await together([0, 0, CARRIED], 1);
    await together([0, CARRIED, 0], 1);
    for (const [page] of ends) {
      for (const side of ['left', 'right']) assert.equal(await holds(page, side), 'piano');
    }
    for (const page of [a, b, desktop]) {
      const moved = await until(async () => {
        const now = await pose(page, 'piano');
        return now[2] - z > CARRIED - 0.05 && now[1] - y > CARRIED - 0.05 && now;
      }, 'the piano', 20);
      t.diagnostic(`carried ${(moved[2] - z).toFixed(3)} m up and ${(moved[1] - y).toFixed(3)} m along`);
    }
    await together([0, 0, -CARRIED], 1);
    for (const [page] of ends) for (const side of ['left', 'right']) await press(page, side, 'squeeze', 0);
    await atRest([a, b, desktop], null, 'the piano put down');
    const apart = furthest(await poses(a), await poses(desktop));
    t.diagnostic(`${(1000 * apart).toFixed(2)} mm apart at rest`);
  });

  test('lies about heads and hands are dropped and counted', async () => {
    const liar = await openPage(browser, server.link, {viewport: {width: 200, height: 150}});
    await until(async () => await others(liar) === 3, 'three others');
    const refused = await ask(desktop, 'session.presence.refused');
    const said = await liar.evaluate(() => {
      const {members} = window.tandemRoom.session;
      const mark = [1, 0, 0xc0, 0x7f];
      const floats = (...values) => [...new Uint8Array(new Float32Array(values).buffer)];
      const straight = [0, 0, 0, 1];
      const lies = [
        mark, [...mark, 255], [...mark, 1], [...mark, 8],
        [...mark, 1, ...floats(NaN, 0, 1, ...straight)], [...mark, 1, ...floats(1e30, 0, 1, ...straight)],
        [...mark, 1, ...floats(0, 0, 21, ...straight)], [...mark, 1, ...floats(0, 0, 1, 0, 0, 0, 0)],
        [...mark, 1, ...floats(0, 0, 1, 0, 0, 0, Infinity)], [...mark, 1, ...floats(0, 0, 1, ...straight), 7],
        [...mark, 10, ...floats(0, 0, 1, ...straight, 0, 0, 0), 200], [...mark, 10, ...floats(0, 0, 1, ...straight)],
        floats(0, 0, 0, 0, 0, 0), floats(NaN, 0, 0, 0, 0, 0), floats(99, 0, 0, 0, 0, 0), [1],
      ];
      for (const lie of lies) members.sendAll(4, new Uint8Array(lie));
      return lies.length;
    });
    await until(async () => await ask(desktop, 'session.presence.refused') >= refused + said, 'all to be counted', 10);
    const name = await id(liar);
    assert.ok(!(await people(desktop)).some((person) => person.id === name));
    // A true one is shown, too many are not heard.
    await pause(1500);
    const before = await ask(desktop, 'session.presence.refused');
    await liar.evaluate(() => {
      const {members} = window.tandemRoom.session;
      window.tandemRoom.session.track({head: {position: [0, 0, 1.7], orientation: [0, 0, 0, 1]}});
      const head = [1, 0, 0xc0, 0x7f, 1, ...new Uint8Array(new Float32Array([0, 0, 1.7, 0, 0, 0, 1]).buffer)];
      for (let i = 0; i < 200; ++i) members.sendAll(4, new Uint8Array(head));
    });
    await until(async () => (await people(desktop)).some((person) => person.id === name), 'a head');
    await until(async () => await ask(desktop, 'session.presence.refused') > before + 100, 'too many', 10);
    await liar.context().close();
    assert.deepEqual([...a.complaints, ...b.complaints, ...desktop.complaints], []);
  });
});
