// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// QR codes of the page, read by zbar, which knows nothing of how they were made.
import assert from 'node:assert/strict';
import {spawnSync} from 'node:child_process';
import {mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import test from 'node:test';
import {qrCode} from '../../tools/room/page/qr.js';

const reader = spawnSync('zbarimg', ['--version']).error ? 'no zbarimg (Debian: zbar-tools)' : false;
const LETTERS = 'http://192.168.0.17:8080/0123456789abcdef/?room=sandbox#Fm2s15C7-fNekVUTzo5gs4kRgu5grPwCX3qM0oK-UGw';

test('links of any length that fits are read again', {skip: reader}, () => {
  const folder = mkdtempSync(join(tmpdir(), 'qr-'));
  try {
    for (const length of [1, 17, 18, 53, 78, 106, 134, 154, 192, 230, 271]) {
      const text = LETTERS.repeat(3).slice(0, length);
      const code = qrCode(text);
      const size = 4 * (code.length + 8);
      const pixels = Buffer.alloc(size * size, 255);
      code.forEach((row, i) => row.forEach((dark, j) => {
        if (!dark) return;
        for (let a = 0; a < 4; ++a) pixels.fill(0, (4 * (i + 4) + a) * size + 4 * (j + 4), (4 * (i + 4) + a) * size + 4 * (j + 5));
      }));
      const file = join(folder, 'code.pgm');
      writeFileSync(file, Buffer.concat([Buffer.from(`P5 ${size} ${size} 255\n`), pixels]));
      const {stdout, stderr} = spawnSync('zbarimg', ['--quiet', '--raw', file], {encoding: 'utf8'});
      assert.equal(stdout.trimEnd(), text, `${length} bytes: ${stderr}`);
    }
  } finally {
    rmSync(folder, {recursive: true});
  }
});

test('what is too long has no code', () => {
  assert.equal(qrCode('x'.repeat(272)), null);
  assert.ok(qrCode('x'.repeat(271)));
});
