// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A link as a QR code (ISO/IEC 18004): bytes, error correction L, versions 1 to 10, up to 271 bytes.

// Per version, at level L: data codewords, error correction codewords per block, blocks.
const LEVEL_L = [[19, 7, 1], [34, 10, 1], [55, 15, 1], [80, 20, 1], [108, 26, 1], [136, 18, 2], [156, 20, 2],
                 [194, 24, 2], [232, 30, 2], [274, 18, 4]];
const ALIGNMENT = [[], [6, 18], [6, 22], [6, 26], [6, 30], [6, 34], [6, 22, 38], [6, 24, 42], [6, 26, 46], [6, 28, 50]];
const MASKS = [
  (i, j) => (i + j) % 2 === 0, (i) => i % 2 === 0, (_, j) => j % 3 === 0, (i, j) => (i + j) % 3 === 0,
  (i, j) => ((i >> 1) + Math.floor(j / 3)) % 2 === 0, (i, j) => (i * j) % 2 + (i * j) % 3 === 0,
  (i, j) => ((i * j) % 2 + (i * j) % 3) % 2 === 0, (i, j) => ((i + j) % 2 + (i * j) % 3) % 2 === 0,
];

// GF(256) with x^8 + x^4 + x^3 + x^2 + 1.
const EXP = new Uint8Array(510);
const LOG = new Uint8Array(256);
for (let i = 0, x = 1; i < 255; ++i) {
  EXP[i] = EXP[i + 255] = x;
  LOG[x] = i;
  x = x << 1 ^ (x & 128 ? 0x11d : 0);
}
const times = (a, b) => (a && b ? EXP[LOG[a] + LOG[b]] : 0);

/** Reed-Solomon: the remainder of the data divided by the generator of that degree. */
function correction(data, degree) {
  let generator = [1];
  for (let i = 0; i < degree; ++i) {
    const next = [...generator, 0];
    generator.forEach((g, k) => { next[k + 1] ^= times(g, EXP[i]); });
    generator = next;
  }
  const rest = [...data, ...Array(degree).fill(0)];
  for (let i = 0; i < data.length; ++i) {
    const factor = rest[i];
    if (factor) generator.forEach((g, k) => { rest[i + k] ^= times(g, factor); });
  }
  return rest.slice(data.length);
}

/** All codewords in drawing order. */
function codewords(bytes, version) {
  const [room, degree, count] = LEVEL_L[version - 1];
  const bits = [];
  const put = (value, length) => { for (let i = length - 1; i >= 0; --i) bits.push(value >> i & 1); };
  put(4, 4);
  put(bytes.length, version < 10 ? 8 : 16);
  for (const byte of bytes) put(byte, 8);
  put(0, Math.min(4, 8 * room - bits.length));
  while (bits.length % 8) bits.push(0);
  const data = [];
  for (let i = 0; i < bits.length; i += 8) data.push(parseInt(bits.slice(i, i + 8).join(''), 2));
  for (let pad = 0xec; data.length < room; pad ^= 0xec ^ 0x11) data.push(pad);
  const least = Math.floor(room / count);
  const blocks = [];
  for (let i = 0, at = 0; i < count; ++i) {
    const length = least + (i >= count - room % count ? 1 : 0);
    blocks.push(data.slice(at, at + length));
    at += length;
  }
  const out = [];
  for (let i = 0; i <= least; ++i) for (const block of blocks) if (i < block.length) out.push(block[i]);
  const checks = blocks.map((block) => correction(block, degree));
  for (let i = 0; i < degree; ++i) for (const check of checks) out.push(check[i]);
  return out;
}

function bch(value, generator, degree) {
  let rest = value << degree;
  for (let i = 31 - Math.clz32(rest); i >= degree; --i) if (rest >> i & 1) rest ^= generator << i - degree;
  return value << degree | rest;
}

class Matrix {
  constructor(version) {
    this.size = 17 + 4 * version;
    this.dark = Array.from({length: this.size}, () => Array(this.size).fill(false));
    this.fixed = Array.from({length: this.size}, () => Array(this.size).fill(false));
    this.#patterns(version);
  }
  set(i, j, dark) {
    if (i < 0 || j < 0 || i >= this.size || j >= this.size) return;
    this.dark[i][j] = Boolean(dark);
    this.fixed[i][j] = true;
  }
  #patterns(version) {
    for (const [i, j] of [[3, 3], [3, this.size - 4], [this.size - 4, 3]]) {
      for (let a = -4; a <= 4; ++a) {
        for (let b = -4; b <= 4; ++b) {
          const ring = Math.max(Math.abs(a), Math.abs(b));
          this.set(i + a, j + b, ring !== 2 && ring !== 4);
        }
      }
    }
    const centres = ALIGNMENT[version - 1];
    const last = centres.length - 1;
    centres.forEach((i, k) => centres.forEach((j, l) => {
      if ((k === 0 && l === 0) || (k === 0 && l === last) || (k === last && l === 0)) return;
      for (let a = -2; a <= 2; ++a) {
        for (let b = -2; b <= 2; ++b) this.set(i + a, j + b, Math.max(Math.abs(a), Math.abs(b)) !== 1);
      }
    }));
    for (let k = 8; k < this.size - 8; ++k) {
      this.set(6, k, k % 2 === 0);
      this.set(k, 6, k % 2 === 0);
    }
    this.format(0);
    if (version < 7) return;
    const text = bch(version, 0x1f25, 12);
    for (let k = 0; k < 18; ++k) {
      const [i, j] = [Math.floor(k / 3), this.size - 11 + k % 3];
      this.set(i, j, text >> k & 1);
      this.set(j, i, text >> k & 1);
    }
  }
  /** Level L and the mask, twice. */
  format(mask) {
    const text = bch(1 << 3 | mask, 0x537, 10) ^ 0x5412;
    const bit = (k) => text >> k & 1;
    for (let k = 0; k < 6; ++k) this.set(k, 8, bit(k));
    this.set(7, 8, bit(6));
    this.set(8, 8, bit(7));
    this.set(8, 7, bit(8));
    for (let k = 9; k < 15; ++k) this.set(8, 14 - k, bit(k));
    for (let k = 0; k < 8; ++k) this.set(8, this.size - 1 - k, bit(k));
    for (let k = 8; k < 15; ++k) this.set(this.size - 15 + k, 8, bit(k));
    this.set(this.size - 8, 8, true);
  }
  /** Two columns at a time, up and down, from the right. */
  fill(words) {
    let k = 0;
    for (let right = this.size - 1; right > 0; right -= 2) {
      if (right === 6) right = 5;
      const up = (right + 1 & 2) === 0;
      for (let step = 0; step < this.size; ++step) {
        const i = up ? this.size - 1 - step : step;
        for (const j of [right, right - 1]) {
          if (this.fixed[i][j]) continue;
          this.dark[i][j] = Boolean(k < 8 * words.length && words[k >> 3] >> 7 - (k & 7) & 1);
          ++k;
        }
      }
    }
  }
  mask(which) {
    const flips = MASKS[which];
    this.dark.forEach((row, i) => row.forEach((dark, j) => {
      if (!this.fixed[i][j]) row[j] = dark !== flips(i, j);
    }));
    this.format(which);
  }
  /** Penalty of runs, 2 x 2 blocks and imbalance: less is easier to read. */
  penalty() {
    let sum = 0;
    let darks = 0;
    const at = (i, j, across) => (across ? this.dark[i][j] : this.dark[j][i]);
    for (const across of [true, false]) {
      for (let i = 0; i < this.size; ++i) {
        for (let j = 0, run = 0; j < this.size; ++j) {
          run = j > 0 && at(i, j, across) === at(i, j - 1, across) ? run + 1 : 1;
          if (run === 5) sum += 3;
          else if (run > 5) sum += 1;
        }
      }
    }
    for (let i = 0; i < this.size; ++i) {
      for (let j = 0; j < this.size; ++j) {
        darks += this.dark[i][j] ? 1 : 0;
        if (i === 0 || j === 0) continue;
        const all = [this.dark[i][j], this.dark[i - 1][j], this.dark[i][j - 1], this.dark[i - 1][j - 1]];
        if (all.every(Boolean) || !all.some(Boolean)) sum += 3;
      }
    }
    return sum + 10 * Math.floor(Math.abs(darks / this.size ** 2 - 0.5) * 20);
  }
}

/** @param {string} text @returns {?boolean[][]}  dark modules, row by row; null if it is too long */
export function qrCode(text) {
  const bytes = new TextEncoder().encode(text);
  const version = 1 + LEVEL_L.findIndex(([room], k) => bytes.length + (k < 9 ? 2 : 3) <= room);
  if (version === 0) return null;
  const words = codewords(bytes, version);
  const tried = MASKS.map((_, which) => {
    const matrix = new Matrix(version);
    matrix.fill(words);
    matrix.mask(which);
    return {matrix, penalty: matrix.penalty()};
  });
  return tried.reduce((best, one) => (one.penalty < best.penalty ? one : best)).matrix.dark;
}

/** Draws it with the quiet zone of four modules. @param {HTMLCanvasElement} canvas */
export function drawQr(canvas, text) {
  const code = qrCode(text);
  canvas.hidden = !code;
  if (!code) return;
  canvas.width = canvas.height = code.length + 8;
  const pen = canvas.getContext('2d');
  pen.fillStyle = '#ffffff';
  pen.fillRect(0, 0, canvas.width, canvas.height);
  pen.fillStyle = '#000000';
  code.forEach((row, i) => row.forEach((dark, j) => { if (dark) pen.fillRect(j + 4, i + 4, 1, 1); }));
}
