// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The room's cipher (../cipher/cipher.h) as WebAssembly, the same code as in native peers.

const ROOM_BYTES = 64 * 1024;
export const REFUSED = 0;
export const HELLO = 1;
export const KNOWN = 2;
export const PACKET = 3;

let c = null;

const memory = (at, size) => new Uint8Array(c.memory.buffer, at, size);

/** Loads the module; call once, first. @param {BufferSource} bytes */
export async function initCipher(bytes) {
  const {instance} = await WebAssembly.instantiate(bytes, {
    room: {random: (at, size) => crypto.getRandomValues(memory(at, size))},
    wasi_snapshot_preview1: {proc_exit: () => { throw new Error('cipher: aborted'); }},
  });
  c = instance.exports;
  c._initialize?.();
}

/** Seals and opens messages between members. Ids are BigInt. */
export class Cipher {
  #at;
  #buffer;

  /** @param {Uint8Array} key  32 bytes @param {string} room @param {bigint} self */
  constructor(key, room, self) {
    this.#buffer = c.malloc(ROOM_BYTES);
    const name = new TextEncoder().encode(room);
    memory(this.#buffer, key.length).set(key);
    memory(this.#buffer + key.length, name.length).set(name);
    this.#at = c.room_cipher_create(this.#buffer, key.length, this.#buffer + key.length, name.length, self);
    memory(this.#buffer, key.length).fill(0);
    if (this.#at === 0) throw new Error('the room key must have 32 bytes');
  }

  #run(bytes, call) {
    if (bytes.length > ROOM_BYTES - 64) return -1;
    memory(this.#buffer, bytes.length).set(bytes);
    return call(this.#buffer, bytes.length);
  }
  #taken(size) { return memory(this.#buffer, size).slice(); }

  /** @param {Uint8Array} profile  512 bytes at most */
  hello(profile) {
    return this.#taken(this.#run(profile, (at, size) => c.room_cipher_hello(this.#at, at, size)));
  }
  /** @returns {?Uint8Array}  null if that member has not sent a hello */
  seal(to, plain) {
    const size = this.#run(plain, (at, n) => c.room_cipher_seal(this.#at, to, at, n));
    return size < 0 ? null : this.#taken(size);
  }
  /** @returns {{kind: number, bytes: Uint8Array}} */
  open(from, sealed) {
    const result = this.#run(sealed, (at, size) => c.room_cipher_open(this.#at, from, at, size));
    if (result === -1) return {kind: REFUSED, bytes: new Uint8Array(0)};
    return {kind: result >>> 24, bytes: this.#taken(result & 0xffffff)};
  }
}
