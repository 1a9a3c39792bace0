// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The page's files as they lie in the source tree.
import {readFile} from 'node:fs/promises';
import {createServer} from 'node:http';
import {connect} from 'node:net';
import {extname, join} from 'node:path';
import {fileURLToPath} from 'node:url';

const PAGE = fileURLToPath(new URL('../../../demos/view/page/', import.meta.url));
const TYPES = {'.html': 'text/html; charset=utf-8', '.js': 'text/javascript; charset=utf-8',
               '.css': 'text/css; charset=utf-8', '.svg': 'image/svg+xml'};
const POLICY = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; " +
               "connect-src 'self'; base-uri 'none'; form-action 'none'";

/**
 * Answers a request below /token/ with a file of the page; three.js is taken from where npm has
 * put it.
 * @param {string} token
 */
export async function answer(token, request, response) {
  const path = new URL(request.url, 'http://localhost').pathname;
  const name = path === `/${token}/` ? 'index.html' : path.slice(token.length + 2);
  try {
    if (!path.startsWith(`/${token}/`) || !/^[\w.]+$/.test(name)) throw new Error('no such file');
    const folder = /^three\..*\.js$/.test(name) ? join(PAGE, 'node_modules/three/build') : PAGE;
    const body = await readFile(join(folder, name));
    response.writeHead(200, {'Content-Type': TYPES[extname(name)] ?? 'application/octet-stream',
                             'Content-Security-Policy': POLICY});
    response.end(body);
  } catch {
    response.writeHead(404).end();
  }
}

/**
 * The socket of a program with the files of the source tree, so that a changed page need not be
 * built into the program to be tried.
 * @param {string} url  of the program's page
 * @returns {Promise<{url: string, close: function()}>}
 */
export async function overlayFiles(url) {
  const {host, hostname, port, pathname, origin} = new URL(url);
  const token = pathname.split('/')[1];
  const server = createServer((request, response) => answer(token, request, response));
  server.on('upgrade', (request, socket) => {
    const behind = connect(Number(port), hostname, () => {
      const headers = {...request.headers, host};
      if (headers.origin) headers.origin = origin;
      const lines = Object.entries(headers).map(([name, value]) => `${name}: ${value}\r\n`);
      behind.write(`GET ${request.url} HTTP/1.1\r\n${lines.join('')}\r\n`);
      behind.pipe(socket).pipe(behind);
    });
    for (const [end, other] of [[behind, socket], [socket, behind]]) {
      end.on('error', () => other.destroy());
      end.on('close', () => other.destroy());
    }
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return {url: `http://127.0.0.1:${server.address().port}${pathname}`,
          close() {
            server.closeAllConnections();
            server.close();
          }};
}
