// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The page's texts about scenes, couplings and scores.

/** Where to look, by scene. */
const SENTENCES = {
  cubes: 'Two people on two machines pull cubes from stacks, then carry the plate together. Watch ' +
    'whether the stacks stand alike at both while the plate is in the air.',
  cliff: 'A thousand balls fall over a cliff, at each machine by itself. Watch where they come to ' +
    'rest: chaos drives two copies apart unless they agree.',
  room: 'Two people hand over a box, carry a bench and throw things. Watch the box while both hold ' +
    'it, and the bench between them.',
  tennis: 'Two people play table tennis over the network. Watch the ball near a racket: the other ' +
    'side hears of a hit only later.',
  piano: 'Two people carry a piano through a maze, one at each end. Watch the corners: both push, ' +
    'and neither owns it.',
  pile: 'Two people roll a big cube through 900 small ones. Watch the wake: everything touched must ' +
    'end at the same place for both.',
};

/** About a scene that one program runs alone. */
export const ALONE = 'The shapes that collide, in one world. Pull a body, or stop time and look around.';

/** @param {string} scene @returns {string} */
export function sentenceOf(scene) {
  return SENTENCES[scene] ??
    'The same world at each machine. Pull a body in one pane and watch it follow in the others.';
}

const SCHEMES = {
  'one-pass': 'Agreement', 'two-step': 'Two steps', 'two-step-paper': 'Two steps, as published',
  none: 'No agreement', 'single-owner': 'Single owner',
};

/** @param {?string} scheme @returns {string}  name of a coupling */
export function schemeName(scheme) {
  return scheme === null ? 'Nothing' : SCHEMES[scheme] ?? String(scheme).replaceAll('-', ' ');
}

/** @param {number} metres @returns {string} */
export function lengthText(metres) {
  if (!Number.isFinite(metres)) return '–';
  if (metres >= 1) return `${metres.toFixed(1)} m`;
  if (metres >= 0.01) return `${(100 * metres).toFixed(metres >= 0.1 ? 0 : 1)} cm`;
  return `${(1000 * metres).toFixed(metres >= 0.001 ? 1 : 2)} mm`;
}

/** Readable names of scores; '' hides one. */
const NAMES = {
  tunnelled: 'went through a racket', tunnelled_own: '', lost: 'balls lost',
  over_the_cliff: 'balls over the cliff', on_others: 'cubes on others', displaced: 'cubes moved',
  steepest: 'tilted by at most', deepest: 'deepest overlap', fastest: 'fastest',
};
const TRUTHS = new Set(['delivered', 'box_handed_over', 'hull_on_shelf']);
const UNITS = [['_m_s', 'm/s'], ['_deg', '°'], ['_m', 'm'], ['_s', 's']];

/**
 * @param {string} name  the program's name of a score: plate_lifted_m, a_tasks_done
 * @param {number} value
 * @returns {{name: string, text: string}}  name '': not shown
 */
export function scoreText(name, value) {
  const [, who, rest] = /^([a-z])_(.*)$/.exec(name) ?? [null, null, name];
  const [ending, unit] = UNITS.find(([end]) => rest.endsWith(end)) ?? ['', ''];
  const bare = rest.slice(0, rest.length - ending.length);
  const words = NAMES[bare] ?? bare.replaceAll('_', ' ');
  let text = '–';
  if (TRUTHS.has(rest)) text = value ? 'yes' : 'no';
  else if (unit === 'm' && value >= 0) text = lengthText(value);
  else if (Number.isFinite(value) && value >= 0) text = `${Number(value.toPrecision(3))} ${unit}`.trim();
  return {name: who && words ? `${who.toUpperCase()}: ${words}` : words, text};
}
