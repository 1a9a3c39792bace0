// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Worlds for the mock server: bodies that are pulled where they are held, at a peer at once and at
// the others after a delay. No physics worth the name.

const UNIT = 1.9e-5;  // m
const HZ = 60;
/** m/s, along x: a ball that goes at an even pace, so that one knows where it is at any time. */
export const PACE = 0.2;
/** m, where it is at time 0 */
export const PACE_START = -1.4;
const DELAYS = [0, 0.0035, 0.006, 0.0285, 0.0635, 0.1235];  // s, one way, by profile

const PART = {pose: [0, 0, 0, 0, 0, 0, 1]};
const SOLIDS = [
  ['box', {half_extents: [0.1, 0.1, 0.1]}], ['sphere', {radius: 0.1}],
  ['capsule', {radius: 0.06, half_height: 0.08}], ['cylinder', {radius: 0.09, half_height: 0.1}],
  ['cone', {radius: 0.1, half_height: 0.1}],
  ['mesh', {vertices: [[-0.1, -0.1, -0.1], [0.1, -0.1, -0.1], [0, 0.12, -0.1], [0, 0, 0.12]],
            triangles: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]}],
];

/** One body of each shape, a cube that is easy to hold, or many balls. */
function makeBodies(kind, count) {
  if (kind === 'balls') {
    return Array.from({length: count}, (_, i) => ({
      name: `ball/${i}`, turns: false, owner: null,
      start: [0.25 * (i % 10) - 1.1, 0.25 * (Math.floor(i / 10) % 10) - 1.1,
              0.15 + 0.25 * Math.floor(i / 100)],
      parts: [{shape: 'sphere', radius: 0.1, ...PART}]}));
  }
  const bodies = SOLIDS.map(([shape, size], i) => ({
    name: shape, turns: true, owner: null, start: [0.4 * (i - 2.5), 0.3, 0.12],
    parts: [{shape, ...size, ...PART}]}));
  bodies.push({name: 'cube', turns: true, owner: null, start: [0, -0.3, 0.15],
               parts: [{shape: 'box', half_extents: [0.15, 0.15, 0.15], ...PART}]});
  bodies.push({name: 'pace', turns: false, owner: null, start: [PACE_START, 0, 0.6],
               parts: [{shape: 'sphere', radius: 0.04, ...PART}]});
  bodies.push({name: 'hand', turns: false, owner: 1, start: [0.6, -0.4, 0.3],
               parts: [{shape: 'sphere', radius: 0.05, ...PART}]});
  return bodies;
}

/** The session of the mock server. */
export class MockWorld {
  /** @param {{scene?: string, balls?: number, live?: boolean, settings?: object}} options */
  constructor({scene = 'shapes', balls = 0, live = true, settings = {}} = {}) {
    this.scene = scene;
    this.live = live;
    this.bodies = makeBodies(balls ? 'balls' : 'shapes', balls);
    this.settings = {paused: false, speed: 1, profile: 3, influence: 0.08, predictor: 'replay',
                     scheme: 'one-pass', beside: null, ...settings};
    this.restart();
  }

  restart() {
    this.time = 0;
    this.number = 0;
    this.holds = [];  // {key, pane, body, offset, anchors: [{time, point}]}
    // Two peers, and the two of a run beside in which nobody hears of the other.
    this.peers = [0, 1, 2, 3].map(() => this.bodies.map((body) => ({
      position: [...body.start], quaternion: [0, 0, 0, 1], home: [...body.start]})));
  }

  hello() {
    const strip = ({start, ...body}) => body;
    return {
      type: 'hello', protocol: 2, scene: this.scene, live: this.live, position_unit: UNIT,
      peers: [false, true].flatMap((beside) => [{id: 1, hz: 60, engine: 'tandem', beside},
                                                {id: 2, hz: 72, engine: 'bullet', beside}]),
      bodies: this.bodies.map(strip), settings: this.settings,
      fixed: [{shape: 'half_space', normal: [0, 0, 1], offset: 0, ...PART},
              {shape: 'half_space', normal: [0, -1, 0], offset: -1.5, ...PART},
              {shape: 'box', half_extents: [0.3, 0.1, 0.05], pose: [-0.8, -0.5, 0.05, 0, 0, 0, 1]}],
      choices: !this.live ? {} : {
        profile: [0, 1, 2, 3, 4, 5], predictor: ['replay', 'euler'],
        scheme: ['one-pass', 'two-step', 'none'], speed: [0.05, 2], influence: [0, 0.5]},
    };
  }

  grab(key, {pane, body, point}) {
    const p = this.peers[pane][body].position;
    this.holds.push({key, pane, body, offset: point.map((v, i) => v - p[i]),
                     anchors: [{time: this.time, point}]});
  }
  move(key, point) {
    this.holds.find((hold) => hold.key === key)?.anchors.push({time: this.time, point});
  }
  release(keys) {
    for (const hold of this.holds.filter((h) => keys(h.key))) hold.over = this.time;
  }

  step() {
    this.time += 1 / HZ;
    ++this.number;
    const delay = DELAYS[this.settings.profile];
    this.peers.forEach((bodies, pane) => {
      for (const hold of this.holds) {
        const own = hold.pane % 2 === pane % 2;
        const seen = this.time - (own ? 0 : pane < 2 ? delay : Infinity);
        const anchor = hold.anchors.findLast(({time}) => time <= seen);
        const body = bodies[hold.body];
        if (anchor) body.home = anchor.point.map((v, i) => v - hold.offset[i]);
      }
      bodies.forEach((body, b) => {
        body.position = body.position.map((v, i) => v + 0.4 * (body.home[i] - v));
        if (this.scene === 'balls') body.position[2] += 0.002 * Math.sin(3 * this.time + b);
        if (this.bodies[b].name === 'pace') body.position[0] = PACE_START + PACE * this.time;
        if (this.bodies[b].turns && this.bodies[b].name !== 'cube') {
          const angle = 0.3 * Math.sin(this.time + b);
          body.quaternion = [0, 0, Math.sin(angle), Math.cos(angle)];
        }
      });
    });
    this.holds = this.holds.filter((hold) => hold.over === undefined ||
                                             this.time < hold.over + delay + 0.1);
  }

  /** @param {boolean} overlays @returns {object}  for encodeFrame, with a record of each body */
  frame(overlays) {
    const delay = DELAYS[this.settings.profile];
    const shown = this.peers.slice(0, this.settings.beside ? 4 : 2);
    const peers = shown.map((bodies, pane) => {
      const distances = bodies.map((body, b) => 500 * Math.hypot(
        ...body.position.map((v, i) => v - this.peers[pane ^ 1][b].position[i])));
      distances.sort((a, b) => a - b);
      return {
        stepMs: 0.4 + 0.2 * Math.sin(this.time) ** 2 + 0.3 * pane, latencyMs: 1000 * delay,
        divergenceP50Mm: distances[distances.length >> 1], divergenceMaxMm: distances.at(-1),
        bodies: bodies.map((body, b) => (
          {position: body.position, quaternion: this.bodies[b].turns ? body.quaternion : null})),
        springs: this.springs(bodies, pane), overlays: overlays ? this.overlays(bodies, pane) : null};
    });
    return {number: this.number, time: this.time, unit: UNIT, peers};
  }

  springs(bodies, pane) {
    return this.holds.filter((h) => h.over === undefined).map((hold) => ({
      body: hold.body, anchor: hold.anchors.at(-1).point,
      attachment: bodies[hold.body].position.map((v, i) => v + hold.offset[i]),
      user: hold.pane % 2 + (pane & 2), own: hold.pane % 2 === pane % 2}));
  }

  overlays(bodies, pane) {
    const pace = Math.max(0, this.bodies.findIndex(({name}) => name === 'pace'));
    return {
      contacts: [0, 1, 2, 3, 4, pace].map((body) => {
        const [x, y] = bodies[body].position;
        return {body, point: [x, y, 0], normal: [0, 0, 1], depth: 0.001};
      }),
      targets: bodies.slice(0, 3).map(({position}, body) => (
        {body, peer: pane ^ 1, position: [position[0] + 0.05, position[1], position[2] + 0.15]})),
      influence: bodies.map((_, b) => (b * 40) % 256)};
  }
}
