// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// node inline.mjs FOLDER: compat.js there is tandem.js with tandem.wasm in it, for pages that can load
// nothing but a script.
import {readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';

const folder = process.argv[2];
const base64 = readFileSync(join(folder, 'tandem.wasm')).toString('base64');
writeFileSync(join(folder, 'compat.js'), `// SPDX-License-Identifier: MIT
import {init as load} from './tandem.js';
export * from './tandem.js';
const bytes = Uint8Array.from(atob('${base64}'), (c) => c.charCodeAt(0));
/** As tandem.js's, with the module at hand. */
export const init = () => load(bytes);
`);
