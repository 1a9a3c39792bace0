// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Puts the page together. ?pane=0 one peer alone, ?overlay=1 all in one pane, ?still=1 for
// pictures, ?marks=1 contacts, springs, targets and influence, ?theme=dark, ?look= (see camera.js).
import * as THREE from './three.module.min.js';
import {lookAt, Orbit, parseLook} from './camera.js';
import {Connection} from './connection.js';
import {Controls} from './controls.js';
import {Fixed} from './fixed.js';
import {Input} from './input.js';
import {Overlays} from './overlays.js';
import {label, layOut} from './panes.js';
import {Plots} from './plots.js';
import {Bodies} from './scene.js';
import {Stage, THEMES} from './stage.js';
import {publish} from './state.js';

const query = new URLSearchParams(location.search);
const on = (name) => query.has(name) && query.get(name) !== '0';
const only = query.has('pane') ? Number(query.get('pane')) : null;
const still = on('still');
const darkness = matchMedia('(prefers-color-scheme: dark)');
const byId = (id) => document.getElementById(id);

/** What the page knows at this moment. */
const page = {
  hello: null, bodies: null, fixed: null, overlays: null, panes: [], frame: null, settings: {},
  frames: 0, drawn: 0, connected: false, overlay: on('overlay'), marks: on('marks'),
  arrival: 0, interval: 1000 / 60, settled: true, dirty: true, messages: [],
  drawnAt: 0, next: 0, justDrew: false,
};
document.body.classList.toggle('still', still);
const canvas = byId('view');
const stage = new Stage(canvas, {still});
const orbit = new Orbit();
const plots = new Plots(byId('plots'));
const redraw = () => { page.dirty = true; };

const socket = new URL('./socket', location.href);
socket.protocol = socket.protocol === 'https:' ? 'wss:' : 'ws:';
socket.search = '';
const connection = new Connection(socket.href, {hello, frame, text, state});
const send = (message) => connection.send(message);
const input = new Input(canvas, {panes: () => page.panes, bodies: () => page.bodies, orbit, send,
                                 redraw});
const home = () => {
  orbit.reset();
  redraw();
};
const controls = new Controls(document, {send, overlay, marks, home});

function theme() {
  const name = query.get('theme') ?? (darkness.matches ? 'dark' : 'light');
  document.documentElement.classList.toggle('dark', name === 'dark');
  const colours = THEMES[name] ?? THEMES.light;
  stage.paint(colours);
  page.fixed?.paint(colours);
  redraw();
  return colours;
}

function arrange() {
  const box = canvas.parentElement.getBoundingClientRect();
  stage.resize(Math.max(1, box.width), Math.max(1, box.height));
  const peers = page.hello?.peers ?? [];
  page.panes = layOut(peers.length, only, page.overlay, stage.width, stage.height);
  label(byId('labels'), page.panes, peers);
  redraw();
}

function overlay(shown) {
  page.overlay = shown;
  controls.press('overlay', shown);
  arrange();
}

function marks(shown) {
  page.marks = shown;
  controls.press('marks', shown);
  send({type: 'want', overlays: shown});
}

/** The bounds of what moves, m. */
function bounds() {
  const box = new THREE.Box3();
  const place = new THREE.Vector3();
  page.hello.bodies.forEach((_, b) => {
    box.expandByPoint(place.fromArray(page.frame.peers[0].positions, 3 * b));
  });
  return box;
}

function hello(message) {
  for (const old of [page.bodies, page.fixed, page.overlays]) {
    if (old) stage.scene.remove(old);
    old?.dispose();
  }
  // Looked at anew only where it is another scene: who is back sees what he saw.
  page.fresh = page.hello?.scene !== message.scene;
  Object.assign(page, {hello: message, frame: null, overlays: null, fixed: null, settled: false});
  page.bodies = new Bodies(message);
  stage.scene.add(page.bodies);
  byId('scene').textContent = message.scene;
  document.title = `Tandem · ${message.scene}`;
  controls.enable(message.live, message.choices ?? {});
  text({type: 'settings', settings: message.settings});
  plots.clear();
  arrange();
  if (page.marks) marks(true);
}

/** When the first frame is there, one knows how large all is. */
function setTheScene() {
  const box = bounds();
  if (page.fresh) orbit.set(parseLook(query.get('look')) ?? lookAt(page.hello.scene, box));
  const size = Math.max(orbit.home.width, orbit.home.height);
  page.fixed = new Fixed(page.hello.fixed, size, theme());
  page.overlays = new Overlays(page.hello.peers.length, Math.min(size, 4));
  stage.scene.add(page.fixed, page.overlays);
  stage.lightUp(new THREE.Vector3(...orbit.home.target), 0.75 * size);
}

function frame(next) {
  const now = performance.now();
  const last = page.frame;
  page.frame = next;
  ++page.frames;
  if (!page.fixed) setTheScene();
  // From where all is drawn now to the new frame, for as long as one took to come.
  if (last) page.interval += 0.1 * (Math.min(100, now - page.arrival) - page.interval);
  page.arrival = now;
  page.bodies.aim(next, still || !last || next.time < last.time);
  page.settled = false;
  if (!still) plots.push(next);
  redraw();
}

function text(message) {
  if (message.type === 'settings') {
    page.settings = message.settings;
    controls.show(message.settings);
  } else if (message.type === 'refused') {
    page.messages.push(message.text);
    const box = byId('message');
    box.textContent = message.text;
    box.hidden = false;
    clearTimeout(page.timer);
    page.timer = setTimeout(() => { box.hidden = true; }, 4000);
  }
}

function state(name) {
  page.connected = name === 'open';
  if (!page.connected) input.letGo();
  byId('state').textContent = page.connected ? (page.hello.live ? '' : 'network')
                                             : 'no connection, trying again';
  byId('state').classList.toggle('lost', !page.connected);
  redraw();
}

function draw(now) {
  requestAnimationFrame(draw);
  input.flush();
  // The next picture after one is late by what that one took.
  if (page.justDrew) page.next = now + stage.adapt(now - page.drawnAt);
  page.justDrew = false;
  if (!page.dirty || !page.bodies || !page.frame || now < page.next) return;
  page.drawnAt = now;
  page.justDrew = true;
  const t = still ? 1 : THREE.MathUtils.clamp((performance.now() - page.arrival) / page.interval,
                                              0, 1);
  if (!page.settled) page.bodies.move(t);
  page.settled = t === 1;
  page.dirty = !page.settled;
  page.overlays.update(page.frame, page.bodies, input.grabs());
  for (const pane of page.panes) {
    page.bodies.show(pane.peers, page.overlay);
    page.overlays.show(pane.peers);
    const aspect = pane.width / pane.height;
    const camera = orbit.at(aspect);
    page.fixed.clearTheWay(camera, orbit.target, orbit.home.width);
    stage.draw(pane, camera, orbit.distance(aspect));
  }
  byId('clock').textContent = `${page.frame.time.toFixed(1)} s`;
  plots.draw(now);
  ++page.drawn;
}

publish(window, {page, connection, orbit, canvas, input});
darkness.addEventListener('change', theme);
new ResizeObserver(arrange).observe(canvas.parentElement);
canvas.addEventListener('pointerdown', () => byId('hint').classList.add('gone'));
controls.press('overlay', page.overlay);
controls.press('marks', page.marks);
theme();
arrange();
requestAnimationFrame(draw);
