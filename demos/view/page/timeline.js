// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Interpolates between the last two frames by session time: a picture shows one instant for all peers, bodies and
// marks. Independent of the page. Lengths m, times s, world frame with z up, quaternions x y z w.

const LONGEST = 600;  // ms between two frames that are still joined: the server's interval at rest

function carried(point, from, to, body) {
  const {positions: p0, orientations: q0} = from;
  const {positions: p1, orientations: q1} = to;
  const v = [0, 1, 2].map((k) => point[k] - p0[3 * body + k]);
  const [x0, y0, z0, w0] = q0.subarray(4 * body, 4 * body + 4);
  const local = turned(v, [-x0, -y0, -z0, w0]);
  return turned(local, q1.subarray(4 * body, 4 * body + 4)).map((c, k) => c + p1[3 * body + k]);
}

/** Rotates a vector by a unit quaternion. */
function turned([vx, vy, vz], [x, y, z, w]) {
  const tx = 2 * (y * vz - z * vy);
  const ty = 2 * (z * vx - x * vz);
  const tz = 2 * (x * vy - y * vx);
  return [vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz,
          vz + w * tz + x * ty - y * tx];
}

const same = (a, b) => a.length === b.length && a.every((value, i) => value === b[i]);

const mix = (a, b, u) => a.map((v, k) => v + u * (b[k] - v));

/** Indexes marks of the earlier frame, to match those of the later one. */
function byKey(marks, key) {
  const found = new Map();
  const count = new Map();
  for (const mark of marks) {
    const name = key(mark);
    const nth = (count.get(name) ?? 0) + 1;
    count.set(name, nth);
    found.set(`${name}/${nth}`, mark);
  }
  return found;
}

/** A copy of one peer's part of a frame. */
class Kept {
  constructor(bodies) {
    this.positions = new Float32Array(3 * bodies);
    this.orientations = new Float32Array(4 * bodies);
    this.springs = [];
    this.overlays = null;
  }
  set(peer) {
    this.positions.set(peer.positions);
    this.orientations.set(peer.orientations);
    this.springs = peer.springs;
    this.overlays = peer.overlays;
  }
}

/** Keeps two frames and a playhead between them. */
export class Timeline {
  /** @param {number} bodies  number of bodies */
  constructor(bodies) {
    this.bodies = bodies;
    this.before = {time: NaN, peers: []};
    this.after = {time: NaN, peers: []};
    this.time = NaN;      // s, session time as shown
    this.arrival = 0;     // ms, of the last frame
    this.interval = 17;   // ms, mean between frames
    this.from = NaN;      // s, playhead at the arrival of the last frame
    this.rests = false;   // nothing moved in the last frame
  }

  /**
   * @param {import('./protocol.js').Frame} frame
   * @param {number} now    ms, of the page's clock
   * @param {boolean} jump  show it at once
   */
  push(frame, now, jump) {
    const {before, after} = this;
    const gap = now - this.arrival;
    const joined = !jump && frame.time >= after.time && frame.peers.length === after.peers.length;
    [this.before, this.after] = [after, before];
    this.after.time = frame.time;
    this.after.peers.length = Math.min(this.after.peers.length, frame.peers.length);
    frame.peers.forEach((peer, p) => (
      (this.after.peers[p] ??= new Kept(this.bodies)).set(peer)));
    if (!joined) {
      this.before = {time: frame.time, peers: this.after.peers.map((peer) => {
        const copy = new Kept(this.bodies);
        copy.set(peer);
        return copy;
      })};
      this.time = frame.time;
    }
    this.rests = joined && frame.peers.every((peer, p) => {
      const {positions, orientations} = this.before.peers[p];
      return !peer.overlays && peer.springs.length === 0 && same(positions, peer.positions) &&
        same(orientations, peer.orientations);
    });
    if (joined && !this.rests && gap < LONGEST) this.interval += 0.1 * (gap - this.interval);
    this.arrival = now;
    this.from = this.time = this.rests ? frame.time : Math.max(this.time, this.before.time);
  }

  /** @param {number} now  ms @returns {boolean}  true once the last frame is reached */
  advance(now) {
    const share = Math.min(1, Math.max(0, (now - this.arrival) / Math.max(1, this.interval)));
    this.time = this.from + share * (this.after.time - this.from);
    return share === 1 || this.rests;
  }

  /** 0..1, from the earlier frame to the later one. */
  get share() {
    const span = this.after.time - this.before.time;
    return span > 0 ? (this.time - this.before.time) / span : 1;
  }

  /**
   * Poses of a peer at the playhead.
   * @param {number} peer
   * @param {{positions: Float32Array, orientations: Float32Array}} out
   */
  poses(peer, out) {
    const u = this.share;
    const {positions: p0, orientations: q0} = this.before.peers[peer];
    const {positions: p1, orientations: q1} = this.after.peers[peer];
    for (let i = 0; i < p1.length; ++i) out.positions[i] = p0[i] + u * (p1[i] - p0[i]);
    for (let i = 0; i < q1.length; i += 4) {
      let dot = 0;
      for (let k = i; k < i + 4; ++k) dot += q0[k] * q1[k];
      const sign = dot < 0 ? -1 : 1;
      let length = 0;
      for (let k = i; k < i + 4; ++k) {
        out.orientations[k] = q0[k] + u * (sign * q1[k] - q0[k]);
        length += out.orientations[k] ** 2;
      }
      length = Math.sqrt(length);
      for (let k = i; k < i + 4; ++k) out.orientations[k] /= length;
    }
  }

  /**
   * Marks of a peer at the playhead. Points on a body move along with it; points in the world are
   * interpolated between both frames.
   * @param {number} peer
   * @param {{positions: Float32Array, orientations: Float32Array}} shown  poses at the playhead
   * @returns {{springs: object[], contacts: object[], targets: object[]}}  as in PeerFrame
   */
  marks(peer, shown) {
    const u = this.share;
    const before = this.before.peers[peer];
    const after = this.after.peers[peer];
    const along = (body, point) => carried(point, after, shown, body);
    const between = (marks, old, key, field) => {
      const earlier = byKey(old, key);
      return [...byKey(marks, key)].map(([name, mark]) => {
        const was = earlier.get(name);
        return {...mark, [field]: was ? mix(was[field], mark[field], u) : mark[field]};
      });
    };
    const springs = between(after.springs, before.springs, (s) => `${s.body}/${s.user}`, 'anchor')
      .map((s) => ({...s, attachment: along(s.body, s.attachment)}));
    if (!after.overlays) return {springs, contacts: [], targets: []};
    const contacts = after.overlays.contacts.map((c) => ({...c, point: along(c.body, c.point)}));
    const targets = between(after.overlays.targets, before.overlays?.targets ?? [],
                            (t) => `${t.body}/${t.peer}`, 'position');
    return {springs, contacts, targets};
  }

  /**
   * @param {number[]} peers  to compare
   * @param {{positions: Float32Array}[]} shown  of all peers, at the playhead
   * @returns {{distance: number, body: number}}  m: the largest distance between two copies
   */
  static furthest(peers, shown) {
    const result = {distance: NaN, body: -1};
    peers.forEach((a, i) => peers.slice(i + 1).forEach((b) => {
      const [p, q] = [shown[a].positions, shown[b].positions];
      for (let k = 0; k < p.length; k += 3) {
        const distance = Math.hypot(p[k] - q[k], p[k + 1] - q[k + 1], p[k + 2] - q[k + 2]);
        if (!(distance <= result.distance)) Object.assign(result, {distance, body: k / 3});
      }
    }));
    return result;
  }
}
