// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Renderer, light, background: everything that does not depend on a session.
import * as THREE from './three.module.min.js';
import {drawsInSoftware} from './software.js';

/** Colours of objects without their own; the page's colours are in style.css. */
export const THEMES = {
  light: {background: '#e9eef3', ground: '#dfe6ec', line: '#8899aa', wall: '#f4f7fa',
          fixed: '#c3ccd6', sky: '#ffffff', below: '#c9d2da', ambient: 1.75, sun: 2.3, dim: 1},
  dark: {background: '#161d24', ground: '#333e49', line: '#8294a8', wall: '#3a4550',
         fixed: '#6b7a8a', sky: '#dfe9f5', below: '#56636f', ambient: 1.6, sun: 2.6, dim: 0.45},
};

const SLOW = 45;  // ms per picture, above which pixels are reduced

/** One renderer and scene for all panes. */
export class Stage {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {{still: boolean}} options  still: best quality at any cost in time
   */
  constructor(canvas, {still}) {
    this.still = still;
    const plain = !still && drawsInSoftware();
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: !plain,
                                             preserveDrawingBuffer: still});
    this.renderer.shadowMap.enabled = !plain;
    this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    this.ratio = Math.min(plain ? 0.75 : 2, window.devicePixelRatio || 1);
    this.scene = new THREE.Scene();
    this.scene.fog = new THREE.Fog('#fff', 1, 100);
    this.scene.background = new THREE.Color();
    this.hemisphere = new THREE.HemisphereLight();
    this.hemisphere.position.set(0, 0, 1);
    this.sun = new THREE.DirectionalLight('#fff6ea');
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.setScalar(still ? 4096 : 2048);
    this.sun.shadow.radius = still ? 5 : 3;
    this.scene.add(this.hemisphere, this.sun, this.sun.target);
    this.slowness = 0;  // ms, mean time per picture
  }

  /** @param {object} theme  of THEMES */
  paint(theme) {
    this.scene.background.set(theme.background);
    this.scene.fog.color.set(theme.background);
    this.hemisphere.color.set(theme.sky);
    this.hemisphere.groundColor.set(theme.below);
    this.hemisphere.intensity = theme.ambient;
    this.sun.intensity = theme.sun;
  }

  /** @param {THREE.Vector3} centre  m @param {number} radius  m: of all shadow casters */
  lightUp(centre, radius) {
    this.sun.target.position.copy(centre);
    this.sun.position.copy(centre).add(new THREE.Vector3(-0.45, -0.6, 1.15).multiplyScalar(
      2 * radius));
    const camera = this.sun.shadow.camera;
    camera.left = camera.bottom = -radius;
    camera.right = camera.top = radius;
    camera.near = 0.2 * radius;
    camera.far = 5 * radius;
    camera.updateProjectionMatrix();
    this.sun.shadow.normalBias = 0.004 * radius;
    this.sun.shadow.bias = -0.0004;
  }

  /** @param {number} width  CSS pixels @param {number} height  CSS pixels */
  resize(width, height) {
    this.width = width;
    this.height = height;
    this.renderer.setPixelRatio(this.ratio);
    this.renderer.setSize(width, height, false);
  }

  /**
   * Draws one pane.
   * @param {{x: number, y: number, width: number, height: number}} rect  CSS pixels, y down
   * @param {THREE.PerspectiveCamera} camera
   * @param {number} distance  m, from the camera to its target
   */
  draw(rect, camera, distance) {
    this.scene.fog.near = 3 * distance;
    this.scene.fog.far = 12 * distance;
    const bottom = this.height - rect.y - rect.height;
    this.renderer.setViewport(rect.x, bottom, rect.width, rect.height);
    this.renderer.setScissor(rect.x, bottom, rect.width, rect.height);
    this.renderer.setScissorTest(true);
    this.renderer.render(this.scene, camera);
  }

  /**
   * Reduces pixels, then soft shadows, if pictures take too long.
   * @param {number} took  ms since the one before
   * @returns {number}  ms to wait before the next one
   */
  adapt(took) {
    if (this.still || took > 2000) return 0;
    this.slowness += Math.min(0.3, took / 1500) * (took - this.slowness);
    if (this.slowness < SLOW) return 0;
    const rest = 0.4 * this.slowness;
    if (this.ratio > 0.75) {
      this.ratio = Math.max(0.75, this.ratio - 0.5);
      this.resize(this.width, this.height);
      this.slowness = 0.7 * SLOW;
    } else if (this.sun.shadow.mapSize.x > 1024) {
      this.sun.shadow.mapSize.setScalar(1024);
      this.sun.shadow.map?.dispose();
      this.sun.shadow.map = null;
      this.slowness = 0.7 * SLOW;
    } else if (this.slowness > 3 * SLOW && this.ratio > 0.5) {
      this.ratio = 0.5;
      this.resize(this.width, this.height);
    }
    return rest;
  }
}
