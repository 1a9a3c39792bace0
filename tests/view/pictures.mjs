// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Key frames of the demos as PNG, through the page of their live view:
//   TANDEM_BIN=build/release/bin node tests/view/pictures.mjs FOLDER [NAME[@SECONDS]..]
import {spawnSync} from 'node:child_process';
import {mkdirSync, statSync} from 'node:fs';
import {join} from 'node:path';
import {openPage, startBrowser} from './browser.mjs';
import {startDemo} from './demo.mjs';
import {Observer, until} from './observer.mjs';

const WIDE = {width: 1120, height: 420};

/**
 * @typedef {object} Picture
 * @property {string} name     of the file
 * @property {string} demo
 * @property {string[]} options  of the demo
 * @property {number} at       s, session time
 * @property {string} query    of the page
 * @property {{width: number, height: number}} size  CSS pixels
 */

/** @type {Picture[]} */
const PICTURES = [
  {name: 'cubes', demo: 'cubes', at: 12, query: '', size: WIDE},
  {name: 'cliff', demo: 'cliff', at: 2.8, query: '', size: WIDE},
  {name: 'room', demo: 'room', at: 8, query: '', size: WIDE},
  {name: 'tennis', demo: 'tennis', at: 6.4, query: '', size: WIDE},
  {name: 'piano', demo: 'piano', at: 8, query: 'marks=1', size: WIDE},
  {name: 'pile', demo: 'pile', at: 5, query: '', size: WIDE},
];

/** A session stands still at a time, and the page shows just that. */
async function take(browser, picture, folder) {
  const options = ['--seconds', '3600', ...(picture.options ?? [])];
  const demo = await startDemo(picture.demo, options);
  try {
    const observer = await new Observer(demo.url).ready();
    await until(() => observer.last.time >= picture.at, `${picture.at} s`, 600);
    observer.set('paused', true);
    await until(() => observer.settings.paused, 'a pause');
    const page = await openPage(browser, `${demo.page}?still=1&${picture.query}`,
                                {viewport: picture.size});
    // Overlays come with the next frame.
    if (picture.query.includes('marks=1')) {
      observer.send({type: 'step'});
      await page.waitForFunction(() => window.tandemView.peers[0].contacts !== null);
    }
    await page.waitForFunction(() => window.tandemView.settled, null, {timeout: 120000});
    const path = join(folder, `${picture.name}.png`);
    await page.screenshot({path, timeout: 180000});
    if (page.complaints.length) throw new Error(`${picture.name}: ${page.complaints}`);
    // Fewer colours where pngquant is there.
    spawnSync('pngquant', ['--force', '--skip-if-larger', '--quality', '75-98', '--ext', '.png',
                           path]);
    const {time} = observer.last;
    console.error(`${path}: ${time.toFixed(2)} s, ${(statSync(path).size / 1000).toFixed(0)} kB`);
    await page.context().close();
    observer.close();
  } finally {
    await demo.stop();
  }
}

const [folder, ...names] = process.argv.slice(2);
if (!folder) throw new Error('usage: pictures.mjs FOLDER [NAME..]');
mkdirSync(folder, {recursive: true});
const browser = await startBrowser();
try {
  for (const picture of PICTURES) {
    if (!names.length || names.includes(picture.name)) await take(browser, picture, folder);
  }
  for (const [name, at] of names.map((text) => text.split('@'))) {
    const picture = PICTURES.find((one) => one.name === name);
    if (!at || !picture) continue;
    await take(browser, {...picture, name: `${name}@${at}`, at: Number(at)}, folder);
  }
} finally {
  await browser.close();
}
