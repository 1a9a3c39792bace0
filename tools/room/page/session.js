// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// This page as a peer: its world in steps of session time, shared with the room's members. A hidden page leaves and
// releases its grips; once visible it rejoins like a newcomer, which learns before it is heard.
import {Peer, Transport} from './tandem.js';
import {Clock} from './clock.js';
import {Grip} from './grip.js';
import {Hand} from './hand.js';
import {CONSTRAINTS, DIGEST, HAND, Members, STATES} from './members.js';
import {Presence, encodeHeadset, encodePointer} from './presence.js';
import {RoomWorld, STEP_MS, WAIT} from './world.js';

const STEP_NS = 16666667n;
const MOST_STEPS = 8;        // per call
const TOO_LATE_MS = 250;     // older steps are skipped
const LATENESS_SHARE = 0.1;  // weight of a new value in the mean
const ASLEEP_MS = 1000;      // the page was suspended for longer
const DIGEST_EVERY = 30;     // steps
const HAND_EVERY = 3;        // steps
const HAVE_EVERY = 120;      // steps
const AWAY_EVERY_MS = 2000;
const ASK_SOON_MS = 200;
const ASK_TIME_MS = 10000;
const PACKET_BYTES = 1100;   // a data channel must not fragment losable packets
// Less than half of the default budget, for pages that step and draw 200 bodies on one core (docs/room.md).
const PEER = {compact: true, replayBudget: 1.5};
const MADE_EACH = 64;
const TELL_MS = 1000;        // limit on repeating everything for one member
const POINTER = 'pointer';   // the hand of mouse or finger; a headset's are 'left' and 'right'

export class Session {
  #peer = null;
  #transport;
  #step = 0;      // number of the next step: its session time over STEP_NS
  #ran = 0;       // ms, performance.now() of the last advance
  #asked = -Infinity;
  #told = 0;      // ms, of the last farewell
  #digests = new Map();  // by member, to compare

  /** @param {object} room  its file @param {object} link  key, room, url @param {object} profile  name, colour */
  constructor(room, link, profile, changed) {
    this.self = randomId();
    this.changed = changed;
    this.world = new RoomWorld(room);
    this.clock = new Clock();
    this.holding = new Map();  // by hand: {held, anchor, attachment}
    /** The headset user's poses of head, left and right, if known; null without a headset. */
    this.seen = null;
    this.away = false;
    this.apart = new Map();   // by member: {typical, most}, m
    this.presence = new Presence((name) => this.world.find(name));
    this.onMade = () => {};
    this.onHand = () => {};   // at each step: session time (ms), the hand or null
    this.steps = 0;
    this.late = 0;            // ms, mean delay of steps
    this.members = new Members({...link, self: this.self, profile: {...profile, meets: true}}, {
      welcome: () => changed(),
      came: (member) => this.#came(member),
      left: (member) => this.#left(member),
      changed: () => this.#changed(),
      heard: (member, channel, bytes) => this.#heard(member, channel, bytes),
      words: (member, words) => this.#words(member, words),
      time: (sent, server) => this.#time(sent, server),
    });
    this.#transport = new Transport({
      self: this.self, maxPacket: PACKET_BYTES,
      send: (to, bytes, reliable) => this.members.send(to, reliable ? CONSTRAINTS : STATES, bytes),
      onDrop: (id) => this.members.drop(id),
    });
    this.#join();
  }

  get now() { return BigInt(this.#step) * STEP_NS; }
  /** ms, session time of the world. */
  get time() { return this.#step * STEP_MS; }
  get running() { return this.#ran > 0 && !this.away; }
  /** It takes part, and has received others' bodies. */
  get greeted() { return this.running && this.#peer.stats().updatesReceived > 0n; }

  /** Runs due steps. @returns {number}  how many */
  advance() {
    const real = performance.now();
    if (real - this.#asked > (this.clock.settled ? ASK_TIME_MS : ASK_SOON_MS)) this.#askTime(real);
    if (this.away && real - this.#told > AWAY_EVERY_MS) {
      this.#told = real;
      this.members.sayAll({away: true});
    }
    if (this.away || !this.clock.known) return 0;
    if (this.#ran > 0 && real - this.#ran > ASLEEP_MS) this.#join();
    this.#ran = real;
    const due = this.clock.now() / STEP_MS;
    if (this.#step > 0 && this.#step + 1 <= due) {
      const late = Math.min((due - this.#step - 1) * STEP_MS, TOO_LATE_MS);
      this.late += LATENESS_SHARE * (late - this.late);
    }
    if (due - this.#step > TOO_LATE_MS / STEP_MS) {
      this.#step = Math.floor(due);
      this.world.forget();
    }
    let steps = 0;
    for (; this.#step + 1 <= due && steps < MOST_STEPS; ++steps) this.#advance();
    return steps;
  }

  /** The grip of mouse or finger. */
  get hand() { return this.holding.get(POINTER) ?? null; }
  /** Holds a body at a point of its own frame; the pointer releases any other. */
  grab(held, attachment) {
    this.release();
    this.holding.set(POINTER, new Hand(held, attachment));
  }
  release() {
    if (this.#letGo(POINTER)) this.members.sendAll(HAND, new Uint8Array(0));
  }
  /** A headset's hand grasps a body. @param {string} side  left or right @param {object} pose  of the hand, world */
  grip(side, held, pose) {
    this.letGo(side);
    this.holding.set(side, new Grip(held, pose));
    this.#shareLoads();
  }
  letGo(side) {
    if (this.#letGo(side)) this.#shareLoads();
  }
  /** Sets the poses of the headset's user; null: no headset. */
  track(seen) {
    if (this.seen && !seen) this.members.sendAll(HAND, new Uint8Array(0));
    this.seen = seen;
    const time = this.clock.known ? this.clock.now() : 0;
    for (const [side, grip] of this.holding) if (seen?.[side]) grip.track(time, seen[side]);
  }
  letGoOfAll() {
    this.release();
    for (const side of [...this.holding.keys()]) this.letGo(side);
  }
  /** Adds a body to the room. @param {object} shape @param {number[]} position  m */
  make(shape, position) {
    const def = {name: `made/${this.self.toString(16)}-${this.world.made.length}`, shape, position};
    if (!this.#made(def)) return false;
    this.members.sayAll({made: [def]});
    return true;
  }
  /** The page is hidden. */
  leave() {
    if (this.away) return;
    this.letGoOfAll();
    this.onHand(this.time, null);
    this.#peer.leave(this.now > 0n ? this.now : 1n);
    this.away = true;
    this.members.sayAll({away: true});
    this.changed();
  }
  comeBack() {
    if (!this.away) return;
    this.away = false;
    this.#askTime(performance.now());
    this.#join();
    this.members.sayAll({away: false});
    this.changed();
  }
  end() {
    if (!this.away) this.leave();
    this.members.leave();
  }

  /** Joins like a newcomer. */
  #join() {
    this.holding.clear();
    this.onHand(this.time, null);
    this.#peer?.free();
    this.#transport.take();
    this.world.forget();
    this.#peer = new Peer(this.world.world, this.#transport, PEER);
    for (const {name, body, mass} of this.world.bodies) if (mass > 0) this.#peer.share(name, body);
  }
  #advance() {
    for (const hand of this.holding.values()) hand.update(this.#peer, this.now);
    this.onHand(this.time, this.hand);
    this.#peer.beforeStep(this.now);
    this.world.step();
    ++this.#step;
    ++this.steps;
    this.#peer.afterStep(this.now);
    this.world.remember(this.time);
    for (const [side, {lost}] of this.holding) if (lost) this.letGo(side);
    this.#compare();
    if (this.#step % DIGEST_EVERY === 0) {
      this.members.sendAll(DIGEST, this.world.digest(this.now));
      this.members.tend();
    }
    // Messages may be lost while connections change: a member with fewer bodies is sent all.
    if (this.#step % HAVE_EVERY === 0) this.members.sayAll({have: this.world.made.length});
    if (this.#step % HAND_EVERY === 0) this.#tellHands();
  }
  /** Compares others' positions, once this world has reached their time. */
  #compare() {
    for (const [id, bytes] of this.#digests) {
      const apart = this.world.compare(bytes);
      if (apart === WAIT) continue;
      this.#digests.delete(id);
      if (apart) this.apart.set(id, apart);
    }
  }
  #askTime(real) {
    this.#asked = real;
    this.members.server.askTime();
  }
  #time(sent, server) {
    this.clock.take(sent, server);
    if (!this.clock.known) this.members.server.askTime();
    else this.changed();
  }
  #changed() {
    if (!this.clock.known && this.members.server.open) this.#askTime(performance.now());
    for (const member of this.members.all.values()) {
      this.#transport.connected(member.id, member.here && !member.away);
    }
    this.changed();
  }
  #came(member) {
    this.#tellMade(member);
    if (this.away) this.members.say(member.id, {away: true});
    this.#changed();
  }
  #tellMade(member) {
    member.told = performance.now();
    for (let first = 0; first < this.world.made.length; first += MADE_EACH) {
      this.members.say(member.id, {made: this.world.made.slice(first, first + MADE_EACH)});
    }
  }
  #left(member) {
    this.apart.delete(member.id);
    this.presence.forget(member.id);
    this.#digests.delete(member.id);
    this.#changed();
  }
  #made(def) {
    const made = this.world.make(def);
    if (!made) return false;
    this.#peer.share(made.name, made.body);
    this.onMade(made);
    return true;
  }
  #words(member, words) {
    if (words.have < this.world.made.length && performance.now() - member.told > TELL_MS) this.#tellMade(member);
    if (Array.isArray(words.made)) for (const def of words.made.slice(0, MADE_EACH)) this.#made(def);
  }
  #heard(member, channel, bytes) {
    if (channel === STATES || channel === CONSTRAINTS) {
      if (!this.away && !member.away) this.#transport.receive(member.id, bytes);
    } else if (channel === DIGEST && !this.away) {
      this.#digests.set(member.id, bytes.slice());
    } else if (channel === HAND) {
      this.presence.hear(member.id, bytes);
    }
  }
  #letGo(which) {
    const hand = this.holding.get(which);
    if (!hand) return false;
    hand.release(this.#peer);
    return this.holding.delete(which);
  }
  #shareLoads() {
    const grips = [...this.holding.values()].filter((hand) => hand instanceof Grip);
    for (const grip of grips) grip.share(grips.filter(({held}) => held === grip.held).length, this.#peer);
  }
  #tellHands() {
    if (this.seen) this.members.sendAll(HAND, encodeHeadset(this.seen, this.holding));
    else if (this.hand) this.members.sendAll(HAND, encodePointer(this.hand));
  }
  peerStats() { return this.#peer.stats(); }
  /** Others' recent grips by mouse or finger. */
  *seenHands() {
    for (const member of this.members.here) {
      const hand = this.presence.pointer(member.id);
      if (hand) yield {member, ...hand};
    }
  }
  /** Others in headsets. */
  *seenPeople() {
    for (const member of this.members.here) {
      const person = this.presence.person(member.id);
      if (person) yield {member, ...person};
    }
  }
  /** The states at the picture's time, a step before session time (docs/render-loop.md). */
  get picture() {
    if (!this.running) return this.world.world.states;
    return this.world.between(this.clock.now() / STEP_MS - this.#step);
  }
}

/** Positive, 63 bits. */
function randomId() {
  const [id] = crypto.getRandomValues(new BigUint64Array(1));
  return id >> 1n | 1n;
}
