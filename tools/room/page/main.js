// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
import {init} from './tandem.js';
import {initCipher} from './cipher.js';
import {Headset, offer} from './headset.js';
import {readLink} from './link.js';
import {Panel, fail} from './panel.js';
import {listen} from './pointer.js';
import {drawQr} from './qr.js';
import {offerRecording} from './recorder.js';
import {Session} from './session.js';

const COLOURS = ['#c8553d', '#3f78b5', '#5a9367', '#8d6cab', '#b8862b', '#2f8f9d', '#b0486f', '#5d6d7e'];
const NAMES = ['Ada', 'Ben', 'Cleo', 'Dev', 'Eli', 'Fay', 'Gus', 'Hana', 'Ivo', 'June', 'Kit', 'Lou', 'Max', 'Nia'];
const SHOW_MS = 250;
const STEP_EVERY_MS = 4;
const GREET_MS = 300;
const MADE = {
  box: () => ({type: 'box', halfExtents: [0.1, 0.1, 0.1]}),
  ball: () => ({type: 'sphere', radius: 0.1}),
  plank: () => ({type: 'box', halfExtents: [0.35, 0.08, 0.025]}),
};

const one = (list) => list[crypto.getRandomValues(new Uint32Array(1))[0] % list.length];

function ownProfile() {
  const query = new URLSearchParams(location.search);
  return {name: (query.get('name') || one(NAMES)).slice(0, 24), colour: one(COLOURS)};
}

async function start() {
  // With three.js, half of the page: the session does not wait for it.
  const drawings = import('./drawing.js');
  drawings.catch(() => {});  // reported below
  const link = readLink();
  const [room] = await Promise.all([
    fetch(`room-${link.room}.json`).then((answer) => answer.json()),
    init(),
    fetch('cipher.wasm').then((answer) => answer.arrayBuffer()).then(initCipher),
  ]);
  const profile = ownProfile();
  let panel = null;
  let headset = null;
  const session = new Session(room, link, profile, () => panel?.show());
  // Not by pictures, which are slow on some machines: each step is sent at its time.
  setInterval(() => session.advance(), STEP_EVERY_MS);
  // For tests and debugging.
  window.tandemRoom = {session, link};
  // A browser may call the page hidden while a headset shows it.
  const see = () => (document.hidden && !headset?.visible ? session.leave() : session.comeBack());
  document.addEventListener('visibilitychange', see);
  see();
  window.addEventListener('pagehide', () => session.end());
  window.addEventListener('pageshow', ({persisted}) => persisted && location.reload());
  window.addEventListener('hashchange', () => location.reload());

  const {Drawing} = await drawings;
  // The first picture blocks the page for long with software rendering: greet the others first.
  const end = performance.now() + GREET_MS;
  while (performance.now() < end && !session.greeted) await new Promise((resolve) => setTimeout(resolve, STEP_EVERY_MS));
  const canvas = document.getElementById('picture');
  const drawing = new Drawing(canvas, room.camera);
  session.world.bodies.forEach(({body, def}) => drawing.add(body.row, def));
  session.onMade = ({body, def}) => drawing.add(body.row, def);
  panel = new Panel(room, link, session, profile);
  drawQr(document.getElementById('code'), link.share);
  listen(canvas, drawing, session);
  offerRecording(session, link.room);
  for (const button of document.querySelectorAll('[data-make]')) {
    button.onclick = () => {
      const [x, y] = drawing.look.target;
      const aside = () => 0.3 * (Math.random() - 0.5);
      session.make(MADE[button.dataset.make](), [x + aside(), y + aside(), 1.2]);
    };
  }

  headset = new Headset(drawing, session);
  headset.onChange = see;
  offer(document.getElementById('headset'), headset, (problem) => panel.complain(problem));
  const people = function* people() {
    const {hand} = session;
    if (hand) yield {key: 'own', ...profile, anchor: hand.anchor, attachment: hand.attachment, held: hand.held};
    if (headset.seen) yield {key: 'own hands', ...profile, own: true, person: headset.person()};
    for (const {member, ...person} of session.seenPeople()) {
      yield {key: member.id, name: member.name, colour: member.colour, person};
    }
    for (const {member, ...seen} of session.seenHands()) {
      yield {key: member.id, name: member.name, colour: member.colour, ...seen};
    }
  };
  let shown = 0;
  drawing.loop((_, frame) => {
    const now = performance.now();
    if (frame) {
      // Steps before the picture, which may take long.
      headset.track(now, frame);
      session.advance();
      const {stand, target} = headset;
      drawing.drawHeadset(session.picture, people(), {frame, stand, target, now, late: session.late});
    } else {
      if (headset.active || !drawing.due(now, session.late)) return;
      drawing.draw(session.world.world.states, people());
    }
    if (now - shown < SHOW_MS) return;
    shown = now;
    panel.show();
  });
  Object.assign(window.tandemRoom, {drawing, headset});
}

start().catch((problem) => {
  fail(problem.message);
  throw problem;
});
