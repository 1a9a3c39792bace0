// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The pictures of docs/robots.md, as JPEG, through the live view of scene_view. FOLDER has clones of the repositories,
// each by its own name:
//   TANDEM_BIN=build/release/bin node tests/view/robots.mjs FOLDER docs/img/robots [NAME..]
import {mkdirSync, statSync} from 'node:fs';
import {join} from 'node:path';
import {openPage, startBrowser} from './browser.mjs';
import {startDemo} from './demo.mjs';

const SIZE = {width: 480, height: 480};  // CSS pixels

/** File and options of scene_view by the picture's name; paths are below FOLDER. */
const ROBOTS = {
  panda: ['example-robot-data/robots/panda_description/urdf/panda.urdf', '--package-root', '.'],
  go2: ['example-robot-data/robots/go2_description/urdf/go2.urdf', '--package-root', '.'],
  talos: ['example-robot-data/robots/talos_data/robots/talos_reduced.urdf', '--package-root', '.'],
  g1: ['unitree_ros/robots/g1_description/g1_29dof.urdf'],
  h1: ['unitree_ros/robots/h1_description/mjcf/h1.xml'],
  humanoid_cmu: ['dm_control/dm_control/suite/humanoid_CMU.xml'],
  cheetah: ['dm_control/dm_control/suite/cheetah.xml'],
  humanoid: ['mujoco/model/humanoid/humanoid.xml'],
  car: ['mujoco/model/car/car.xml'],
  r2d2: ['bullet3/data/r2d2.urdf'],
};

/** As it stands in the file: no time has passed. */
async function take(browser, name, root, folder) {
  const [file, ...rest] = ROBOTS[name];
  const options = rest.map((word) => (word === '.' ? root : word));
  const shown = await startDemo('scene_view', ['--paused', '--ground', '--scene', join(root, file), ...options]);
  try {
    const page = await openPage(browser, `${shown.page}?still=1&theme=light`, {viewport: SIZE});
    await page.waitForFunction(() => window.tandemView.settled, null, {timeout: 120000});
    const path = join(folder, `${name}.jpg`);
    await page.screenshot({path, type: 'jpeg', quality: 86, timeout: 180000});
    if (page.complaints.length) throw new Error(`${name}: ${page.complaints}`);
    console.error(`${path}: ${(statSync(path).size / 1000).toFixed(0)} kB`);
    await page.context().close();
  } finally {
    await shown.stop();
  }
}

const [root, folder, ...names] = process.argv.slice(2);
if (!folder) throw new Error('usage: robots.mjs FOLDER_OF_REPOSITORIES FOLDER [NAME..]');
const unknown = names.filter((name) => !ROBOTS[name]);
if (unknown.length) throw new Error(`robots.mjs: name must be one of ${Object.keys(ROBOTS)}, is ${unknown}`);
mkdirSync(folder, {recursive: true});
const browser = await startBrowser();
try {
  for (const name of names.length ? names : Object.keys(ROBOTS)) await take(browser, name, root, folder);
} finally {
  await browser.close();
}
