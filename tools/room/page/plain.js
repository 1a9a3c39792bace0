// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A material for software rendering: lit per corner instead of per pixel, by sun and sky of drawing.js, without fog and
// shadows. A picture of 200 boxes takes two fifths of the time.
import * as THREE from './three.module.min.js';

const VERTEX = `
uniform vec3 colour;
varying vec3 seen;
void main() {
  vec3 own = colour;
  vec3 turned = normal;
  vec4 place = vec4(position, 1.0);
#ifdef USE_INSTANCING
  turned = mat3(instanceMatrix) * turned;
  place = instanceMatrix * place;
#endif
#ifdef USE_INSTANCING_COLOR
  own = instanceColor;
#endif
  turned = normalize(turned);
  vec3 sky = mix(vec3(0.21, 0.195, 0.17), vec3(0.67), 0.5 + 0.5 * turned.z);
  vec3 sun = 0.57 * vec3(1.0, 0.9, 0.75) * max(0.0, dot(turned, normalize(vec3(2.5, -2.0, 6.0))));
  seen = pow(own * (sky + sun), vec3(1.0 / 2.2));
  gl_Position = projectionMatrix * modelViewMatrix * place;
}`;
const FRAGMENT = 'varying vec3 seen; void main() { gl_FragColor = vec4(seen, 1.0); }';

/** For a single mesh or for instances. @param {number} colour  without instances, as 0xrrggbb */
export function plainMaterial(colour = 0xffffff) {
  return new THREE.ShaderMaterial({uniforms: {colour: {value: new THREE.Color(colour)}}, vertexShader: VERTEX,
                                   fragmentShader: FRAGMENT});
}
