// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Tandem in JavaScript: classes over tandem/c/tandem.h. Units are m, kg, s, N and rad; vectors are arrays
// [x, y, z], quaternions [x, y, z, w]. Wrong arguments throw an Error that names field, value and
// rule.
import * as layouts from './layout.js';

/** Numbers of one body in World.states: position 3, orientation 4, linear and angular velocity 3 each. */
export const STATE = 13;
const RESULT_TOO_SMALL = 3;
const ERROR_SIZE = 260;
const BODY_TYPES = ['static', 'kinematic', 'dynamic'];
const SHAPES = ['sphere', 'box', 'capsule', 'cylinder', 'cone', 'halfSpace', 'hull', 'mesh', 'heights'];
const JOINTS = ['fixed', 'ball', 'hinge', 'slider'];
const MOTORS = ['off', 'velocity', 'position'];
const LISTS = ['begun', 'ended', 'touching', 'sensorBegun', 'sensorEnded', 'inSensor'];

let c = null;  // the module's functions
let error = 0;  // a tandem_error
const transports = [];  // by the number that the module knows them by

const view = () => new DataView(c.memory.buffer);
const bytesAt = (at, size) => new Uint8Array(c.memory.buffer, at, size);

function textAt(at) {
  const all = new Uint8Array(c.memory.buffer, at);
  return new TextDecoder().decode(all.slice(0, all.indexOf(0)));
}

function check(result) {
  if (result !== 0) throw new Error(textAt(error + 4));
}

function made(pointer) {
  if (pointer === 0) throw new Error(textAt(error + 4));
  return pointer;
}

function choice(what, name, names) {
  const at = names.indexOf(name);
  if (at < 0) throw new Error(`${what} must be one of ${names.join(', ')}, is ${name}`);
  return at;
}

/** Lends memory during `use`: (allocate) => result, where allocate(size) gives zeros. */
function borrow(use) {
  const lent = [];
  try {
    return use((size) => {
      const at = made(c.malloc(Math.max(size, 1)));
      lent.push(at);
      bytesAt(at, size).fill(0);
      return at;
    });
  } finally {
    lent.forEach((at) => c.free(at));
  }
}

/** A struct in lent memory, with these values. */
function put(allocate, layout, values) {
  const at = allocate(layout.size);
  layouts.write(view(), at, layout, values);
  return at;
}

const vec = (allocate, value) => put(allocate, layouts.vec3, {value});

function numbers(allocate, values, Type) {
  const flat = Type.from(Array.isArray(values[0]) ? values.flat() : values);
  const at = allocate(flat.byteLength);
  bytesAt(at, flat.byteLength).set(new Uint8Array(flat.buffer));
  return at;
}

function shapeValues(allocate, {type, points, triangles, heights, ...sizes}) {
  const values = {kind: choice('shape.type', type, SHAPES), ...sizes};
  const count = (list) => (Array.isArray(list[0]) ? list.length : list.length / 3);
  if (points) Object.assign(values, {points: numbers(allocate, points, Float64Array), pointCount: count(points)});
  if (triangles) {
    Object.assign(values, {triangles: numbers(allocate, triangles, Uint32Array), triangleCount: count(triangles)});
  }
  if (heights) values.heights = numbers(allocate, heights, Float64Array);
  return values;
}

const imports = {
  post: (user, to, at, size, delivery) =>
    transports[user].post(BigInt.asUintN(64, to), bytesAt(at, size).slice(), delivery === 1),
  drain: (user, inbox) => {
    for (const {from, bytes} of transports[user].take()) {
      borrow((allocate) => c.tandem_web_receive(inbox, from, numbers(allocate, bytes, Uint8Array), bytes.length));
    }
  },
  peers: (user, list) => {
    const all = [...transports[user].peers].sort((l, r) => (l[0] < r[0] ? -1 : 1));
    for (const [peer, connected] of all) c.tandem_web_list(list, peer, connected ? 1 : 0);
  },
  drop: (user, peer, reason) => transports[user].onDrop?.(BigInt.asUintN(64, peer), textAt(reason)),
};

/** Whatever the C++ library asks of a system: nothing that the engine does needs an answer. */
const system = {get: (_, name) => {
  if (name === 'proc_exit') return () => { throw new Error('tandem: aborted'); };
  // A write that takes nothing would be retried endlessly: EBADF, there is no such file.
  return () => (name === 'fd_write' ? 8 : 0);
}};

/** Node has no fetch for files. Bundlers for pages are not to look for its module. */
async function load(url) {
  const place = new URL(url, import.meta.url);
  if (place.protocol !== 'file:' || !globalThis.process?.versions?.node) return fetch(url);
  const files = 'node:fs/promises';
  return (await import(/* @vite-ignore */ files)).readFile(place);
}

/**
 * Loads the module; once, before anything else.
 * @param source  its bytes, a Response or a URL; by default tandem.wasm beside this file
 */
export async function init(source = new URL('./tandem.wasm', import.meta.url)) {
  if (c !== null) return;
  const given = source instanceof URL || typeof source === 'string' ? await load(source) : source;
  const needs = {tandem: imports, env: new Proxy({}, system), wasi_snapshot_preview1: new Proxy({}, system)};
  // Compiled while it comes, where the server says what it is.
  const streams = given instanceof Response && given.headers.get('content-type') === 'application/wasm';
  const {instance} = streams ? await WebAssembly.instantiateStreaming(given, needs) :
    await WebAssembly.instantiate(given instanceof Response ? await given.arrayBuffer() : given, needs);
  c = instance.exports;
  c._initialize?.();
  error = c.malloc(ERROR_SIZE);
}

/** A body of a World. Its state is of the last step, or of when it was last set. */
export class Body {
  constructor(world, at, index, generation) {
    Object.assign(this, {world, at, index, generation, row: 0, colliders: []});
  }
  get state() { return this.world.states.subarray(this.row * STATE, (this.row + 1) * STATE); }
  /** Position of the centre of mass. */
  get position() { return this.state.subarray(0, 3); }
  get orientation() { return this.state.subarray(3, 7); }
  get linearVelocity() { return this.state.subarray(7, 10); }
  get angularVelocity() { return this.state.subarray(10, 13); }
  get awake() { return c.tandem_body_awake(this.world.at, this.at) !== 0; }

  setPose(position, orientation = [0, 0, 0, 1]) {
    this.#give(c.tandem_body_set_pose, layouts.pose, {position, orientation});
  }
  setVelocity(linear, angular = [0, 0, 0]) { this.#give(c.tandem_body_set_twist, layouts.twist, {linear, angular}); }
  /** A kinematic body is there after the next step. */
  moveTo(position, orientation = [0, 0, 0, 1]) {
    this.#give(c.tandem_body_move_to, layouts.pose, {position, orientation});
  }
  /** N, during the next step, at a point of the world or at the centre of mass. */
  applyForce(force, point) { this.#push(c.tandem_body_apply_force, force, point); }
  /** N s, at once. */
  applyImpulse(impulse, point) { this.#push(c.tandem_body_apply_impulse, impulse, point); }
  applyTorque(torque) {
    borrow((a) => check(c.tandem_body_apply_torque(this.world.at, this.at, vec(a, torque), error)));
  }

  #give(set, layout, values) {
    borrow((a) => check(set(this.world.at, this.at, put(a, layout, values), error)));
    this.world.refresh();
  }
  #push(apply, value, point) {
    borrow((a) => check(apply(this.world.at, this.at, vec(a, value), point ? vec(a, point) : 0, error)));
    this.world.refresh();
  }
}

/** Bodies, shapes, joints, and the solver that steps them. */
export class World {
  #room = 0;  // bodies that the two arrays hold
  #handles = 0;
  #states = 0;
  #array = new Float64Array(0);

  /** @param def  gravity, substeps, sleepAfter, events; see tandem_world_def */
  constructor({events = false, ...def} = {}) {
    this.bodies = [];
    this.at = borrow((a) => {
      const at = a(layouts.worldDef.size);
      c.tandem_world_def_init(at);
      layouts.write(view(), at, layouts.worldDef, {events: events ? 1 : 0, ...def});
      return made(c.tandem_world_create(at, error));
    });
  }
  /** Gives its memory back; after that, neither it nor what belongs to it may be used. */
  free() {
    for (const body of this.bodies) c.free(body.at);
    c.tandem_world_destroy(this.at);
    c.free(this.#handles);
    c.free(this.#states);
  }

  /**
   * @param def  type ('dynamic'), position and orientation (of the shape's frame), linear, angular, mass or
   *             density (1000 kg/m^3), gravityScale, linearDamping, angularDamping, bullet, canSleep, and of the
   *             collider what addCollider() takes
   */
  addBody({type = 'dynamic', shape, mass, density = 1000, position = [0, 0, 0], orientation = [0, 0, 0, 1],
           bullet = false, canSleep = true, linear, angular, inertia, gravityScale, linearDamping, angularDamping,
           ...surface} = {}) {
    return borrow((a) => {
      let own = {mass, inertia};
      let centre = [0, 0, 0];
      if (shape && type === 'dynamic') {
        const solid = shapeMass(shape, density);
        const scale = mass === undefined ? 1 : mass / solid.mass;
        own = {mass: solid.mass * scale, inertia: inertia ?? solid.inertia.map((x) => x * scale)};
        centre = solid.centreOfMass;
      }
      const def = a(layouts.bodyDef.size);
      c.tandem_body_def_init(def);
      const middle = rotate(orientation, centre).map((x, i) => x + position[i]);
      layouts.write(view(), def, layouts.bodyDef, {
        type: choice('type', type, BODY_TYPES), position: middle, orientation, linear, angular, ...own, gravityScale,
        linearDamping, angularDamping, bullet: bullet ? 1 : 0, canSleep: canSleep ? 1 : 0,
      });
      const at = made(c.malloc(layouts.handle.size));
      const result = c.tandem_body_add(this.at, def, at, error);
      if (result !== 0) c.free(at);
      check(result);
      const {index, generation} = layouts.read(view(), at, layouts.handle);
      const body = new Body(this, at, index, generation);
      body.row = this.bodies.push(body) - 1;
      this.#reserve();
      try {
        if (shape) this.addCollider(body, {shape, position: centre.map((x) => -x), ...surface});
      } catch (problem) {
        this.removeBody(body);
        throw problem;
      }
      this.refresh();
      return body;
    });
  }
  /** With its colliders and joints. The last body gets its row in `states`. */
  removeBody(body) {
    check(c.tandem_body_remove(this.at, body.at, error));
    c.free(body.at);
    const last = this.bodies.pop();
    if (last !== body) {
      this.bodies[body.row] = last;
      last.row = body.row;
    }
    this.#reserve();
    this.refresh();
  }
  /**
   * @param def  shape, position, orientation (in the body's frame), friction, restitution, category, mask, group,
   *             sensor; see tandem_collider_def
   */
  addCollider(body, {shape, sensor = false, ...values}) {
    return borrow((a) => {
      const def = a(layouts.colliderDef.size);
      c.tandem_collider_def_init(def, choice('shape.type', shape.type, SHAPES));
      layouts.write(view(), def, layouts.colliderDef, {
        index: body.index, generation: body.generation, ...shapeValues(a, shape), sensor: sensor ? 1 : 0, ...values,
      });
      const at = a(layouts.handle.size);
      check(c.tandem_collider_add(this.at, def, at, error));
      const collider = layouts.read(view(), at, layouts.handle);
      body.colliders.push(collider);
      return collider;
    });
  }
  removeCollider(collider) {
    borrow((a) => check(c.tandem_collider_remove(this.at, put(a, layouts.handle, collider), error)));
  }
  /** @param def  a (a body, or nothing: the world), b, anchor, axis, limited, lower, upper, ...: tandem_joint_def */
  addJoint(type, {a, b, motor = 'off', limited = false, ...values}) {
    return borrow((allocate) => {
      const def = allocate(layouts.jointDef.size);
      c.tandem_joint_def_init(def, choice('type', type, JOINTS));
      layouts.write(view(), def, layouts.jointDef, {
        a: a ? [a.index, a.generation] : [0xffffffff, 0], b: [b.index, b.generation], limited: limited ? 1 : 0,
        motor: choice('motor', motor, MOTORS), ...values,
      });
      const at = allocate(layouts.handle.size);
      check(c.tandem_joint_add(this.at, def, at, error));
      return layouts.read(view(), at, layouts.handle);
    });
  }
  removeJoint(joint) {
    borrow((a) => check(c.tandem_joint_remove(this.at, put(a, layouts.handle, joint), error)));
  }
  setMotor(joint, mode, target, maxForce = Infinity) {
    borrow((a) => check(c.tandem_joint_set_motor(this.at, put(a, layouts.handle, joint),
      choice('motor', mode, MOTORS), target, maxForce, error)));
  }
  /** As soft as a spring and a damper: N/m and N s/m, or N m/rad and N m s/rad. */
  setServo(joint, mode, target, stiffness, damping, maxForce = Infinity) {
    borrow((a) => check(c.tandem_joint_set_servo(this.at, put(a, layouts.handle, joint),
      choice('motor', mode, MOTORS), target, stiffness, damping, maxForce, error)));
  }
  /** rad or m of a hinge or a slider. */
  jointPosition(joint) {
    return borrow((a) => {
      const out = a(16);
      check(c.tandem_joint_position(this.at, put(a, layouts.handle, joint), out, out + 8, error));
      return {position: view().getFloat64(out, true), broken: view().getInt32(out + 8, true) !== 0};
    });
  }
  setGravity(gravity) { borrow((a) => check(c.tandem_world_set_gravity(this.at, vec(a, gravity), error))); }

  /** @param dt  s     @return how many bodies there are, are awake and are pulled by others, and if all is finite */
  step(dt) {
    const report = borrow((a) => {
      const at = a(layouts.stepReport.size);
      check(c.tandem_world_step(this.at, dt, at, error));
      return layouts.read(view(), at, layouts.stepReport);
    });
    this.refresh();
    return {...report, finite: report.finite !== 0};
  }
  /**
   * STATE numbers of each body, in the order of `bodies`: a view of the module's memory, of the last step. Ask for
   * it again after each step, as the memory moves where it grows.
   */
  get states() {
    if (this.#array.buffer !== c.memory.buffer || this.#array.length !== this.bodies.length * STATE) {
      this.#array = new Float64Array(c.memory.buffer, this.#states, this.bodies.length * STATE);
    }
    return this.#array;
  }
  /** Reads all states, in one call. Steps and setters do. */
  refresh() {
    if (this.bodies.length === 0) return;
    check(c.tandem_body_states(this.at, this.#handles, this.bodies.length, this.#states, error));
  }
  /** Equal bits, equal hash. */
  hash() { return BigInt.asUintN(64, c.tandem_world_hash(this.at)); }
  /** Everything that the next step depends on. */
  snapshot() {
    return borrow((a) => {
      const size = a(4);
      if (c.tandem_world_snapshot(this.at, 0, size, error) !== RESULT_TOO_SMALL) throw new Error(textAt(error + 4));
      const room = view().getUint32(size, true);
      const buffer = a(room);
      check(c.tandem_world_snapshot(this.at, buffer, size, error));
      return bytesAt(buffer, room).slice();
    });
  }
  /** Restores a snapshot of a world that was built the same way. */
  restore(bytes) {
    borrow((a) => check(c.tandem_world_restore(this.at, numbers(a, bytes, Uint8Array), bytes.length, error)));
    this.refresh();
  }
  /** Contacts of the last step as pairs of bodies. @param list  begun, ended, touching, sensorBegun, ... */
  contacts(list = 'touching') {
    const which = choice('list', list, LISTS);
    return this.#list(32, (at, room) => c.tandem_world_contacts(this.at, which, at, room),
      (at) => ({a: this.#bodyAt(at + 16), b: this.#bodyAt(at + 24)}));
  }
  /** Blows of the last step above 1 m/s. */
  hits() {
    return this.#list(layouts.hit.size, (at, room) => c.tandem_world_hits(this.at, at, room), (at) => {
      const {point, normal, speed, impulse} = layouts.read(view(), at, layouts.hit);
      return {a: this.#bodyAt(at + 16), b: this.#bodyAt(at + 24), point, normal, speed, impulse};
    });
  }

  #list(size, copy, make) {
    return borrow((a) => {
      const count = copy(0, 0);
      const at = a(count * size);
      copy(at, count);
      return Array.from({length: count}, (_, i) => make(at + i * size));
    });
  }
  #bodyAt(at) {
    const index = view().getUint32(at, true);
    return this.bodies.find((body) => body.index === index);
  }
  /** The handles side by side, and room for as many states. */
  #reserve() {
    if (this.bodies.length > this.#room) {
      this.#room = 2 * this.bodies.length;
      c.free(this.#handles);
      c.free(this.#states);
      this.#handles = made(c.malloc(this.#room * layouts.handle.size));
      this.#states = made(c.malloc(this.#room * STATE * 8));
      this.#array = new Float64Array(0);
    }
    const handles = new Uint32Array(c.memory.buffer, this.#handles, 2 * this.bodies.length);
    this.bodies.forEach((body, i) => handles.set([body.index, body.generation], 2 * i));
  }
}

function rotate([x, y, z, w], v) {
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const t = cross([x, y, z], v).map((k) => 2 * k);
  const u = cross([x, y, z], t);
  return v.map((k, i) => k + w * t[i] + u[i]);
}

/** Mass, centre of mass and inertia (about it, row by row) of a shape of this density (kg/m^3). */
export function shapeMass(shape, density = 1000) {
  return borrow((a) => {
    const at = put(a, layouts.shape, shapeValues(a, shape));
    const out = a(layouts.mass.size);
    check(c.tandem_shape_mass(at, density, out, error));
    return layouts.read(view(), out, layouts.mass);
  });
}

/** Bytes that wait for a page that takes no steps, a hidden one for instance; beyond that the oldest go. */
const MAX_INBOX = 1 << 24;

/**
 * Carries bytes between peers, by whatever the page has: give `send`, call receive() and connected().
 * @param self  this peer, a BigInt above 0, unique in the session
 * @param send  (to, bytes, reliable): false where they were not taken; must not wait
 */
export class Transport {
  constructor({self, send, onDrop, maxPacket = 0}) {
    Object.assign(this, {self, send, onDrop, inbox: [], inboxBytes: 0, lost: 0, failure: null, peers: new Map()});
    this.number = transports.push(this) - 1;
    this.at = made(c.tandem_web_transport_create(this.number, self, maxPacket, error));
  }
  /** Bytes have come. */
  receive(from, bytes) {
    this.inbox.push({from, bytes});
    this.inboxBytes += bytes.length;
    let gone = 0;
    while (this.inboxBytes > MAX_INBOX) this.inboxBytes -= this.inbox[gone++].bytes.length;
    if (gone > 0) this.inbox.splice(0, gone);
    this.lost += gone;
  }
  /** Received packets, each once. */
  take() {
    this.inboxBytes = 0;
    return this.inbox.splice(0);
  }
  /** An exception of `send` must not pass through the module: it is thrown later. */
  post(to, bytes, reliable) {
    try {
      return this.send(to, bytes, reliable) === false ? 0 : 1;
    } catch (error) {
      this.failure ??= error;
      return 0;
    }
  }
  /** There is such a peer, or no longer. */
  connected(peer, is = true) { this.peers.set(peer, is); }
  /** After its peer. */
  free() {
    c.tandem_transport_destroy(this.at);
    delete transports[this.number];
  }
}

/** The id that belongs to a name; the same on every machine. */
export function sharedId(name) {
  return borrow((a) => {
    const text = new TextEncoder().encode(`${name}\0`);
    const out = a(layouts.sharedId.size);
    c.tandem_shared_id_of(out, numbers(a, text, Uint8Array));
    return layouts.read(view(), out, layouts.sharedId);
  });
}

/** One participant: shares bodies of a world with those of the other peers. Times are ns, BigInt, above 0. */
export class Peer {
  constructor(world, transport, def = {}) {
    this.world = world;
    this.at = borrow((a) => {
      const at = a(layouts.peerDef.size);
      c.tandem_peer_def_init(at);
      layouts.write(view(), at, layouts.peerDef, {...def, compact: def.compact ? 1 : 0});
      return made(c.tandem_peer_create(world.at, transport.at, at, error));
    });
    this.transport = transport;
  }
  /** Before its world and its transport. */
  free() { c.tandem_peer_destroy(this.at); }
  share(name, body, owner = 0n) {
    borrow((a) => check(c.tandem_peer_share(this.at, this.#id(a, name), body.at, owner, error)));
  }
  unshare(name) { borrow((a) => check(c.tandem_peer_unshare(this.at, this.#id(a, name), error))); }
  beforeStep(now) { this.#passing(c.tandem_peer_before_step(this.at, now, error)); }
  afterStep(now) { this.#passing(c.tandem_peer_after_step(this.at, now, error)); }
  leave(now) { this.#passing(c.tandem_peer_leave(this.at, now, error)); }
  /** Holds a shared body with a spring that all peers simulate. @param def  attachment, anchor, stiffness, ... */
  grab(name, def = {}) {
    return borrow((a) => {
      const at = a(layouts.grabDef.size);
      c.tandem_grab_def_init(at);
      layouts.write(view(), at, layouts.grabDef, {...sharedId(name), ...def});
      const out = a(4);
      check(c.tandem_peer_grab(this.at, at, out, error));
      return view().getUint32(out, true);
    });
  }
  move(grab, anchor, now) { borrow((a) => check(c.tandem_peer_move(this.at, grab, vec(a, anchor), now, error))); }
  release(grab) { check(c.tandem_peer_release(this.at, grab, error)); }
  stats() {
    return borrow((a) => {
      const at = a(layouts.peerStats.size);
      c.tandem_peer_get_stats(this.at, at);
      return layouts.read(view(), at, layouts.peerStats);
    });
  }

  /** Throws what the transport's `send` has thrown, once. */
  #passing(status) {
    check(status);
    const {failure} = this.transport;
    this.transport.failure = null;
    if (failure !== null) throw failure;
  }
  #id(allocate, name) { return put(allocate, layouts.sharedId, sharedId(name)); }
}
