// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The controls around the picture: members and divergence, the link, the slider of latency.

const COMPLAIN_MS = 8000;

const $ = (id) => document.getElementById(id);

const millimetres = (m) => (m < 1e-4 ? '< 0.1 mm' : m < 0.1 ? `${(1000 * m).toFixed(1)} mm` : `${m.toFixed(2)} m`);

function element(tag, text, className = '') {
  const made = document.createElement(tag);
  made.textContent = text;
  made.className = className;
  return made;
}

export class Panel {
  /** @param {object} room @param {object} link @param {object} session @param {object} profile */
  constructor(room, link, session, profile) {
    Object.assign(this, {session, profile});
    $('title').textContent = room.title;
    $('say').textContent = room.say;
    document.title = `${room.title}: a room of Tandem`;
    for (const name of link.rooms) {
      const way = element('a', name, name === link.room ? 'now' : '');
      way.href = link.of(name);
      $('rooms').append(way);
    }
    $('link').value = link.share;
    $('invite').onclick = () => $('sheet').toggleAttribute('hidden');
    $('copy').onclick = async () => {
      $('link').select();
      // Browsers refuse the clipboard without TLS: the link is then selected, to be copied by hand.
      await navigator.clipboard?.writeText(link.share).catch(() => {});
      $('copy').textContent = navigator.clipboard ? 'Copied' : 'Selected';
    };
    $('delay').oninput = () => {
      session.members.delay = Number($('delay').value);
      $('delayed').textContent = `+${session.members.delay} ms each way`;
    };
    $('make').hidden = !room.make;
    this.show();
  }

  /** Shown for some seconds. */
  complain(text) {
    this.complaint = {text, until: performance.now() + COMPLAIN_MS};
    this.show();
  }
  show() {
    const {members, away, clock, apart} = this.session;
    const list = [this.#row(`${this.profile.name} (you)`, this.profile.colour, away ? 'away' : '')];
    for (const member of members.here) {
      const far = apart.get(member.id);
      const way = member.direct?.open ? 'direct' : 'relayed';
      const note = member.away ? 'away' : far ? `${way}, ${millimetres(far.most)} apart` : way;
      list.push(this.#row(member.name || 'somebody', member.colour, note));
    }
    $('people').replaceChildren(...list);
    const most = Math.max(-1, ...members.here.filter(({away: gone}) => !gone).map(({id}) => apart.get(id)?.most ?? -1));
    $('apart').textContent = most < 0 ? 'Nobody else is here yet: invite somebody.' : `Furthest apart: ${millimetres(most)}`;
    const complaint = this.complaint?.until > performance.now() ? this.complaint.text : '';
    const state = complaint ? complaint : away ? 'This page takes no part while it is not seen.' :
      members.strangers && members.here.length === 0 ?
        'Somebody is here whom this page cannot understand: the key after the # of its link is another one. ' +
        'Ask for the whole link.' :
      members.server.open ? '' : members.here.length > 0 ? 'The server is gone; you go on with each other.' :
        clock.known ? 'The server does not answer; trying again.' : 'Connecting …';
    $('state').textContent = state;
    $('state').hidden = state === '';
  }
  #row(name, colour, note) {
    const row = element('li', '');
    const dot = element('i', '');
    dot.style.background = colour;
    row.append(dot, element('b', name), element('span', note));
    return row;
  }
}

/** Shown instead of the room. */
export function fail(text) {
  $('state').textContent = text;
  $('state').hidden = false;
}
