// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The room's members and their sealed messages, by a direct connection if there is one, else through the server.
import {Cipher, HELLO, KNOWN, PACKET, REFUSED} from './cipher.js';
import {Direct} from './direct.js';
import {CAME, GONE, NEWEST, RELIABLE, Server} from './server.js';

// The first byte of a sealed packet (../peer/room_transport.h).
export const STATES = 0;      // sharing, may be lost
export const CONSTRAINTS = 1; // sharing
export const WORDS = 2;       // JSON
export const DIGEST = 3;      // positions of the sender's bodies
export const HAND = 4;

const isReliable = (channel) => channel === CONSTRAINTS || channel === WORDS;
const encode = (value) => new TextEncoder().encode(JSON.stringify(value));
const TRY_AGAIN_MS = 8000;
const SILENT_MS = 8000;   // a participant sends ten times a second
const AWAY_MS = 90000;    // of a hidden page, whose timers hardly run

/** Limit of known ids, ever, as in the cipher: a server can invent any number. */
const MAX_MEMBERS = 4096;

class Member {
  constructor(id) {
    Object.assign(this, {id, name: '', colour: '#888888', listed: false, here: false, away: false, dropped: false,
                         direct: null, tried: -Infinity, heard: 0, told: -Infinity, canMeet: false,
                         strange: false});
  }
}

export class Members {
  #cipher;
  #due = 0;  // ms, when the last delayed message is due

  /**
   * @param {{key: Uint8Array, room: string, url: string, self: bigint, profile: object}} def
   * @param {object} listener  heard(member, channel, bytes), came(member), left(member), changed(), time(sent, server)
   */
  constructor({key, room, url, self, profile}, listener) {
    this.self = self;
    this.profile = profile;
    this.listener = listener;
    this.all = new Map();
    this.delay = 0;  // ms, one way, added to the real delay
    this.refused = 0;
    this.bytesSent = 0;
    this.relayed = false;  // true: no direct connections, for tests
    this.#cipher = new Cipher(key, room, self);
    this.server = new Server(url, self, {
      opened: () => listener.changed(),
      closed: () => this.#lostServer(),
      welcome: (ids) => {
        for (const id of ids) this.#listed(id);
        listener.welcome();
      },
      heard: (kind, id, bytes) => this.#fromServer(kind, id, bytes),
      time: (sent, server) => listener.time(sent, server),
    });
  }

  get here() { return [...this.all.values()].filter((member) => member.here); }

  /** Another member uses another key. */
  get strangers() { return [...this.all.values()].some((member) => member.listed && member.strange); }

  /** False if the member is unreachable. */
  send(to, channel, bytes) {
    const member = this.all.get(to);
    if (!member?.here) return false;
    const plain = new Uint8Array(1 + bytes.length);
    plain[0] = channel;
    plain.set(bytes, 1);
    if (this.delay === 0 && this.#due <= performance.now()) return this.#seal(member, plain);
    this.#due = Math.max(this.#due, performance.now() + this.delay);
    setTimeout(() => this.#seal(member, plain), this.#due - performance.now());
    return true;
  }
  say(to, words) { return this.send(to, WORDS, encode(words)); }
  sayAll(words) { for (const {id} of this.here) this.say(id, words); }
  sendAll(channel, bytes) { for (const {id, away} of this.here) if (!away) this.send(id, channel, bytes); }
  drop(id) {
    const member = this.all.get(id);
    if (member) member.dropped = true;
    if (member) this.#check(member);
  }
  /** Announces the departure, and closes. */
  leave() {
    // Through the server if possible: closing a direct connection may lose the last message.
    for (const {id, listed} of this.here) {
      const sealed = this.#cipher.seal(id, new Uint8Array([WORDS, ...encode({bye: true})]));
      if (!listed || !this.server.send(RELIABLE, id, sealed)) this.all.get(id).direct?.send(sealed, true);
    }
    for (const {direct} of this.all.values()) direct?.close();
    this.server.close();
  }
  /** Call regularly: drops silent direct connections, and retries failed ones. */
  tend() {
    for (const member of this.here) {
      const silent = performance.now() - member.heard > (member.away ? AWAY_MS : SILENT_MS);
      if (silent && member.direct?.open) {
        member.direct.close();
        member.direct = null;
        this.#seal(member, new Uint8Array([WORDS, ...encode({rtc: {closed: true}})]));
        this.#check(member);
      }
      this.#meet(member);
    }
  }

  #seal(member, plain) {
    const sealed = this.#cipher.seal(member.id, plain);
    if (!sealed) return false;
    const reliable = isReliable(plain[0]);
    this.bytesSent += sealed.length;
    if (member.direct?.send(sealed, reliable)) return true;
    return member.listed && this.server.send(reliable ? RELIABLE : NEWEST, member.id, sealed);
  }

  #of(id) {
    if (!this.all.has(id) && this.all.size < MAX_MEMBERS) this.all.set(id, new Member(id));
    return this.all.get(id);
  }
  #listed(id) {
    if (id === this.self || id === 0n) return;
    const member = this.#of(id);
    if (!member) return;
    member.listed = true;
    this.#greet(id);
  }
  #greet(id) { this.server.send(RELIABLE, id, this.#cipher.hello(encode(this.profile))); }
  #lostServer() {
    for (const member of this.all.values()) {
      member.listed = false;
      this.#check(member);
    }
    this.listener.changed();
  }
  #fromServer(kind, id, bytes) {
    if (kind === CAME) {
      this.#listed(id);
    } else if (kind === GONE) {
      const member = this.all.get(id);
      if (!member) return;
      member.listed = false;
      this.#check(member);
    } else if (kind === NEWEST || kind === RELIABLE) {
      const member = this.#of(id);
      if (member) this.#open(member, bytes);
    }
  }
  #open(member, sealed) {
    const {kind, bytes} = this.#cipher.open(member.id, sealed);
    if (kind === HELLO || kind === KNOWN) {
      this.#introduce(member, bytes);
      if (kind === HELLO) this.#greet(member.id);
      // A packet proves to the other end that the hello is not a recording.
      if (!member.here) this.#seal(member, new Uint8Array([WORDS, ...encode({})]));
      return;
    }
    if (kind !== PACKET || bytes.length === 0) {
      ++this.refused;
      // A sender whose messages do not open has another key, unless an earlier one opened.
      if (kind === REFUSED && !member.name && !member.strange) {
        member.strange = true;
        this.listener.changed();
      }
      return;
    }
    if (member.dropped) return;
    // A direct connection may deliver after the farewell: that does not bring a member back.
    if (!member.here && !member.listed && !member.direct?.open) return;
    member.heard = performance.now();
    if (!member.here) {
      member.here = true;
      member.away = false;
      this.listener.came(member);
      this.#meet(member);
    }
    if (bytes[0] === WORDS) this.#words(member, bytes.subarray(1));
    else this.listener.heard(member, bytes[0], bytes.subarray(1));
  }
  /** Untrusted, like all input from members. */
  #introduce(member, bytes) {
    try {
      const {name, colour, meets} = JSON.parse(new TextDecoder().decode(bytes));
      member.name = String(name ?? '').slice(0, 24);
      member.colour = /^#[0-9a-f]{6}$/i.test(colour) ? colour : '#888888';
      member.canMeet = meets === true;
      member.strange = false;
      this.listener.changed();
    } catch {
      ++this.refused;
    }
  }
  #words(member, bytes) {
    let words = null;
    try {
      words = JSON.parse(new TextDecoder().decode(bytes));
    } catch {
      ++this.refused;
    }
    if (words === null || typeof words !== 'object') return;
    if (words.bye === true) {
      member.direct?.close();
      member.listed = false;
      this.#check(member);
      return;
    }
    if (typeof words.away === 'boolean' && words.away !== member.away) {
      member.away = words.away;
      this.listener.changed();
    }
    if (words.rtc?.closed === true) {
      member.direct?.close();
      member.direct = null;
      return this.#check(member);
    }
    if (words.rtc && typeof words.rtc === 'object' && !this.relayed) this.#directOf(member, false)?.hear(words.rtc);
    this.listener.words(member, words);
  }
  #directOf(member, offers) {
    if (typeof RTCPeerConnection === 'undefined') return null;
    member.direct ??= new Direct(offers, {
      say: (rtc) => this.#seal(member, new Uint8Array([WORDS, ...encode({rtc})])),
      heard: (sealed) => this.#open(member, sealed),
      changed: () => {
        this.#check(member);
        this.listener.changed();
      },
    });
    return member.direct;
  }
  #meet(member) {
    if (this.relayed || !member.canMeet || member.direct?.open || !(this.self < member.id)) return;
    if (performance.now() - member.tried < TRY_AGAIN_MS || !member.listed) return;
    member.tried = performance.now();
    member.direct?.close();
    member.direct = null;
    this.#directOf(member, true);
  }
  #check(member) {
    const reachable = (member.listed || member.direct?.open) && !member.dropped;
    if (reachable || !member.here) return;
    member.here = false;
    member.direct?.close();
    member.direct = null;
    this.listener.left(member);
  }
}
