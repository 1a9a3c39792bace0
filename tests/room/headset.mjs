// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A headset for a page, emulated by iwer: its user's head and hands are put where a test wants them in the room.
import {readFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {ask, distance, openPage, until} from './support.mjs';

const view = createRequire(join(dirname(fileURLToPath(import.meta.url)), '../view/package.json'));
const IWER = readFileSync(join(dirname(view.resolve('iwer/package.json')), 'build/iwer.min.js'), 'utf8');
export const EYES = 1.6;  // m above the floor

/** Runs in the page, before its scripts. */
const setUp = `${IWER};
window.device = new IWER.XRDevice(IWER.metaQuest3);
device.installRuntime({forceInstall: true});
device.position.set(0, ${EYES}, 0);
/** A hand's way in the world, m, from where it is, within some seconds; turned about the world's z by an angle. */
window.moveHand = (input, way, seconds) => new Promise((resolve) => {
  const {stand} = window.tandemRoom.headset;
  const c = Math.cos(-stand.yaw), s = Math.sin(-stand.yaw);
  const own = [c * way[0] - s * way[1], way[2], -(s * way[0] + c * way[1])];
  const from = [input.position.x, input.position.y, input.position.z];
  const begin = performance.now();
  const timer = setInterval(() => {
    const part = Math.min(1, (performance.now() - begin) / (1000 * seconds));
    input.position.set(...from.map((x, i) => x + part * own[i]));
    if (part < 1) return;
    clearInterval(timer);
    resolve();
  }, 5);
});`;

/** A page whose browser has a headset. */
export const openHeadset = (browser, link, viewport = {width: 240, height: 160}) =>
  openPage(browser, link, {before: {content: setUp}, viewport});

export async function enter(page) {
  await page.waitForSelector('#headset:not([hidden])', {state: 'attached'});
  await page.evaluate(() => document.getElementById('headset').click());
  await until(() => ask(page, 'headset.seen?.left && headset.seen.right && headset.seen.head'), 'head and hands');
}

const input = (side) => `device[device.primaryInputMode === 'hand' ? 'hands' : 'controllers'].${side}`;
/** m, world. */
export const handOf = (page, side) => ask(page, `headset.seen?.[${JSON.stringify(side)}]?.position`);
export const headOf = (page) => ask(page, 'headset.seen?.head?.position');
/** Pictures of the headset from now on until it has taken in what was done. */
export async function seen(page) {
  const drawn = await ask(page, 'drawing.drawn');
  await until(() => ask(page, `drawing.drawn > ${drawn} + 2`), 'pictures');
}
/** Moves a hand by so much, m. */
export async function move(page, side, way, seconds = 0.5) {
  await page.evaluate(`moveHand(${input(side)}, ${JSON.stringify(way)}, ${seconds})`);
  await seen(page);
}
/** Puts a hand to a point, m, world. */
export async function put(page, side, point) {
  const hand = await handOf(page, side);
  await move(page, side, point.map((x, i) => x - hand[i]), 0.05);
  const now = await handOf(page, side);
  if (distance(now, point) > 2e-3) throw new Error(`the hand is at ${now} and not at ${point}`);
}
/** How far a button is pressed: squeeze, trigger or, of a hand without controller, pinch. */
export async function press(page, side, button, value) {
  const call = button === 'pinch' ? 'updatePinchValue(' : `updateButtonValue('${button}', `;
  await page.evaluate(`${input(side)}.${call}${value})`);
  await seen(page);
}
export async function stick(page, side, x, y) {
  await page.evaluate(`${input(side)}.updateAxes('thumbstick', ${x}, ${y})`);
  await seen(page);
}
