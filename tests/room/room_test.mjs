// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Two pages in contexts of their own and a native peer in one room: what docs/room.md promises.
import assert from 'node:assert/strict';
import {after, before, describe, test} from 'node:test';
import {ask, atRest, direct, furthest, openPage, others, pause, pose, poses, startBrowser, startPeer, startServer,
        until} from './support.mjs';

const CUBE = 'cube/9';   // the uppermost one
const PLANK = 'plank/0'; // lies by itself, and lies down again
const LIFT = 0.08;       // m
const MARGIN = 0.1;      // s, that a pull may take beyond the way
const DRAGGED = 0.01;    // m: less may be a ball that rolls to its end
const BEGUN = 0.002;    // m
const SLACK = 0.03;      // s, of two clocks and steps
const PULLS = 3;         // of which the middle one counts: the machine may do something else meanwhile
const refusal = /WebSocket connection to .* failed/;  // what Chromium says of a server that is gone

/** Position of a body on the page, in pixels, once its present state is drawn. */
async function place(page, name) {
  const drawn = await ask(page, 'drawing.drawn');
  await until(() => ask(page, `drawing.drawn > ${drawn} + 1`), 'a picture');
  return ask(page, `drawing.project([...session.world.find('${name}').body.position])`);
}

/** Lifts a body of the page with its mouse. @returns {Promise<function()>}  what puts it back */
async function lift(page, name) {
  let x, y;
  // A page that stalls just then is out of step, and takes nothing up: as its user would, once more.
  for (let left = 3; ; --left) {
    [x, y] = await place(page, name);
    await page.mouse.move(x, y);
    await page.mouse.down();
    const held = await until(() => ask(page, 'session.hand?.held.name'), 'a hand', 5).catch((problem) => {
      if (left === 0) throw problem;
    });
    if (held) break;
    await page.mouse.up();
  }
  assert.equal(await ask(page, 'session.hand.held.name'), name);
  for (let i = 1; i <= 8; ++i) await page.mouse.move(x, y - 12 * i);
  return async () => {
    for (let i = 7; i >= 0; --i) {
      await page.mouse.move(x, y - 12 * i);
      await pause(60);
    }
    await pause(300);
    await page.mouse.up();
  };
}

/** Notes at each step what time it is and how high the body is, in window.track. */
const track = (page, name) => page.evaluate((body) => {
  const {session} = window.tandemRoom;
  const held = session.world.find(body).body;
  window.track = [];
  window.remember ??= session.world.remember.bind(session.world);
  session.world.remember = (time) => {
    window.remember(time);
    window.track.push([session.clock.now() / 1000, held.position[2]]);
  };
}, name);

/** When it was so high, s; undefined: never. */
const when = (points, height) => points.find(([, z]) => z > height)?.[0];

/** Hides the page or shows it again; headless pages are always shown. */
const hide = (page, hidden) => page.evaluate((is) => {
  Object.defineProperty(document, 'hidden', {configurable: true, get: () => is});
  document.dispatchEvent(new Event('visibilitychange'));
}, hidden);

describe('a room by a link', {timeout: 600000}, () => {
  let server;
  let browser;
  let native;
  let a;
  let b;
  before(async () => {
    server = await startServer();
    browser = await startBrowser();
    [a, b] = [await openPage(browser, server.link), await openPage(browser, server.link)];
    native = await startPeer(server.link);
    // From above, so that nothing hides what is to be pulled.
    for (const page of [a, b]) await ask(page, '(drawing.look.elevation = 55)');
  });
  after(async () => {
    await browser?.close();
    native?.say('quit');
    await native?.over;
    await server?.stop();
  });

  test('three meet, the pages directly', async () => {
    await until(async () => await others(a) === 2 && await others(b) === 2 && native.others === 2, 'three');
    await until(async () => await direct(a) === 1 && await direct(b) === 1, 'a direct way');
    await until(() => ask(a, 'session.running'), 'steps');
    await atRest([a, b], native, 'to begin with');
  });

  test('who comes with another key is told so, and the others do not notice', async () => {
    const lost = await openPage(browser, `${server.url}?room=sandbox`);
    await until(() => lost.locator('#state').textContent().then((text) => text.includes('Ask for the whole link')),
                'words');
    assert.equal(await others(lost), 0);
    assert.deepEqual(lost.complaints, []);
    assert.equal(await a.locator('#state').textContent(), '');
    await lost.context().close();
  });

  test('the key never leaves the page', async () => {
    const key = server.link.split('#')[1];
    const seen = [];
    const watch = (request) => seen.push(request.url());
    a.on('request', watch);
    await a.evaluate(() => fetch(location.href).then((answer) => answer.text()));
    a.off('request', watch);
    assert.ok(seen.length > 0);
    const sent = (text) => text.split('#')[0];
    assert.deepEqual(seen.filter((url) => sent(url).includes(key)), []);
  });

  test('what one page pulls is seen by the others within the latency and 100 ms', async (t) => {
    for (const delay of [0, 100]) {
      await ask(a, `(session.members.delay = ${delay})`);
      const late = {b: [], native: [], begun: []};
      for (let k = 0; k < PULLS; ++k) {
        await Promise.all([track(a, PLANK), track(b, PLANK)]);
        native.track.length = 0;
        native.say(`watch ${PLANK}`);
        await until(() => native.track.length > 0, 'the native peer to watch');
        const low = (await pose(a, PLANK))[2];
        const putBack = await lift(a, PLANK);
        const seen = async (height) => {
          const points = await Promise.all([a, b].map((page) => page.evaluate(() => window.track)));
          const places = native.track.map(({time, at}) => [time, at[2]]);
          const times = [...points, places].map((list) => when(list, low + height));
          return times.every((time) => time !== undefined) && times;
        };
        const [first, second, third] = await until(() => seen(LIFT / 2), 'the lift');
        late.b.push(second - first);
        late.native.push(third - first);
        const begun = await seen(BEGUN);
        late.begun.push(Math.min(begun[1], begun[2]) - begun[0]);
        await putBack();
        native.say('watch');
        await atRest([a, b], native, 'after a pull');
      }
      const middle = (times) => times.sort((x, y) => x - y)[PULLS >> 1];
      for (const who of ['b', 'native']) {
        t.diagnostic(`${delay} ms away, ${who} sees it ${(1000 * middle(late[who])).toFixed(0)} ms later`);
        assert.ok(middle(late[who]) <= delay / 1000 + MARGIN, `${who}: ${late[who]}`);
      }
      // Others carry the hand on, and may have caught up half way; but they know of it no sooner.
      assert.ok(middle(late.begun) >= delay / 1000 - SLACK, `sooner than it can be: ${late.begun}`);
    }
    await ask(a, '(session.members.delay = 0)');
  });

  test('what the native peer pulls, the pages see, and the panel says how far all are apart', async () => {
    const [x, y, z] = await pose(a, 'domino/0');
    native.say(`pull domino/0 ${x} ${y - 0.3} ${z + 0.4}`);
    await until(async () => (await pose(a, 'domino/0'))[2] > z + 0.3 && (await pose(b, 'domino/0'))[2] > z + 0.3,
                'the lift');
    assert.deepEqual(await ask(a, '[...session.seenHands()].map(({member, held}) => [member.name, held.name])'),
                     [['native', 'domino/0']]);
    native.say('release');
    await until(() => ask(a, '[...session.seenHands()].length === 0'), 'the hand to let go');
    await atRest([a, b], native, 'afterwards');
    assert.match(await a.textContent('#apart'), /Furthest apart: (< )?[\d.]+ mm/);
    assert.equal(await a.locator('#people li').count(), 3);
  });

  test('what one makes is there for all', async () => {
    for (const what of ['box', 'ball', 'plank']) await a.click(`[data-make=${what}]`);
    const made = (all) => Object.keys(all).filter((name) => name.startsWith('made/')).length;
    await until(async () => made(await poses(b)) === 3 && made(await native.poses()) === 3, 'three more');
    await atRest([a, b], native, 'with them');
  });

  test('a late joiner takes over what the others know, and drags nobody', async (t) => {
    const places = await poses(a);
    const late = await openPage(browser, server.link);
    t.after(() => late.context().close());
    await until(async () => await others(late) === 3, 'three others');
    await until(async () => Object.keys(await poses(late)).length === Object.keys(places).length, 'all bodies');
    await atRest([a, b, late], native, 'with a late joiner');
    assert.ok(furthest(places, await poses(a)) <= DRAGGED, 'nothing was dragged');
    assert.deepEqual(late.complaints, []);
    await late.context().close();
    await until(async () => await others(a) === 2, 'the late joiner to go');
  });

  test('a reload comes back to the same room', async () => {
    const places = await poses(a);
    await b.reload();
    await b.waitForFunction(() => window.tandemRoom?.drawing?.drawn > 0);
    await ask(b, '(drawing.look.elevation = 55)');
    await until(async () => await others(b) === 2 && await others(a) === 2, 'two others');
    await atRest([a, b], native, 'after the reload');
    assert.ok(furthest(places, await poses(b)) <= DRAGGED, 'it is where it was left');
  });

  test('a page in the background takes no part, catches up, and drags nobody', async (t) => {
    await lift(b, PLANK);
    await hide(b, true);
    t.after(() => hide(b, false));
    assert.equal(await ask(b, 'session.hand'), null);
    await b.mouse.up();
    await until(() => ask(a, 'session.members.here.some((m) => m.away)'), 'the others to know');
    const steps = await ask(b, 'session.steps');
    const [x, y, z] = await pose(a, 'ball/0');
    native.say(`pull ball/0 ${x - 0.5} ${y} ${z + 0.3}`);
    await until(async () => (await pose(a, 'ball/0'))[0] < x - 0.3, 'the ball');
    native.say('release');
    await atRest([a], native, 'without the page');
    assert.equal(await ask(b, 'session.steps'), steps);
    const places = await poses(a);
    await hide(b, false);
    await until(async () => (await ask(b, 'session.steps')) > steps + 30, 'steps');
    await atRest([a, b], native, 'back again');
    assert.ok(furthest(places, await poses(a)) <= DRAGGED, 'nobody was dragged');
  });

  test('a page that slept for two seconds drags nobody', async () => {
    const [x, y, z] = await pose(a, 'ball/1');
    const steps = await ask(b, 'session.steps');
    native.say(`pull ball/1 ${x - 0.5} ${y} ${z + 0.3}`);
    await b.evaluate(() => { for (const end = performance.now() + 2000; performance.now() < end;); });
    await until(async () => (await pose(a, 'ball/1'))[0] < x - 0.4, 'the ball');
    // While the other wakes up it stays where it is held.
    await until(async () => {
      assert.ok((await pose(a, 'ball/1'))[0] < x - 0.35, 'it was dragged back');
      return (await ask(b, 'session.steps')) > steps + 60;
    }, 'the page to go on');
    await until(async () => (await pose(b, 'ball/1'))[0] < x - 0.4, 'the page to see it');
    native.say('release');
    await atRest([a, b], native, 'after it slept');
  });

  test('a member that says anything at all is cut off, and the others go on', async (t) => {
    const places = await poses(a);
    const hostile = await openPage(browser, server.link, {viewport: {width: 300, height: 300}});
    t.after(() => hostile.context().close());
    await until(async () => await others(hostile) === 3, 'three others');
    await hostile.evaluate(() => {
      const {session} = window.tandemRoom;
      const {members} = session;
      const text = (value) => new TextEncoder().encode(typeof value === 'string' ? value : JSON.stringify(value));
      const sphere = {type: 'sphere', radius: 0.1};
      const words = ['', '{', 'null', '[]', {made: 7}, {made: [null, 1, {name: 'made/x'}]}, {rtc: {offer: 'x'}},
                     {rtc: {answer: {}}}, {rtc: {candidate: {candidate: 'x'}}}, {away: 'x'}, {bye: 1},
                     {made: [{name: 'made/nan', shape: sphere, position: [null, 0, 1]},
                             {name: 'made/far', shape: sphere, position: [1e9, 0, 1]},
                             {name: 'ground', shape: sphere, position: [0, 0, 1]}]}];
      for (const {id} of members.here) {
        for (const one of words) members.send(id, 2, text(one));
        for (const size of [0, 1, 7, 8, 9, 24, 28, 300]) {
          const junk = crypto.getRandomValues(new Uint8Array(size));
          for (const channel of [3, 4, 5, 255]) members.send(id, channel, junk);
          members.send(id, 4, new Uint8Array([...new Uint8Array(new Float32Array(6).fill(NaN).buffer), ...junk]));
        }
      }
    });
    // The sharing itself: a member that sends undecodable packets there is dropped. A packet beyond
    // a member's budget is not read.
    const dropped = async (page) => {
      await hostile.evaluate(() => {
        const {members} = window.tandemRoom.session;
        for (const channel of [0, 1]) members.sendAll(channel, crypto.getRandomValues(new Uint8Array(300)));
      });
      return ask(page, 'session.members.here.length === 2');
    };
    await until(() => dropped(a), 'the page to drop it');
    await until(() => dropped(b), 'the other page to drop it');
    await atRest([a, b], native, 'in spite of it');
    assert.ok(furthest(places, await poses(a)) <= DRAGGED, 'nothing has moved');
    assert.equal(Object.keys(await poses(a)).length, Object.keys(places).length);
    assert.deepEqual([...a.complaints, ...b.complaints], []);
  });

  test('where the server is gone the pages go on, and it comes back', async () => {
    assert.deepEqual([...a.complaints, ...b.complaints], []);
    const port = new URL(server.url).port;
    const token = new URL(server.url).pathname.slice(1, -1);
    await server.stop('SIGKILL');
    await until(async () => await others(a) === 1 && await others(b) === 1, 'each other alone');
    const low = (await pose(b, PLANK))[2];
    const putBack = await lift(a, PLANK);
    await until(async () => (await pose(b, PLANK))[2] > low + LIFT / 2, 'the lift');
    await putBack();
    await atRest([a, b], null, 'without a server');
    assert.match(await a.textContent('#state'), /server is gone/);
    const {link} = server;
    server = await startServer(['--port', port, '--token', token]);
    server.link = link;
    await until(async () => await others(a) === 2 && await others(b) === 2 && native.others === 2, 'all three');
    await atRest([a, b], native, 'with the server');
    assert.deepEqual([...a.complaints, ...b.complaints].filter((text) => !refusal.test(text)), []);
  });
});

describe('pages that cannot meet', {timeout: 300000}, () => {
  test('go through the server, on a phone as well', async () => {
    const server = await startServer(['--no-key']);
    const browser = await startBrowser();
    try {
      const a = await openPage(browser, server.link);
      const link = await a.evaluate(() => location.href);
      assert.match(link, /#[\w-]{43}$/, 'the first page has drawn a key');
      const context = {viewport: {width: 390, height: 760}, hasTouch: true, isMobile: true};
      const blocked = await browser.newContext(context);
      await blocked.addInitScript(() => { delete window.RTCPeerConnection; });
      const b = await openPage({newContext: async () => blocked}, link);
      await until(async () => await others(a) === 1 && await others(b) === 1, 'two');
      assert.equal(await direct(a), 0);
      await until(() => ask(b, 'session.running'), 'steps');
      // A finger.
      const session = await b.context().newCDPSession(b);
      const low = (await pose(a, CUBE))[2];
      const [x, y] = await place(b, CUBE);
      const touch = (type, points) => session.send('Input.dispatchTouchEvent', {type, touchPoints: points});
      await touch('touchStart', [{x, y}]);
      await until(() => ask(b, 'session.hand?.held.name'), 'a hand');
      assert.equal(await ask(b, 'session.hand.held.name'), CUBE);
      for (let i = 1; i <= 8; ++i) await touch('touchMove', [{x, y: y - 8 * i}]);
      await until(async () => (await pose(a, CUBE))[2] > low + LIFT / 2, 'the lift');
      await touch('touchEnd', []);
      await atRest([a, b], null, 'relayed');
      const small = await b.evaluate(() => [...document.querySelectorAll('button')].filter((one) => one.offsetParent)
        .map((one) => Math.min(one.offsetWidth, one.offsetHeight)));
      assert.ok(Math.min(...small) >= 44, 'what one touches is 44 pixels large');
      assert.deepEqual([...a.complaints, ...b.complaints], []);
    } finally {
      await browser.close();
      await server.stop();
    }
  });
});

describe('the other rooms', {timeout: 300000}, () => {
  for (const [room, body] of [['piano', 'piano'], ['tennis', 'racket/0']]) {
    test(`${room}: a page and a native peer move one thing`, async () => {
      const server = await startServer(['--room', room]);
      const browser = await startBrowser();
      let native = null;
      try {
        const page = await openPage(browser, server.link);
        native = await startPeer(server.link, room);
        await until(async () => await others(page) === 1 && native.others === 1, 'two');
        await until(() => ask(page, 'session.running'), 'steps');
        await atRest([page], native, 'to begin with');
        const [x, y, z] = await pose(page, body);
        native.say(`pull ${body} ${x + 0.4} ${y} ${z + 0.2}`);
        await until(async () => (await pose(page, body))[0] > x + 0.2, 'the pull');
        native.say('release');
        await atRest([page], native, 'afterwards');
        assert.deepEqual(page.complaints, []);
      } finally {
        native?.say('quit');
        await browser.close();
        await server.stop();
      }
    });
  }
});
