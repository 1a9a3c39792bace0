// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The bodies of all peers as meshes. Equal solids of a peer are instances of one mesh; all peers
// use the same body colours. World frame, z up, m.
import * as THREE from './three.module.min.js';
import {bodyColour, peerColour} from './colours.js';
import {solidOf} from './geometry.js';
import {People} from './people.js';

const ONE = new THREE.Vector3(1, 1, 1);

function partMatrix(part, scale) {
  const [x, y, z, qx, qy, qz, qw] = part.pose;
  return new THREE.Matrix4().compose(new THREE.Vector3(x, y, z),
                                     new THREE.Quaternion(qx, qy, qz, qw).normalize(),
                                     new THREE.Vector3(...scale));
}

/** Assigns parts of bodies to instanced meshes; the same for all peers. */
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

class PeerBodies {
  constructor(colour, bodies, batches, colours, materials) {
    this.own = new THREE.Color(colour);
    this.group = new THREE.Group();
    this.people = new People(bodies);
    this.group.add(this.people);
    this.colours = colours;
    this.materials = materials;
    this.ghost = new THREE.MeshStandardMaterial({
      color: colour, roughness: 0.6, transparent: true, opacity: 0.5, depthWrite: false,
      // Hidden where it coincides with the first peer's.
      polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 8,
    });
    const n = colours.length;
    this.shown = {positions: new Float32Array(3 * n), orientations: new Float32Array(4 * n)};
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

  /** Moves the meshes to the poses of `shown`. */
  move() {
    const {positions, orientations} = this.shown;
    const place = new THREE.Vector3();
    const turn = new THREE.Quaternion();
    this.matrices.forEach((matrix, b) => {
      matrix.compose(place.fromArray(positions, 3 * b), turn.fromArray(orientations, 4 * b), ONE);
    });
    this.people.update(positions);
    const matrix = new THREE.Matrix4();
    for (const mesh of this.meshes) {
      mesh.userData.entries.forEach((entry, i) => {
        mesh.setMatrixAt(i, matrix.multiplyMatrices(this.matrices[entry.body], entry.local));
      });
      mesh.instanceMatrix.needsUpdate = true;
      mesh.boundingSphere = null;  // otherwise rays would test its old bounds
    }
  }

  /** @param {?Uint8Array} influence  colours by influence; null: by body */
  colour(influence) {
    if (!influence && !this.tinted) return;
    this.tinted = Boolean(influence);
    const grey = new THREE.Color('#b4bcc5');
    const mixed = new THREE.Color();
    for (const mesh of this.meshes) {
      mesh.userData.entries.forEach(({body}, i) => {
        mixed.copy(this.colours[body]);
        // Pale if it follows the others, the peer's colour if it leads.
        if (influence) mixed.lerp(grey, 0.6).lerp(this.own, influence[body] / 255);
        mesh.setColorAt(i, mixed);
      });
      mesh.instanceColor.needsUpdate = true;
    }
  }

  asGhost(ghost) {
    this.people.visible = !ghost;
    for (const mesh of this.meshes) {
      mesh.material = ghost ? this.ghost : this.materials.solid;
      mesh.castShadow = !ghost;
      mesh.renderOrder = ghost ? 1 : 0;
    }
  }
}

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
    this.peers = hello.peers.map(({id}) => new PeerBodies(peerColour(id - 1), hello.bodies, batches,
                                                         colours, this.materials));
    this.peers.forEach((peer) => this.add(peer.group));
  }

  /** @param {import('./timeline.js').Timeline} timeline  gives the playhead */
  move(timeline) {
    timeline.after.peers.forEach(({overlays}, p) => {
      timeline.poses(p, this.peers[p].shown);
      this.peers[p].move();
      // A world alone neither leads nor follows.
      this.peers[p].colour(this.hello.alone ? null : overlays?.influence);
    });
  }
  /** Poses of each peer as drawn. */
  get shown() { return this.peers.map((peer) => peer.shown); }

  /**
   * @param {Set<number>} peers  visible peers
   * @param {boolean} ghosts     draw all but the first as ghosts
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
   * @returns {?{body: number, point: THREE.Vector3}}  the nearest body on the ray, unless
   *   a user owns it
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

  /** @returns {THREE.Vector3}  m, world: a body's centre as drawn */
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
      peer.people.dispose();
      peer.meshes.forEach((mesh) => mesh.dispose());
    }
  }
}
