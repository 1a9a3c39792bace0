// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The room in a headset, by WebXR: the user's position, both hands, and locomotion. Hands release in any doubt: a lost
// controller, a session that ends or is hidden.
import {nearest} from './nearest.js';
import {Stand, landing} from './stand.js';

const REACH = 0.1;        // m, from the palm
const PATIENCE_MS = 200;  // a hand unseen for longer is lost
const DELIBERATE_MS = 300;
const PUSHED = 0.7;       // fraction of a thumbstick's range
const BACK = 0.4;
const SNAP = Math.PI / 6;
const WALK = 0.7;         // m/s, while holding something
const SWING = Math.PI / 4;  // rad/s, while holding something
const MOST_PAUSE = 0.1;   // s
const DISPLAY_HZ = 72;    // requested: the least comfortable rate
const AWAY = 1.6;         // m, from the target of the room's camera
const APART = 0.6;        // rad, between users
const PLACES = 5;
const PRESSES = {selectstart: true, squeezestart: true, selectend: false, squeezeend: false};

/** State of one hand. */
class Side {
  constructor(side) {
    Object.assign(this, {side, source: null, pressed: new Set(), aims: false, since: 0, turned: false,
                         known: -Infinity});
  }
}

export class Headset {
  #sides = new Map(['left', 'right'].map((side) => [side, new Side(side)]));
  #session = null;  // XRSession
  #last = 0;        // ms, time of the last frame
  #placed = false;

  /** @param {object} drawing @param {object} session  of the room */
  constructor(drawing, session) {
    Object.assign(this, {drawing, session});
    this.stand = new Stand();
    this.onChange = () => {};  // the user starts or stops seeing the room
    this.seen = null;    // poses of head, left, right, world
    this.target = null;  // m, of the jump being aimed
  }
  get active() { return this.#session !== null; }
  /** True while the user sees the room. */
  get visible() { return this.active && this.#session.visibilityState !== 'hidden'; }

  /** For Marks. */
  person() {
    const hand = (side) => {
      const pose = this.seen[side];
      const grip = this.session.holding.get(side);
      return pose && {pose, held: grip?.held, attachment: grip?.attachment};
    };
    return {head: null, left: hand('left'), right: hand('right')};
  }

  /** Call after a click: browsers require that. */
  async enter() {
    if (this.active) return;
    const xr = await navigator.xr.requestSession('immersive-vr', {
      requiredFeatures: ['local-floor'], optionalFeatures: ['hand-tracking', 'layers'],
    });
    this.#session = xr;
    this.#placed = false;
    this.#last = 0;
    this.session.letGoOfAll();
    xr.addEventListener('end', () => this.#ended());
    xr.addEventListener('visibilitychange', () => {
      if (xr.visibilityState !== 'visible') this.#letGo();
      if (xr.visibilityState === 'hidden') this.#unsee();  // no more pictures for now
      this.onChange();
    });
    xr.addEventListener('inputsourceschange', ({removed}) => {
      for (const side of this.#sides.values()) if (removed.includes(side.source)) this.#lose(side);
    });
    for (const [type, pressed] of Object.entries(PRESSES)) {
      xr.addEventListener(type, ({inputSource}) => this.#press(inputSource, type.replace(/start|end/, ''), pressed));
    }
    const [rate] = [...xr.supportedFrameRates ?? []].filter((hz) => hz >= DISPLAY_HZ).sort((a, b) => a - b);
    if (rate) xr.updateTargetFrameRate(rate).catch(() => {});  // otherwise unchanged
    try {
      await this.drawing.enter(xr);
    } catch (problem) {
      await xr.end();
      throw problem;
    }
  }

  /** At the start of each picture. @param {number} now  ms @param {XRFrame} frame */
  track(now, frame) {
    const space = this.drawing.referenceSpace;
    const pause = Math.min(MOST_PAUSE, Math.max(0, (now - this.#last) / 1000));
    this.#last = now;
    const viewer = this.visible ? frame.getViewerPose(space) : null;
    if (viewer && !this.#placed) this.#place(viewer.transform);
    const poseIn = (place) => {
      const pose = place && frame.getPose(place, space);
      return pose && this.stand.pose(pose.transform);
    };
    for (const side of this.#sides.values()) {
      side.source = [...this.#session.inputSources].find(({handedness, gripSpace}) =>
        gripSpace && handedness === side.side) ?? null;
      if (side.source && viewer) this.#move(side, this.stand.pose(viewer.transform), pause);
    }
    // Only now, since a thumbstick may have moved them.
    this.seen = viewer && {head: this.stand.pose(viewer.transform)};
    this.target = null;
    for (const side of this.#sides.values()) {
      const pose = viewer && side.source && this.#palm(side.source, poseIn);
      if (pose) {
        side.known = now;
        this.seen[side.side] = pose;
      } else if (!side.source || now - side.known > PATIENCE_MS) {
        this.#lose(side);
      }
      const ray = pose && side.aims && poseIn(side.source.targetRaySpace);
      if (ray) this.target = landing(ray);
    }
    this.session.track(this.seen);
  }

  /** The point between thumb and finger of a tracked hand, or the controller's grip. */
  #palm(source, poseIn) {
    const grip = poseIn(source.gripSpace);
    const tips = ['thumb-tip', 'index-finger-tip'].map((joint) => poseIn(source.hand?.get(joint)));
    if (!grip || !tips[0] || !tips[1]) return grip ?? null;
    return {position: grip.position.map((_, i) => (tips[0].position[i] + tips[1].position[i]) / 2),
            orientation: grip.orientation};
  }
  #press(source, button, pressed) {
    const side = this.#sides.get(source.handedness);
    if (!side) return;
    const before = side.pressed.size;
    if (pressed) side.pressed.add(button);
    else side.pressed.delete(button);
    if (pressed && before === 0) this.#close(side, source);
    if (side.pressed.size === 0) this.#open(side, source);
  }
  #close(side, source) {
    const pose = this.seen?.[side.side];
    const held = pose && this.session.running && nearest(this.session.world.bodies, pose.position, REACH);
    if (held) {
      this.session.grip(side.side, held, pose);
      this.#pulse(source);
    } else if (source.hand) {
      side.aims = true;  // it has no thumbstick
      side.since = performance.now();
    }
  }
  #open(side, source) {
    this.session.letGo(side.side);
    if (!source.hand || !side.aims) return;
    if (performance.now() - side.since < DELIBERATE_MS) side.aims = false;  // a pinch that missed
    else this.#jump(side);
  }
  #lose(side) {
    side.pressed.clear();
    side.aims = false;
    this.session.letGo(side.side);
  }
  #letGo() { for (const side of this.#sides.values()) this.#lose(side); }
  #ended() {
    this.#letGo();
    this.#session = null;
    this.#unsee();
    this.drawing.leave();
    this.onChange();
  }
  #unsee() {
    this.seen = null;
    this.target = null;
    this.session.track(null);
  }
  #pulse({gamepad}) { gamepad?.hapticActuators?.[0]?.pulse?.(0.5, 30)?.catch?.(() => {}); }

  /** Thumbsticks: forward aims, and jumps on release; sideways turns. A user who holds something moves gently. */
  #move(side, head, pause) {
    const axes = side.source.gamepad?.axes ?? [];
    if (axes.length < 2) return;
    const [x, y] = axes.length >= 4 ? axes.slice(2) : axes;
    const holds = ['left', 'right'].some((one) => this.session.holding.has(one));
    if (holds) {
      side.aims = false;
      side.turned = true;
      if (Math.abs(x) > BACK) this.stand.turn(-x * SWING * pause, head.position);
      if (Math.abs(y) > BACK) this.#walk(-y * WALK * pause, head);
      return;
    }
    if (y < -PUSHED) side.aims = true;
    else if (side.aims && !side.source.hand && y > -BACK) this.#jump(side);
    if (Math.abs(x) < BACK) side.turned = false;
    if (Math.abs(x) < PUSHED || side.turned || side.aims) return;
    side.turned = true;
    this.stand.turn(-Math.sign(x) * SNAP, head.position);
  }
  #walk(way, head) {
    const [x, y] = [Math.sin(this.#heading(head)), Math.cos(this.#heading(head))];
    this.stand.jump([head.position[0] + way * x, head.position[1] + way * y], head.position);
  }
  /** rad from +y to the right: the head's horizontal direction. */
  #heading({orientation: [x, y, z, w]}) {
    // -z of the head in the world.
    return Math.atan2(-2 * (x * z + w * y), -2 * (y * z - w * x));
  }
  #jump(side) {
    side.aims = false;
    if (!this.target || !this.seen?.head) return;
    this.stand.jump(this.target, this.seen.head.position);
    this.target = null;
  }
  /** A place for each user around the target of the room's camera. */
  #place(viewer) {
    this.#placed = true;
    const {target, azimuth} = this.drawing.look;
    const angle = azimuth * Math.PI / 180 + APART * (Number(this.session.self % BigInt(PLACES)) - (PLACES - 1) / 2);
    this.face([target[0] + AWAY * Math.cos(angle), target[1] + AWAY * Math.sin(angle)], angle + Math.PI / 2, viewer);
  }
  /** Moves the user. @param {number} yaw  rad; 0 looks along +y @param {XRRigidTransform} viewer */
  face(place, yaw, viewer) {
    const head = () => this.stand.pose(viewer);
    const heading = -this.#heading(head());
    this.stand.turn(yaw - heading, head().position);
    this.stand.jump(place, head().position);
  }
}

/** Shows the button if there is a headset. Browsers offer one only to pages from loopback or by TLS. */
export async function offer(button, headset, complain) {
  const {xr} = navigator;
  if (!xr) return;
  const look = async () => { button.hidden = !await xr.isSessionSupported('immersive-vr').catch(() => false); };
  xr.addEventListener?.('devicechange', look);
  button.onclick = () => headset.enter().catch((problem) => complain(`The headset cannot be used: ${problem.message}`));
  await look();
}
