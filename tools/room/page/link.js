// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The page's address: the room, and its key in the fragment, which is never sent to a server.

const ROOMS = ['sandbox', 'piano', 'tennis'];
const KEY_BYTES = 32;

const toText = (bytes) => btoa(String.fromCharCode(...bytes)).replace(/\+/g, '-').replace(/\//g, '_').replace(/=/g, '');

function toBytes(text) {
  if (!/^[\w-]{43}$/.test(text)) return null;
  const bytes = Uint8Array.from(atob(text.replace(/-/g, '+').replace(/_/g, '/')), (c) => c.charCodeAt(0));
  return bytes.length === KEY_BYTES ? bytes : null;
}

/** @returns {{room: string, rooms: string[], key: Uint8Array, url: string, share: string}}  url: of the server's socket */
export function readLink() {
  const query = new URLSearchParams(location.search);
  const room = ROOMS.includes(query.get('room')) ? query.get('room') : ROOMS[0];
  let key = toBytes(location.hash.slice(1));
  if (!key && location.hash.length > 1) throw new Error('This link is not whole: its key, after the #, has 43 letters.');
  if (!key) {
    // A link without a key opens a new room, to which its user may invite others.
    key = crypto.getRandomValues(new Uint8Array(KEY_BYTES));
    history.replaceState(null, '', `${location.pathname}?room=${room}#${toText(key)}`);
  }
  const folder = new URL('.', location.href);
  const socket = new URL(`socket/${room}`, folder);
  socket.protocol = location.protocol === 'https:' ? 'wss:' : 'ws:';
  socket.hash = '';
  const of = (name) => `${folder.origin}${folder.pathname}?room=${name}#${toText(key)}`;
  return {room, rooms: ROOMS, key, url: socket.href, of, share: of(room)};
}
