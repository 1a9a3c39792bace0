// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What users do to a page with a mouse or a finger.

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/**
 * Holds a body with the mouse and pulls it.
 * @param {import('playwright-core').Page} page
 * @param {string} body
 * @param {number} pane
 * @param {number[]} by  CSS pixels to the right, down
 */
export async function dragMouse(page, body, pane, by) {
  const [x, y] = await page.evaluate(([b, p]) => window.tandemView.project(b, p), [body, pane]);
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= 6; ++i) {
    await page.mouse.move(x + by[0] * i / 6, y + by[1] * i / 6);
    await pause(16);
  }
}

/** Puts fingers down, moves or lifts them. @param {[number, number][]} points  CSS pixels */
async function touch(session, type, points) {
  await session.send('Input.dispatchTouchEvent', {
    type, touchPoints: points.map(([x, y], id) => ({x, y, id}))});
}

/** The same with a finger, which is lifted at the end. */
export async function dragFinger(page, body, pane, by) {
  const session = await page.context().newCDPSession(page);
  const [x, y] = await page.evaluate(([b, p]) => window.tandemView.project(b, p), [body, pane]);
  await touch(session, 'touchStart', [[x, y]]);
  for (let i = 1; i <= 6; ++i) {
    await touch(session, 'touchMove', [[x + by[0] * i / 6, y + by[1] * i / 6]]);
    await pause(16);
  }
  await pause(300);
  await touch(session, 'touchEnd', []);
}

/** Two fingers come apart about a point. @param {number} factor  how far */
export async function pinch(page, at, factor) {
  const session = await page.context().newCDPSession(page);
  const pair = (reach) => [[at[0] - reach, at[1]], [at[0] + reach, at[1]]];
  await touch(session, 'touchStart', pair(40));
  for (let i = 1; i <= 4; ++i) {
    await touch(session, 'touchMove', pair(40 * (1 + (factor - 1) * i / 4)));
  }
  await touch(session, 'touchEnd', []);
}
