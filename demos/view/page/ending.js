// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The score so far or at the end, beside that of a second run.
import {lengthText, scoreText} from './words.js';

function row(document, cells, tag) {
  const line = document.createElement('tr');
  cells.forEach((text, i) => {
    const cell = document.createElement(i === 0 ? 'th' : tag);
    cell.textContent = text;
    line.append(cell);
  });
  return line;
}

/** The scores of a run's peers, merged if equal. */
function said(name, outcomes) {
  const texts = outcomes.filter((outcome) => name in outcome)
    .map((outcome) => scoreText(name, outcome[name]).text);
  return [...new Set(texts)].join(' / ') || '–';
}

/** The box over the worlds with the score. */
export class Ending {
  /**
   * @param {Document} document
   * @param {{again: function(), close: function()}} page
   */
  constructor(document, page) {
    this.document = document;
    this.byId = (id) => document.getElementById(id);
    this.byId('ending-again').addEventListener('click', () => {
      this.hide();
      page.again();
    });
    this.byId('ending-close').addEventListener('click', () => this.hide());
    this.byId('ending').addEventListener('keydown', (event) => {
      if (event.key === 'Escape') this.hide();
    });
  }

  get shown() { return !this.byId('ending').hidden; }
  hide() { this.byId('ending').hidden = true; }

  /**
   * @param {string} title
   * @param {string} text  below it
   * @param {string} button  label of the restart button; '': no button
   */
  open(title, text, button) {
    this.byId('ending-title').textContent = title;
    this.byId('ending-text').textContent = text;
    this.byId('ending-again').textContent = button;
    this.byId('ending-again').hidden = !button;
    this.byId('ending').hidden = false;
    this.byId(button ? 'ending-again' : 'ending-close').focus({preventScroll: true});
  }

  /**
   * @param {object[]} outcomes  of the server's score, of each pane
   * @param {{title: string, peers: number[], furthest: number}[]} runs  furthest: m, seen so far
   */
  fill(outcomes, runs) {
    const scores = runs.map(({peers}) => peers.map((p) => outcomes[p] ?? {}));
    const names = [...new Set(scores.flat().flatMap((outcome) => Object.keys(outcome)))]
      .filter((name) => scoreText(name, 0).name);
    const lines = names.map((name) => row(this.document, [
      scoreText(name, 0).name, ...scores.map((of) => said(name, of))], 'td'));
    if (runs.some(({furthest}) => Number.isFinite(furthest))) {
      lines.unshift(row(this.document, ['copies furthest apart',
                                        ...runs.map(({furthest}) => lengthText(furthest))], 'td'));
    }
    if (runs.length > 1) {
      lines.unshift(row(this.document, ['', ...runs.map(({title}) => title)], 'th'));
    }
    this.byId('ending-score').replaceChildren(...lines);
  }
}
