// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// README's moving picture: one demo twice, with agreement and with a single owner, through the page of
// its live view, as animated WebP (needs img2webp, Debian: webp):
//   TANDEM_BIN=build/release/bin node tests/view/moving_picture.mjs FILE.webp [SECONDS]
import {spawnSync} from 'node:child_process';
import {mkdtempSync, rmSync, statSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {openPage, startBrowser} from './browser.mjs';
import {startDemo} from './demo.mjs';
import {Observer, until} from './observer.mjs';

const PANES = {width: 820, height: 264};  // CSS pixels, of the panes of one run
const RATE = 10;                          // pictures each second
const SPEED = 2;                          // times as fast as it happens
const FIRST = 1.4;                        // s, of the session: hands have just taken hold
const HOLD = 2;                           // s, the last picture stays
const STEP = 1 / 60;                      // s, that the view does by hand
const TITLE = 'Two people, 63.5 ms apart, carry one piano through a maze';
const RUNS = [
  {coupling: 'one-pass', colour: '#16833f', text: 'Tandem: nobody owns it, both pull'},
  {coupling: 'single-owner', colour: '#b3261e', text: 'A single owner: only the owner’s hand counts'},
];

const TITLE_HEIGHT = 34;    // CSS pixels
const CAPTION_HEIGHT = 28;  // likewise, of each run

/** In the page: one picture of all runs, below each other. @returns {Promise<string>}  PNG */
async function compose({title, width, titleHeight, captionHeight, runs}) {
  const images = await Promise.all(runs.map(async ({picture}) => {
    const image = new Image();
    image.src = picture;
    await image.decode();
    return image;
  }));
  const canvas = document.createElement('canvas');
  canvas.width = width;
  canvas.height = titleHeight + images.reduce((sum, {height}) => sum + captionHeight + height, 0);
  const pen = canvas.getContext('2d');
  const write = (text, x, y, font, colour, align = 'start') => {
    Object.assign(pen, {font: `${font} "DejaVu Sans", sans-serif`, fillStyle: colour, textAlign: align,
                        textBaseline: 'middle'});
    pen.fillText(text, x, y);
  };
  pen.fillStyle = '#fff';
  pen.fillRect(0, 0, canvas.width, canvas.height);
  write(title, width / 2, titleHeight / 2, 'bold 18px', '#1c2733', 'center');
  let y = titleHeight;
  runs.forEach(({text, colour}, i) => {
    pen.fillStyle = colour;
    pen.fillRect(0, y, width, captionHeight);
    write(text, 12, y + captionHeight / 2, 'bold 15px', '#fff');
    y += captionHeight;
    pen.drawImage(images[i], 0, y);
    ['what A sees', 'what B sees'].forEach((label, pane) => {
      write(label, 10 + pane * width / 2, y + 18, 'bold 13px', '#1c2733');
    });
    y += images[i].height;
  });
  return canvas.toDataURL();
}

/** A run that stands still at each time. What has been drawn is taken, not a screenshot: that waits for
 *  a window which nobody sees. @returns {Promise<string[]>}  PNG as data URLs */
async function film(browser, {coupling}, times) {
  const demo = await startDemo('piano', ['--profile', '4', '--coupling', coupling, '--seconds', '3600']);
  try {
    const observer = await new Observer(demo.url).ready();
    observer.set('paused', true);
    await until(() => observer.settings.paused, 'a pause');
    const page = await openPage(browser, `${demo.page}?still=1&marks=1`, {viewport: PANES});
    const pictures = [];
    for (const time of times) {
      const steps = Math.round((time - observer.last.time) / STEP);
      for (let i = 0; i < steps; ++i) observer.send({type: 'step'});
      await until(() => observer.last.time > time - 0.5 * STEP, `${time} s`);
      await page.waitForFunction(
        (at) => window.tandemView.settled && window.tandemView.time >= at - 1e-6,
        observer.last.time, {timeout: 120000, polling: 50});
      process.stderr.write(`\r${coupling}: ${pictures.length + 1} of ${times.length} pictures `);
      pictures.push(await page.evaluate(() => document.getElementById('view').toDataURL()));
    }
    if (page.complaints.length) throw new Error(page.complaints.join('\n'));
    await page.context().close();
    observer.close();
    return pictures;
  } finally {
    await demo.stop();
  }
}

const [file, seconds = '17.6'] = process.argv.slice(2);
if (!file) throw new Error('usage: moving_picture.mjs FILE.webp [SECONDS]');
const folder = mkdtempSync(join(tmpdir(), 'tandem-picture-'));
const browser = await startBrowser();
try {
  const count = Math.floor((Number(seconds) - FIRST) * RATE / SPEED) + 1;
  const times = Array.from({length: count}, (_, i) => FIRST + i * SPEED / RATE);
  const films = [];
  // One after the other: each page draws all the time.
  for (const run of RUNS) films.push(await film(browser, run, times));
  const sheet = await (await browser.newContext()).newPage();
  const frames = [];
  for (let i = 0; i < count; ++i) {
    const url = await sheet.evaluate(compose, {
      title: TITLE, width: PANES.width, titleHeight: TITLE_HEIGHT, captionHeight: CAPTION_HEIGHT,
      runs: RUNS.map((run, r) => ({...run, picture: films[r][i]})),
    });
    frames.push(join(folder, `${String(i).padStart(4, '0')}.png`));
    writeFileSync(frames.at(-1), Buffer.from(url.split(',')[1], 'base64'));
  }
  const each = String(Math.round(1000 / RATE));
  const words = ['-loop', '0', '-lossy', '-q', '60', '-m', '6', '-d', each, ...frames,
                 '-d', String(1000 * HOLD), frames.at(-1), '-o', file];
  const list = join(folder, 'words');  // too long for a command line
  writeFileSync(list, words.join('\n'));
  const made = spawnSync('img2webp', [list], {stdio: 'inherit'});
  if (made.error || made.status !== 0) throw new Error('img2webp failed (Debian: webp)');
  console.error(`${file}: ${count} pictures, ${(statSync(file).size / 1000).toFixed(0)} kB`);
} finally {
  await browser.close();
  rmSync(folder, {recursive: true});
}
