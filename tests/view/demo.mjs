// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Starts one of the programs with a live view and learns where it is.
import {spawn} from 'node:child_process';
import {createServer} from 'node:net';
import {join} from 'node:path';
import {overlayFiles} from './mock/files.mjs';

/** @returns {Promise<number>}  a port that is free now */
export async function freePort() {
  const server = createServer();
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  const {port} = server.address();
  await new Promise((resolve) => server.close(resolve));
  return port;
}

/**
 * With TANDEM_VIEW_PAGE=source in the environment, the page is that of the source tree.
 * @param {string} name      of the program
 * @param {string[]} options  of its command line, besides --view
 * @param {{folder?: string, seconds?: number}} where  folder of the programs (TANDEM_BIN)
 * @returns {Promise<{url: string, page: string, pid: number, words: function(): string,
 *   stop: function(): Promise<void>}>}
 */
export async function startDemo(name, options = [], {folder = process.env.TANDEM_BIN,
                                                     seconds = 60} = {}) {
  if (!folder) throw new Error('TANDEM_BIN must be the folder of the programs');
  const port = await freePort();
  const child = spawn(join(folder, name), ['--view', String(port), ...options],
                      {stdio: ['ignore', 'ignore', 'pipe']});
  let words = '';
  const over = new Promise((resolve) => child.on('close', resolve));
  const url = await new Promise((resolve, reject) => {
    const fail = (why) => reject(new Error(`${name}: ${why}\n${words}`));
    const timer = setTimeout(() => fail(`no view within ${seconds} s`), 1000 * seconds);
    child.on('error', (error) => fail(error.message));
    child.on('close', (code) => fail(`ended with ${code}`));
    child.stderr.on('data', (data) => {
      words = (words + data).slice(-20000);
      const found = /^view: (http:\S+)$/m.exec(words);
      if (!found) return;
      clearTimeout(timer);
      resolve(found[1]);
    });
  });
  const front = process.env.TANDEM_VIEW_PAGE === 'source' ? await overlayFiles(url) : null;
  return {
    url, page: front?.url ?? url, pid: child.pid, words: () => words,
    async stop() {
      front?.close();
      child.kill('SIGINT');
      const timer = setTimeout(() => child.kill('SIGKILL'), 10000);
      await over;
      clearTimeout(timer);
    },
  };
}
