// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Buttons and fields for a running session's settings and for drawing. They show the server's state: a requested change
// shows once it has happened.
import {schemeName} from './words.js';

/** ms, one way, by profile of the virtual link. */
export const ONE_WAY = [0, 3.5, 6, 28.5, 63.5, 123.5];
const FIELDS = ['profile', 'predictor', 'scheme', 'beside'];
const RANGES = ['speed', 'influence'];

/** Labels of choices. */
function optionText(name, value) {
  if (name === 'profile') return `${value} · ${ONE_WAY[value] ? `${ONE_WAY[value]} ms` : 'no delay'}`;
  if (name === 'scheme') return schemeName(value);
  if (name === 'beside') return schemeName(value || null);
  return String(value).replaceAll('-', ' ');
}

export class Controls {
  /**
   * @param {Document} document
   * @param {object} page  send(message), overlay(boolean), marks(boolean), home(), score()
   */
  constructor(document, page) {
    this.page = page;
    this.settings = {};
    this.byId = (id) => document.getElementById(id);
    this.on('pause', 'click', () => this.set('paused', !this.settings.paused));
    this.on('step', 'click', () => page.send({type: 'step'}));
    this.on('restart', 'click', () => page.send({type: 'restart'}));
    this.on('home', 'click', () => page.home());
    this.on('score', 'click', () => page.score());
    this.on('compare', 'click', () => this.set('beside', this.settings.beside ? null : 'none'));
    this.on('overlay', 'click', () => page.overlay(!this.pressed('overlay')));
    this.on('marks', 'click', () => page.marks(!this.pressed('marks')));
    this.on('more', 'click', () => this.open(this.byId('more').ariaExpanded !== 'true'));
    for (const name of FIELDS) {
      this.on(name, 'change', () => {
        const {value} = this.byId(name);
        this.set(name, name === 'profile' ? Number(value) : value || null);
      });
    }
    for (const name of RANGES) {
      this.on(name, 'input', () => this.set(name, this.value(name)));
    }
    document.addEventListener('keydown', (event) => this.key(event));
    this.enable(false, {});
  }

  on(id, event, handle) { this.byId(id).addEventListener(event, handle); }
  pressed(id) { return this.byId(id).getAttribute('aria-pressed') === 'true'; }
  /** @param {string} id  of a toggle button @param {boolean} down */
  press(id, down) { this.byId(id).setAttribute('aria-pressed', String(down)); }
  set(name, value) { this.page.send({type: 'set', name, value}); }

  /** A field's value; speed is on a scale of powers of ten. */
  value(name) {
    const value = this.byId(name).valueAsNumber;
    return name === 'speed' ? Number((10 ** value).toFixed(3)) : value;
  }

  /** Shows the controls that do not fit on a phone. @param {boolean} open */
  open(open) {
    this.byId('more').ariaExpanded = String(open);
    this.byId('panel').classList.toggle('open', open);
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    // Fields keep their own keys, and a focused button its space.
    if (/^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
    if (event.key === ' ' && event.target.tagName === 'BUTTON') return;
    const id = {' ': 'pause', '.': 'step', w: 'compare', o: 'overlay', c: 'marks', r: 'restart',
                0: 'home'}[event.key];
    if (!id || this.byId(id).disabled) return;
    event.preventDefault();
    this.byId(id).click();
  }

  /** @param {boolean} live  settings can be changed @param {object} choices  of hello */
  enable(live, choices) {
    this.live = live;
    this.byId('not-live').hidden = live;
    for (const id of ['pause', 'step', 'restart']) this.byId(id).disabled = !live;
    // One world alone has nothing to be compared with, and no score.
    for (const id of ['compare', 'score']) this.byId(id).disabled = !live || !choices.scheme;
    for (const name of FIELDS) {
      const field = this.byId(name);
      // The second run is chosen by its scheme; '' stands for none.
      const values = name === 'beside' && choices.scheme ? ['', ...choices.scheme]
                                                         : choices[name] ?? [];
      field.disabled = !live || values.length === 0;
      field.replaceChildren(...values.map((value) => new Option(optionText(name, value), value)));
    }
    for (const name of RANGES) {
      const field = this.byId(name);
      const range = choices[name];
      field.disabled = !live || !range;
      if (!range) continue;
      const [low, high] = name === 'speed' ? range.map(Math.log10) : range;
      Object.assign(field, {min: low, max: high, step: name === 'speed' ? 'any' : 0.01});
    }
  }

  /** @param {object} settings  of the server */
  show(settings) {
    this.settings = settings;
    const pause = this.byId('pause');
    pause.setAttribute('aria-label', settings.paused ? 'Run' : 'Pause');
    this.press('pause', settings.paused);
    this.byId('step').disabled = !this.live || !settings.paused;
    this.press('compare', Boolean(settings.beside));
    for (const name of FIELDS) {
      this.showChoice(name, name === 'beside' && this.live ? settings.beside ?? '' : settings[name]);
    }
    for (const name of RANGES) {
      if (settings[name] === undefined) continue;
      const field = this.byId(name);
      // Not while it is being dragged: an older value would overwrite it.
      if (!field.matches(':active')) {
        field.value = name === 'speed' ? Math.log10(settings[name]) : settings[name];
      }
      this.byId(`${name}-value`).textContent =
        name === 'speed' ? `${Number(settings.speed.toPrecision(2))}×`
                         : Number(settings[name].toPrecision(3));
    }
  }

  showChoice(name, value) {
    if (value === undefined) return;
    const field = this.byId(name);
    if (value === null) {
      field.replaceChildren(new Option(name === 'profile' ? 'a real network' : '–'));
      return;
    }
    // A value that cannot be chosen is still shown.
    if (![...field.options].some((option) => option.value === String(value))) {
      field.append(new Option(optionText(name, value), value));
    }
    field.value = value;
  }
}
