// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// node compress.mjs FOLDER FILE..: compresses the files to FOLDER/NAME.gz, and removes all else
// there.
import {mkdirSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {basename, join} from 'node:path';
import {gzipSync} from 'node:zlib';

const [folder, ...files] = process.argv.slice(2);
rmSync(folder, {recursive: true, force: true});
mkdirSync(folder, {recursive: true});
let total = 0;
for (const file of files) {
  const bytes = gzipSync(readFileSync(file), {level: 9});
  total += bytes.length;
  writeFileSync(join(folder, `${basename(file)}.gz`), bytes);
}
console.log(`page: ${files.length} files, ${total} bytes`);
