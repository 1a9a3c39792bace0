// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Assembles the page. ?pane=0 one peer alone, ?overlay=1 all in one pane, ?still=1 for pictures, ?marks=1 contacts,
// springs, targets and influence, ?theme=dark, ?look= (see camera.js).
import * as THREE from './three.module.min.js';
import {lookAt, Orbit, parseLook} from './camera.js';
import {Connection} from './connection.js';
import {Controls, ONE_WAY} from './controls.js';
import {Ending} from './ending.js';
import {extentOf} from './extent.js';
import {Fixed} from './fixed.js';
import {Input} from './input.js';
import {Keyboard} from './keyboard.js';
import {Overlays} from './overlays.js';
import {label, layOut} from './panes.js';
import {Plots} from './plots.js';
import {Bodies} from './scene.js';
import {Stage, THEMES} from './stage.js';
import {publish} from './state.js';
import {Timeline} from './timeline.js';
import {ALONE, lengthText, schemeName, sentenceOf} from './words.js';

const query = new URLSearchParams(location.search);
const on = (name) => query.has(name) && query.get(name) !== '0';
const only = query.has('pane') ? Number(query.get('pane')) : null;
const still = on('still');
const darkness = matchMedia('(prefers-color-scheme: dark)');
const byId = (id) => document.getElementById(id);

const page = {
  hello: null, bodies: null, fixed: null, overlays: null, panes: [], frame: null, settings: {},
  frames: 0, drawn: 0, connected: false, overlay: on('overlay'), marks: on('marks'),
  timeline: null, settled: true, dirty: true, messages: [], drawnAt: 0, next: 0, justDrew: false,
  runs: [], furthest: [], roundTrip: NaN, roundTrips: [], asked: false, over: false,
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
const connection = new Connection(socket.href, {hello, frame, text, state, roundTrip});
const send = (message) => connection.send(message);
const input = new Input(canvas, {panes: () => page.panes, bodies: () => page.bodies, orbit, send,
                                 redraw});
const home = () => {
  orbit.reset();
  redraw();
};
const controls = new Controls(document, {send, overlay, marks, home, score});
const ending = new Ending(document, {again});
new Keyboard(canvas, input, {
  panes: () => page.panes, bodies: () => page.bodies, orbit, redraw, names: freeBodies,
  say: (words) => { byId('spoken').textContent = words; }});

function theme() {
  const name = query.get('theme') ?? (darkness.matches ? 'dark' : 'light');
  document.documentElement.classList.toggle('dark', name === 'dark');
  const colours = THEMES[name] ?? THEMES.light;
  stage.paint(colours);
  page.fixed?.paint(colours);
  redraw();
  return colours;
}

/** Peers of the run, and of the second run if there is one now. */
function runsOf(peers) {
  const shown = page.frame ? page.frame.peers.length : peers.filter(({beside}) => !beside).length;
  return [false, true].map((which) => [...peers.keys()].filter(
    (p) => p < shown && Boolean(peers[p].beside) === which)).filter((run) => run.length);
}

function arrange() {
  const box = canvas.parentElement.getBoundingClientRect();
  stage.resize(Math.max(1, box.width), Math.max(1, box.height));
  const peers = page.hello?.peers ?? [];
  page.runs = runsOf(peers);
  page.panes = layOut(page.runs, only, page.overlay, stage.width, stage.height);
  label(byId('labels'), page.panes, peers, page.runs.length > 1 ? titles() : []);
  redraw();
}

const titles = () => [page.settings.scheme, page.settings.beside].slice(0, page.runs.length)
  .map((scheme) => schemeName(scheme ?? null));

function freeBodies() {
  return (page.hello?.bodies ?? []).flatMap(({name, owner}, body) => (
    owner === null || owner === undefined ? {name, body} : []));
}

function overlay(shown) {
  page.overlay = shown;
  controls.press('overlay', shown);
  arrange();
}

function marks(shown) {
  page.marks = shown;
  controls.press('marks', shown);
  byId('legend').hidden = !shown;
  send({type: 'want', overlays: shown});
}

function hello(message) {
  for (const old of [page.bodies, page.fixed, page.overlays]) {
    if (old) stage.scene.remove(old);
    old?.dispose();
  }
  // The view is reset only for a new scene: a reconnection keeps it.
  page.fresh = page.hello?.scene !== message.scene;
  Object.assign(page, {hello: message, frame: null, overlays: null, fixed: null, settled: false,
                       over: false});
  page.bodies = new Bodies(message);
  page.timeline = new Timeline(message.bodies.length);
  stage.scene.add(page.bodies);
  ending.hide();
  document.body.classList.toggle('alone', Boolean(message.alone));
  byId('sentence').textContent = message.alone ? ALONE : sentenceOf(message.scene);
  byId('scene').textContent = message.scene;
  document.title = `Tandem · ${message.scene}`;
  controls.enable(message.live, message.choices ?? {});
  text({type: 'settings', settings: message.settings});
  plots.clear();
  arrange();
  if (page.marks) marks(true);
  // The run may be over already.
  if (message.live) send({type: 'score'});
}

/** The first frame shows the extent of the scene. */
function setTheScene() {
  const box = extentOf(page.hello, page.frame.peers[0]);
  if (page.fresh) orbit.set(parseLook(query.get('look')) ?? lookAt(page.hello.scene, box));
  const size = Math.max(orbit.home.width, orbit.home.height);
  page.fixed = new Fixed(page.hello.fixed, page.hello.scene, size, THEMES.light);
  theme();
  page.overlays = new Overlays(page.hello.peers, Math.min(size, 4));
  stage.scene.add(page.fixed, page.overlays);
  stage.lightUp(new THREE.Vector3(...orbit.home.target), 0.75 * size);
}

function frame(next) {
  const last = page.frame;
  const again = !last || next.time < last.time;
  const others = !last || next.peers.length !== last.peers.length;
  page.frame = {...next};
  ++page.frames;
  if (again || others) {
    page.furthest = [NaN, NaN];
    page.over = false;
    if (last) input.letGo();
  }
  if (again && last && !page.asked) ending.hide();
  if (others) arrange();
  if (others) plots.clear();
  page.timeline.push(next, performance.now(), still || again);
  if (!page.fixed) setTheScene();
  page.settled = false;
  if (!still) plots.push(next);
  redraw();
}

function score() {
  page.asked = true;
  send({type: 'score'});
}

/** Restarts, or reconnects to a program that was unreachable. */
function again() {
  if (page.connected) send({type: 'restart'});
  else connection.again();
}

function tellScore(message) {
  if (!message.final && !page.asked) return;
  page.asked = false;
  page.over = message.final;
  ending.fill(message.outcomes, page.runs.map((peers, run) => (
    {title: titles()[run], peers, furthest: page.furthest[run]})));
  ending.open(message.final ? 'The run is over' : 'So far',
              `${message.time.toFixed(1)} s of the session.`, 'Again');
}

/** A busy page receives late: the recent minimum is the true round trip. */
function roundTrip(ms) {
  page.roundTrips = [...page.roundTrips.slice(-9), ms];
  page.roundTrip = Math.min(...page.roundTrips);
  tellFacts();
}

function tellFacts() {
  const {profile} = page.settings;
  const peers = Number.isInteger(profile) ? [`peers ${2 * ONE_WAY[profile]} ms`] : [];
  const here = Number.isFinite(page.roundTrip) ? [`this page ${page.roundTrip.toFixed(1)} ms`] : [];
  byId('facts').textContent = `There and back: ${[...peers, ...here].join(', ') || 'not known yet'}`;
}

function text(message) {
  if (message.type === 'settings') {
    page.settings = message.settings;
    controls.show(message.settings);
    tellFacts();
    arrange();
  } else if (message.type === 'score') {
    tellScore(message);
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
  byId('state').textContent = {
    open: page.hello?.live ? '' : 'network', lost: 'no connection, trying again',
    ended: 'the program has ended', dead: 'the program does not answer'}[name];
  byId('state').classList.toggle('lost', !page.connected);
  const start = 'Start it again in a terminal and open the address that it prints.';
  if (name === 'ended') {
    if (!page.over) byId('ending-score').replaceChildren();
    ending.open(page.over ? 'The run is over' : 'The program has ended', start, '');
  } else if (name === 'dead') {
    byId('ending-score').replaceChildren();
    ending.open('The program does not answer', `It may have been stopped. ${start}`, 'Try again');
  }
  redraw();
}

/** Distance between copies as drawn; over a network, the program's value. */
function tellApart() {
  page.runs.forEach((peers, run) => {
    let {distance, body} = Timeline.furthest(peers, page.bodies.shown);
    if (peers.length === 1) distance = 1e-3 * page.frame.peers[peers[0]].divergenceMaxMm;
    if (!(distance <= page.furthest[run])) page.furthest[run] = distance;
    const box = byId(`apart-${run}`);
    if (!box) return;
    const name = page.hello.bodies[body]?.name;
    box.textContent = Number.isFinite(distance)
      ? `furthest apart ${lengthText(distance)}${name ? ` (${name})` : ''} · most ` +
        `${lengthText(page.furthest[run])}` : '';
  });
}

function draw(now) {
  requestAnimationFrame(draw);
  input.flush();
  // A picture's cost shows in the delay of the next one.
  if (page.justDrew) page.next = now + stage.adapt(now - page.drawnAt);
  page.justDrew = false;
  if (!page.dirty || !page.bodies || !page.frame || now < page.next) return;
  page.drawnAt = now;
  page.justDrew = true;
  page.settled = page.timeline.advance(still ? Infinity : performance.now());
  page.bodies.move(page.timeline);
  page.dirty = !page.settled;
  page.overlays.update(page.timeline, page.bodies, input.grabs(), page.marks);
  for (const pane of page.panes) {
    page.bodies.show(pane.peers, page.overlay);
    page.overlays.show(pane.peers);
    const aspect = pane.width / pane.height;
    const camera = orbit.at(aspect);
    page.fixed.clearTheWay(camera, orbit.target, orbit.home.width);
    stage.draw(pane, camera, orbit.distance(aspect));
  }
  byId('clock').textContent = `${page.timeline.time.toFixed(1)} s`;
  tellApart();
  plots.draw(now, page.hello.peers);
  ++page.drawn;
}

publish(window, {page, connection, orbit, canvas, input});
darkness.addEventListener('change', theme);
new ResizeObserver(arrange).observe(canvas.parentElement);
canvas.addEventListener('pointerdown', () => byId('hint').classList.add('gone'));
controls.press('overlay', page.overlay);
controls.press('marks', page.marks);
byId('legend').hidden = !page.marks || still;
theme();
arrange();
requestAnimationFrame(draw);
