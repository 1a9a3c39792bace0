// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The bodies of all peers as meshes. Equal solids of a peer are instances of one mesh; colours of
// bodies are the same for all peers. World frame, z up, m.
import * as THREE from './three.module.min.js';
import {bodyColour, peerColour} from './colours.js';
import {solidOf} from './geometry.js';

const ONE = new THREE.Vector3(1, 1, 1);

function partMatrix(part, scale) {
  const [x, y, z, qx, qy, qz, qw] = part.pose;
  return new THREE.Matrix4().compose(new THREE.Vector3(x, y, z),
                                     new THREE.Quaternion(qx, qy, qz, qw).normalize(),
                                     new THREE.Vector3(...scale));
}

/** Which parts of which bodies go into which instanced mesh; the same for all peers. */
function makeBatches(bodies) {
  const batches = new Map();
  bodies.forEach((body, index) => {
    body.parts.forEach((part, k) => {
      if (part.shape === 'half_space') return;
      const solid = solidOf(part, `body ${index} ${k}`, body.turns);
      if (!solid) return;
      if (!batches.has(solid.key)) batches.set(solid.key, {make: solid.make, entries: []});
      batches.get(solid.key).entries.push({body: index, local: partMatrix(part, solid.scale)});
    });
  });
  for (const batch of batches.values()) batch.geometry = batch.make(batch.entries.length);
  return [...batches.values()];
}

/** One peer's bodies as they are drawn: between the last two frames. */
class PeerBodies {
  constructor(peer, batches, colours, materials) {
    this.group = new THREE.Group();
    this.colours = colours;
    this.materials = materials;
    this.ghost = new THREE.MeshStandardMaterial({
      color: peerColour(peer), roughness: 0.6, transparent: true, opacity: 0.5, depthWrite: false,
      // Where it is with the first peer, it is not seen.
      polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 8,
    });
    const n = colours.length;
    this.from = {positions: new Float32Array(3 * n), orientations: new Float32Array(4 * n)};
    this.shown = {positions: new Float32Array(3 * n), orientations: new Float32Array(4 * n)};
    this.to = null;
    this.matrices = Array.from({length: n}, () => new THREE.Matrix4());
    this.meshes = batches.map((batch) => {
      const mesh = new THREE.InstancedMesh(batch.geometry, materials.solid, batch.entries.length);
      mesh.castShadow = mesh.receiveShadow = true;
      mesh.frustumCulled = false;
      mesh.userData.entries = batch.entries;
      batch.entries.forEach((entry, i) => mesh.setColorAt(i, colours[entry.body]));
      this.group.add(mesh);
      return mesh;
    });
  }

  /** A frame has come. @param {object} poses  of a PeerFrame @param {boolean} jump  do not glide */
  aim(poses, jump) {
    if (jump || !this.to) {
      this.shown.positions.set(poses.positions);
      this.shown.orientations.set(poses.orientations);
    }
    this.from.positions.set(this.shown.positions);
    this.from.orientations.set(this.shown.orientations);
    this.to = poses;
  }

  /** @param {number} t  0..1, from what was drawn when the last frame came to that frame */
  move(t) {
    if (!this.to) return;
    const {positions: p, orientations: q} = this.shown;
    const {positions: p0, orientations: q0} = this.from;
    const {positions: p1, orientations: q1} = this.to;
    for (let i = 0; i < p.length; ++i) p[i] = p0[i] + t * (p1[i] - p0[i]);
    const place = new THREE.Vector3();
    const turn = new THREE.Quaternion();
    for (let b = 0, i = 0; i < q.length; ++b, i += 4) {
      const dot = q0[i] * q1[i] + q0[i + 1] * q1[i + 1] + q0[i + 2] * q1[i + 2] +
                  q0[i + 3] * q1[i + 3];
      const sign = dot < 0 ? -1 : 1;
      turn.set(q0[i] + t * (sign * q1[i] - q0[i]), q0[i + 1] + t * (sign * q1[i + 1] - q0[i + 1]),
               q0[i + 2] + t * (sign * q1[i + 2] - q0[i + 2]),
               q0[i + 3] + t * (sign * q1[i + 3] - q0[i + 3])).normalize().toArray(q, i);
      place.fromArray(p, 3 * b);
      this.matrices[b].compose(place, turn, ONE);
    }
    const matrix = new THREE.Matrix4();
    for (const mesh of this.meshes) {
      mesh.userData.entries.forEach((entry, i) => {
        mesh.setMatrixAt(i, matrix.multiplyMatrices(this.matrices[entry.body], entry.local));
      });
      mesh.instanceMatrix.needsUpdate = true;
      mesh.boundingSphere = null;  // else rays are tried against where it once was
    }
  }

  /** @param {?Uint8Array} influence  colours by it, null: by body @param {THREE.Color} own */
  colour(influence, own) {
    if (!influence && !this.tinted) return;
    this.tinted = Boolean(influence);
    const grey = new THREE.Color('#b4bcc5');
    const mixed = new THREE.Color();
    for (const mesh of this.meshes) {
      mesh.userData.entries.forEach(({body}, i) => {
        mixed.copy(this.colours[body]);
        // Pale where it follows the others, the peer's own where it leads.
        if (influence) mixed.lerp(grey, 0.6).lerp(own, influence[body] / 255);
        mesh.setColorAt(i, mixed);
      });
      mesh.instanceColor.needsUpdate = true;
    }
  }

  asGhost(ghost) {
    for (const mesh of this.meshes) {
      mesh.material = ghost ? this.ghost : this.materials.solid;
      mesh.castShadow = !ghost;
      mesh.renderOrder = ghost ? 1 : 0;
    }
  }
}

/** All peers' bodies of one session. */
export class Bodies extends THREE.Group {
  /** @param {object} hello  the server's first message */
  constructor(hello) {
    super();
    this.hello = hello;
    const batches = makeBatches(hello.bodies);
    const colours = hello.bodies.map(bodyColour);
    this.geometries = batches.map((batch) => batch.geometry);
    this.materials = {
      solid: new THREE.MeshStandardMaterial({roughness: 0.55, metalness: 0, vertexColors: true})};
    this.peers = hello.peers.map((_, p) => new PeerBodies(p, batches, colours, this.materials));
    this.peers.forEach((peer) => this.add(peer.group));
  }

  /** @param {import('./protocol.js').Frame} frame @param {boolean} jump  do not glide there */
  aim(frame, jump) {
    frame.peers.forEach((peer, p) => {
      this.peers[p].aim(peer, jump);
      this.peers[p].colour(peer.overlays?.influence, new THREE.Color(peerColour(p)));
    });
  }

  /** @param {number} t  0..1, see PeerBodies.move */
  move(t) {
    for (const peer of this.peers) peer.move(t);
  }

  /**
   * @param {Set<number>} peers  who is seen
   * @param {boolean} ghosts     all but the first are ghosts
   */
  show(peers, ghosts) {
    const first = Math.min(...peers);
    this.peers.forEach((peer, p) => {
      peer.group.visible = peers.has(p);
      peer.asGhost(ghosts && p !== first);
    });
  }

  /**
   * @param {THREE.Raycaster} ray
   * @param {number} peer  whose bodies
   * @returns {?{body: number, point: THREE.Vector3}}  the nearest body that the ray meets, unless
   *   it is a user's own
   */
  hit(ray, peer) {
    const hits = ray.intersectObjects(this.peers[peer].meshes, false);
    for (const {object, point, instanceId} of hits) {
      const {body} = object.userData.entries[instanceId];
      const {owner} = this.hello.bodies[body];
      if (owner === null || owner === undefined) return {body, point};
    }
    return null;
  }

  /** @returns {THREE.Vector3}  m, world: where a body's centre is drawn */
  place(peer, body, out = new THREE.Vector3()) {
    return out.fromArray(this.peers[peer].shown.positions, 3 * body);
  }
  /** @returns {THREE.Matrix4}  body to world, as drawn */
  bodyMatrix(peer, body) {
    return this.peers[peer].matrices[body];
  }

  dispose() {
    this.geometries.forEach((geometry) => geometry.dispose());
    this.materials.solid.dispose();
    for (const peer of this.peers) {
      peer.ghost.dispose();
      peer.meshes.forEach((mesh) => mesh.dispose());
    }
  }
}
