// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A WebRTC connection between two pages. The lower id offers; the signalling is sealed and goes through the room's
// server.

const PATIENCE_MS = 15000;

export class Direct {
  #connection = null;
  #newest = null;
  #reliable = null;
  #early = [];
  #timer = 0;

  /**
   * @param {boolean} offers
   * @param {{say: function(object), heard: function(Uint8Array), changed: function()}} listener
   */
  constructor(offers, listener, servers = []) {
    Object.assign(this, {offers, listener, servers});
    if (offers) this.#begin();
  }

  get open() { return this.#newest?.readyState === 'open' && this.#reliable?.readyState === 'open'; }
  /** False if it was not accepted. */
  send(bytes, reliable) {
    const channel = reliable ? this.#reliable : this.#newest;
    if (!this.open || (!reliable && channel.bufferedAmount > 1 << 18)) return false;
    try {
      channel.send(bytes);
    } catch {
      return false;
    }
    return true;
  }
  close() {
    clearTimeout(this.#timer);
    this.#connection?.close();
    this.#connection = this.#newest = this.#reliable = null;
    this.#early = [];
  }
  /** Signalling of the other end. Untrusted. */
  async hear(words) {
    try {
      if (words.offer && !this.offers) {
        this.#begin();
        await this.#connection.setRemoteDescription({type: 'offer', sdp: String(words.offer)});
        await this.#connection.setLocalDescription(await this.#connection.createAnswer());
        this.listener.say({answer: this.#connection.localDescription.sdp});
        await this.#addEarly();
      } else if (words.answer && this.offers && this.#connection) {
        await this.#connection.setRemoteDescription({type: 'answer', sdp: String(words.answer)});
        await this.#addEarly();
      } else if (words.candidate) {
        if (this.#connection?.remoteDescription) await this.#connection.addIceCandidate(words.candidate);
        else if (this.#early.length < 64) this.#early.push(words.candidate);
      }
    } catch {
      this.close();  // continue through the server
    }
  }

  async #addEarly() {
    for (const candidate of this.#early.splice(0)) await this.#connection.addIceCandidate(candidate);
  }
  #begin() {
    this.close();
    const connection = new RTCPeerConnection({iceServers: this.servers});
    this.#connection = connection;
    const channel = (id, options) => {
      const made = connection.createDataChannel('', {negotiated: true, id, ...options});
      made.binaryType = 'arraybuffer';
      made.onmessage = ({data}) => data instanceof ArrayBuffer && this.listener.heard(new Uint8Array(data));
      made.onopen = made.onclose = () => this.#connection === connection && this.listener.changed();
      return made;
    };
    this.#newest = channel(0, {ordered: false, maxRetransmits: 0});
    this.#reliable = channel(1, {});
    connection.onicecandidate = ({candidate}) => candidate && this.listener.say({candidate: candidate.toJSON()});
    connection.onconnectionstatechange = () => {
      if (this.#connection !== connection || connection.connectionState !== 'failed') return;
      this.close();
      this.listener.changed();
    };
    this.#timer = setTimeout(() => this.open || this.close(), PATIENCE_MS);
    if (this.offers) this.#offer(connection);
  }
  async #offer(connection) {
    try {
      await connection.setLocalDescription(await connection.createOffer());
      this.listener.say({offer: connection.localDescription.sdp});
    } catch {
      this.close();
    }
  }
}
