// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

/** m, m/s, N ... in the world unless said otherwise. */
export type Vector = [number, number, number] | Float64Array;
/** x, y, z, w, unit, body to world. */
export type Quaternion = [number, number, number, number] | Float64Array;
type Numbers = number[] | Float64Array;
type Points = Numbers | [number, number, number][];

/** Numbers of one body in World.states: position 3, orientation 4, linear and angular velocity 3 each. */
export const STATE: 13;

/** Loads the module; once, before anything else. `source`: by default tandem.wasm beside tandem.js. */
export function init(source?: BufferSource | Response | URL | string): Promise<void>;

export type Shape =
  | {type: 'sphere'; radius: number}
  | {type: 'box'; halfExtents: Vector}
  | {type: 'capsule' | 'cylinder' | 'cone'; radius: number; halfHeight: number}
  | {type: 'halfSpace'; normal?: Vector; offset?: number}
  | {type: 'hull'; points: Points}
  | {type: 'mesh'; points: Points; triangles: Points | Uint32Array}
  | {type: 'heights'; columns: number; rows: number; spacingX: number; spacingY: number; heights: Numbers};

export interface Mass {
  mass: number;  // kg
  centreOfMass: [number, number, number];  // m, frame of the shape
  inertia: number[];  // kg m^2, about it, row by row
}
/** @param density  kg/m^3 */
export function shapeMass(shape: Shape, density?: number): Mass;

export interface Surface {
  friction?: number;
  restitution?: number;  // 0 to 1
  category?: number;  // two meet where each one's category is in the other's mask
  mask?: number;
  group?: number;  // equal and > 0: always meet, equal and < 0: never
  sensor?: boolean;
}
export interface ColliderDef extends Surface {
  shape: Shape;
  position?: Vector;  // frame of the body
  orientation?: Quaternion;
}
export interface BodyDef extends Surface {
  type?: 'static' | 'kinematic' | 'dynamic';
  shape?: Shape;
  position?: Vector;  // of the shape's frame
  orientation?: Quaternion;
  linear?: Vector;
  angular?: Vector;
  density?: number;  // kg/m^3; 1000
  mass?: number;  // kg, whatever the density
  inertia?: number[];
  gravityScale?: number;
  linearDamping?: number;  // 1/s
  angularDamping?: number;
  bullet?: boolean;
  canSleep?: boolean;
}
export interface JointDef {
  a?: Body;  // the world, where there is none
  b: Body;
  anchor?: Vector;
  axis?: Vector;  // hinges and sliders; (1, 0, 0)
  compliance?: number;  // m/N
  limited?: boolean;
  lower?: number;  // rad or m
  upper?: number;
  motor?: Motor;
  motorTarget?: number;
  motorMaxForce?: number;
  breakForce?: number;  // N; 0 = never
  breakTorque?: number;
}
export type Motor = 'off' | 'velocity' | 'position';
export interface Handle { readonly index: number; readonly generation: number; }
export type ContactList = 'begun' | 'ended' | 'touching' | 'sensorBegun' | 'sensorEnded' | 'inSensor';
export interface Hit {
  a: Body;
  b: Body;
  point: number[];
  normal: number[];  // from a to b
  speed: number;  // m/s
  impulse: number;  // N s
}
export interface StepReport { finite: boolean; bodies: number; awake: number; targets: number; }

/** Its arrays are views of World.states: of the last step, not to be kept. */
export class Body {
  private constructor();
  readonly world: World;
  readonly row: number;  // in World.states and World.bodies; changes where another body is removed
  readonly colliders: Handle[];
  readonly state: Float64Array;
  readonly position: Float64Array;  // of the centre of mass
  readonly orientation: Float64Array;
  readonly linearVelocity: Float64Array;
  readonly angularVelocity: Float64Array;
  readonly awake: boolean;
  setPose(position: Vector, orientation?: Quaternion): void;
  setVelocity(linear: Vector, angular?: Vector): void;
  moveTo(position: Vector, orientation?: Quaternion): void;
  applyForce(force: Vector, point?: Vector): void;
  applyImpulse(impulse: Vector, point?: Vector): void;
  applyTorque(torque: Vector): void;
}

export class World {
  constructor(def?: {gravity?: Vector; substeps?: number; sleepAfter?: number; events?: boolean});
  readonly bodies: Body[];
  readonly states: Float64Array;
  free(): void;
  addBody(def?: BodyDef): Body;
  removeBody(body: Body): void;
  addCollider(body: Body, def: ColliderDef): Handle;
  removeCollider(collider: Handle): void;
  addJoint(type: 'fixed' | 'ball' | 'hinge' | 'slider', def: JointDef): Handle;
  removeJoint(joint: Handle): void;
  setMotor(joint: Handle, mode: Motor, target: number, maxForce?: number): void;
  jointPosition(joint: Handle): {position: number; broken: boolean};
  setGravity(gravity: Vector): void;
  step(dt: number): StepReport;
  refresh(): void;
  hash(): bigint;
  snapshot(): Uint8Array;
  restore(bytes: Uint8Array): void;
  contacts(list?: ContactList): {a: Body; b: Body}[];
  hits(): Hit[];
}

export interface TransportDef {
  self: bigint;  // this peer, above 0
  send(to: bigint, bytes: Uint8Array, reliable: boolean): boolean | unknown;  // false: not taken
  onDrop?(peer: bigint, reason: string): void;
  maxPacket?: number;  // bytes, 512 to 61440
}
export class Transport {
  constructor(def: TransportDef);
  readonly lost: number;  // what came and was not taken in time, 16 MiB at most
  receive(from: bigint, bytes: Uint8Array): void;
  connected(peer: bigint, is?: boolean): void;
  free(): void;
}

export interface GrabDef {
  attachment?: Vector;  // frame of the body
  anchor?: Vector;  // world: the hand
  stiffness?: number;  // N/m
  damping?: number;
  maxForce?: number;
}
export interface PeerDef {
  updateHz?: number;  // states sent each second; 60
  influence?: number;  // share of a difference that is closed per 1/60 s; 0.08
  authorityRamp?: number;  // s
  compact?: boolean;  // states are rounded and take less than a third of the bytes
  tolerance?: number;  // m: what others expect more exactly is not sent
  kbitPerS?: number;  // to each of the others
  replayBudget?: number;  // steps that may be replayed in each step to agree, at least 1; 4
}
export class Peer {
  constructor(world: World, transport: Transport, def?: PeerDef);
  free(): void;
  share(name: string, body: Body, owner?: bigint): void;
  unshare(name: string): void;
  beforeStep(now: bigint): void;
  afterStep(now: bigint): void;
  leave(now: bigint): void;
  grab(name: string, def?: GrabDef): number;
  move(grab: number, anchor: Vector, now: bigint): void;
  release(grab: number): void;
  stats(): Record<'updatesReceived' | 'packetsReceived' | 'packetsRejected' | 'bytesSent' | 'bodiesPlaced', bigint>;
}
export function sharedId(name: string): {high: bigint; low: bigint};
