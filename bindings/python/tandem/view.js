// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The page of tandem.view(): asks for frames, draws the last one when there is a new one or the camera moves.
import {add, box, capsule, cross, dot, lathe, mesh, times, turn, upTo} from './view_geometry.js';

const canvas = document.querySelector('canvas');
const state = document.getElementById('state');
const gl = canvas.getContext('webgl2', {antialias: true, stencil: true, alpha: false});
if (!gl) {
  state.textContent = 'This browser has no WebGL 2.';
  throw new Error(state.textContent);
}

// --- Programs. A solid is scaled, turned and moved; its shadow also goes along the light to a plane.
const COMMON = `#version 300 es
precision highp float;
vec3 turn(vec4 q, vec3 v) { vec3 t = cross(q.xyz, v); return v + 2.0 * (q.w * t + cross(q.xyz, t)); }
const vec3 LIGHT = vec3(0.3482, -0.4352, 0.8303);
`;
const SOLID_VERTEX = `${COMMON}
layout(location=0) in vec3 p; layout(location=1) in vec3 n;
layout(location=2) in vec3 at; layout(location=3) in vec4 q; layout(location=4) in vec3 scale;
layout(location=5) in vec4 colour;
uniform mat4 camera; uniform vec4 plane; uniform bool shadow;
out vec3 normal, local, place; out vec4 tint;
void main() {
  place = at + turn(q, p * scale);
  if (shadow) place -= LIGHT * (dot(plane.xyz, place) - plane.w) / dot(plane.xyz, LIGHT);
  normal = turn(q, n / scale); local = p; tint = colour;
  gl_Position = camera * vec4(place, 1.0);
}`;
const SOLID_FRAGMENT = `${COMMON}
in vec3 normal, local, place; in vec4 tint;
uniform vec3 eye; uniform bool shadow, quarters; uniform vec4 plane;
out vec4 result;
void main() {
  if (shadow) { result = vec4(0.05, 0.08, 0.12, 0.22); return; }
  vec3 n = normalize(gl_FrontFacing ? normal : -normal), view = normalize(eye - place);
  float lit = 0.6 + 0.15 * n.z + 0.4 * max(dot(n, LIGHT), 0.0);
  float shine = 0.12 * pow(max(dot(n, normalize(LIGHT + view)), 0.0), 40.0);
  // Dark quarters, so that one sees a round thing turn.
  float tone = quarters && local.x * local.y > 0.0 ? 0.8 : 1.0;
  result = vec4(tint.rgb * tone * lit + shine, tint.a);
}`;
const PLANE_VERTEX = `${COMMON}
layout(location=0) in vec3 p;
uniform mat4 camera; uniform vec3 at; uniform vec4 q; uniform float size;
out vec2 offset, place;
void main() {
  offset = p.xy;
  vec3 inPlane = turn(vec4(-q.xyz, q.w), at);
  place = inPlane.xy + size * p.xy;
  gl_Position = camera * vec4(at + turn(q, vec3(size * p.xy, 0.0)), 1.0);
}`;
const PLANE_FRAGMENT = `${COMMON}
in vec2 offset, place;
uniform float cell, tone; uniform bool behind;
out vec4 result;
float lines(float width) {
  vec2 x = place / width, w = max(fwidth(x), 1e-6);
  vec2 l = 1.0 - min(abs(fract(x - 0.5) - 0.5) / w, 1.0);
  return max(l.x, l.y) * (1.0 - smoothstep(0.2, 0.6, max(w.x, w.y)));
}
void main() {
  float line = max(0.35 * lines(cell), 0.6 * lines(10.0 * cell));
  float fade = 1.0 - smoothstep(0.2, 1.0, length(offset));
  if (fade < 0.02) discard;
  result = vec4(tone * mix(vec3(0.80, 0.83, 0.86), vec3(0.45, 0.52, 0.58), line), fade * (behind ? 0.12 : 0.9));
}`;

function program(vertex, fragment) {
  const result = gl.createProgram();
  for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(result, shader);
  }
  gl.linkProgram(result);
  if (!gl.getProgramParameter(result, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(result));
  return new Proxy({program: result}, {
    get: (self, name) => self[name] ??= gl.getUniformLocation(result, name),
  });
}
const solids = program(SOLID_VERTEX, SOLID_FRAGMENT);
const planes = program(PLANE_VERTEX, PLANE_FRAGMENT);

const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;

const buffer = (kind, data, usage = gl.STATIC_DRAW) => {
  const made = gl.createBuffer();
  gl.bindBuffer(kind, made);
  gl.bufferData(kind, data, usage);
  return made;
};
const INSTANCE = [[2, 3], [3, 4], [4, 3], [5, 4]];  // attribute, floats: place, turn, scale, colour
const FLOATS = 14;
/** Draws many instances of one geometry. */
function drawable({corners, normals, triangles}) {
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  const buffers = [[0, corners], [1, normals]].map(([attribute, data]) => {
    const made = buffer(gl.ARRAY_BUFFER, new Float32Array(data));
    gl.enableVertexAttribArray(attribute);
    gl.vertexAttribPointer(attribute, 3, gl.FLOAT, false, 0, 0);
    return made;
  });
  buffers.push(buffer(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(triangles)));
  const instances = buffer(gl.ARRAY_BUFFER, 4, gl.DYNAMIC_DRAW);
  let offset = 0;
  for (const [attribute, floats] of INSTANCE) {
    gl.enableVertexAttribArray(attribute);
    gl.vertexAttribPointer(attribute, floats, gl.FLOAT, false, 4 * FLOATS, offset);
    gl.vertexAttribDivisor(attribute, 1);
    offset += 4 * floats;
  }
  gl.bindVertexArray(null);
  return {array, buffers: [...buffers, instances], instances, count: triangles.length, solid: [], clear: []};
}
const UNIT = {
  box: drawable(box()), sphere: drawable(capsule(1, 0)),
  cylinder: drawable(lathe([[0, -1, 0, -1], [1, -1, 0, -1], [1, -1, 1, 0], [1, 1, 1, 0], [1, 1, 0, 1],
                            [0, 1, 0, 1]])),
};
const PLANE = drawable({corners: [-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0], normals: Array(12).fill(0),
                        triangles: [0, 1, 2, 0, 2, 3]});

// --- Shapes, by the server's numbers: {draw, scale, radius, quarters}, {plane}, or {} until it has come.
const MAX_SHAPES = 200;  // in one request, as in view_server.py
const shapes = new Map();
async function load(numbers) {
  for (const number of numbers) shapes.set(number, {});
  const reply = await fetch(`shapes/${numbers}`);
  for (const [number, shape] of Object.entries(await reply.json())) {
    if (shapes.has(+number)) shapes.set(+number, made(shape));  // else it has gone again
  }
  dirty = true;
}
function made(s) {
  const r = s.radius, h = s.half_height;
  const own = (geometry) => ({draw: drawable(geometry), own: true, scale: [1, 1, 1]});
  switch (s.kind) {
    case 'halfspace': return {plane: s};
    case 'box': return {draw: UNIT.box, scale: s.half, radius: Math.hypot(...s.half)};
    case 'sphere': return {draw: UNIT.sphere, scale: [r, r, r], radius: r, quarters: true};
    case 'cylinder': return {draw: UNIT.cylinder, scale: [r, r, h], radius: Math.hypot(r, h), quarters: true};
    case 'capsule': return {...own(capsule(r, h)), radius: r + h, quarters: true};
    case 'cone': {
      const side = [2 * h / Math.hypot(2 * h, r), r / Math.hypot(2 * h, r)];
      return {...own(lathe([[0, -h, 0, -1], [r, -h, 0, -1], [r, -h, ...side], [0, h, ...side]])),
              radius: Math.hypot(r, h), quarters: true};
    }
  }
  const vertices = new Float32Array(bytesOf(s.vertices)), indices = new Uint32Array(bytesOf(s.triangles));
  let radius = 0;
  for (let i = 0; i < vertices.length; i += 3) radius = Math.max(radius, Math.hypot(...vertices.subarray(i, i + 3)));
  return {...own(mesh(vertices, indices, s.smooth)), radius};
}
function keepOnly(numbers) {
  const wanted = [...numbers].filter((number) => !shapes.has(number));
  for (let i = 0; i < wanted.length; i += MAX_SHAPES) {
    const some = wanted.slice(i, i + MAX_SHAPES);
    load(some).catch(() => some.forEach((number) => shapes.delete(number)));  // asked for again, if need be
  }
  for (const [number, {own, draw}] of shapes) {
    if (numbers.has(number)) continue;
    if (own) {
      gl.deleteVertexArray(draw.array);
      draw.buffers.forEach((b) => gl.deleteBuffer(b));
    }
    shapes.delete(number);
  }
}

// --- Frames.
let bodies = [];  // [index, [shape, x, y, z, qx, qy, qz, qw, sensor]...]...
let rows = new Float32Array(0);  // of each body x, y, z, qx, qy, qz, qw, kind
let dirty = true, ended = false;
const COLOURS = {static: [0.62, 0.65, 0.69], kinematic: [0.93, 0.60, 0.22], dynamic: [0.25, 0.53, 0.85]};
const asleep = (colour) => colour.map((c) => 0.4 * c + 0.36);
function colourOf(index, kind) {
  const type = kind & 3;
  if (type < 2) return type === 0 ? COLOURS.static : COLOURS.kinematic;
  // Neighbours differ a little.
  const shade = COLOURS.dynamic.map((c, k) => c + 0.16 * (((index * [0.618, 0.382, 0.755][k]) % 1) - 0.5));
  return kind & 4 ? shade : asleep(shade);
}
function take(data) {
  const view = new DataView(data);
  const [number, scene, bytes] = [0, 4, 8].map((at) => view.getUint32(at, true));
  if (bytes > 0) {
    bodies = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 24, bytes)));
    keepOnly(new Set(bodies.flatMap(([, ...parts]) => parts.map((part) => part[0]))));
  }
  rows = new Float32Array(data, 24 + bytes);
  const time = view.getFloat64(12, true);
  state.textContent = `${time.toFixed(2)} s · ${bodies.length} ${bodies.length === 1 ? 'body' : 'bodies'}`;
  dirty = true;
  return {number, scene};
}
async function follow() {
  let seen = {number: 0, scene: 0};
  for (let failed = 0; failed < 3 && !ended;) {
    try {
      const reply = await fetch(`frame?after=${seen.number}&scene=${seen.scene}`);
      if (!reply.ok) throw new Error(reply.status);
      const data = await reply.arrayBuffer();
      if (data.byteLength > 0) seen = take(data);
      failed = 0;
      await new Promise(requestAnimationFrame);  // as fast as it draws; not at all where nobody looks
    } catch (error) {
      ++failed;
      await new Promise((resolve) => setTimeout(resolve, 300));
    }
  }
  ended = true;
  state.textContent += ' · ended';
  document.getElementById('stop').hidden = true;
}
document.getElementById('stop').onclick = () => fetch('stop', {method: 'POST'}).catch(() => {});
const legend = [...Object.entries(COLOURS), ['asleep', asleep(COLOURS.dynamic)]];
document.getElementById('legend').append(...legend.flatMap(([name, c]) => {
  const spot = document.createElement('i');
  spot.style.background = `rgb(${c.map((x) => 255 * x)})`;
  return [spot, name];
}));

// --- Camera: looks at `target` (m) from `distance` (m).
const camera = {target: [0, 0, 0.5], distance: 5, azimuth: -1.1, elevation: 0.35, fitted: false};
function axes() {
  const [ca, ce] = [Math.cos(camera.azimuth), Math.cos(camera.elevation)];
  const [sa, se] = [Math.sin(camera.azimuth), Math.sin(camera.elevation)];
  return {back: [ce * ca, ce * sa, se], right: [-sa, ca, 0], up: [-se * ca, -se * sa, ce]};
}
/** All that moves in view; where nothing does, all that has an end. */
function fit() {
  const balls = placed.filter(({shape}) => shape.radius > 0);
  const moving = balls.filter(({kind}) => (kind & 3) > 0);
  const chosen = moving.length > 0 ? moving : balls;
  if (chosen.length === 0) return;
  camera.target = [0, 1, 2].map((k) => {
    const low = chosen.reduce((m, {at}) => Math.min(m, at[k]), Infinity);
    return (low + chosen.reduce((m, {at}) => Math.max(m, at[k]), -Infinity)) / 2;
  });
  const away = ({at, shape}) => Math.hypot(...add(at, camera.target, -1)) + shape.radius;
  const radius = chosen.reduce((r, one) => Math.max(r, away(one)), 0.01);
  camera.distance = 2.4 * radius;
  camera.fitted = dirty = true;
}
const pointers = new Map();
canvas.addEventListener('pointerdown', (e) => {
  canvas.setPointerCapture(e.pointerId);
  pointers.set(e.pointerId, [e.clientX, e.clientY]);
});
for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, (e) => pointers.delete(e.pointerId));
canvas.addEventListener('contextmenu', (e) => e.preventDefault());
const zoom = (factor) => { camera.distance = Math.min(1e5, Math.max(0.01, camera.distance * factor)); dirty = true; };
canvas.addEventListener('pointermove', (e) => {
  if (!pointers.has(e.pointerId)) return;
  const before = pointers.get(e.pointerId), now = [e.clientX, e.clientY];
  const other = [...pointers].find(([id]) => id !== e.pointerId)?.[1];
  pointers.set(e.pointerId, now);
  const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
  if (other) {
    const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) + 1;
    zoom(apart(before) / apart(now));
  } else if (e.shiftKey || e.buttons & 6) {
    const {right, up} = axes(), metre = camera.distance / canvas.clientHeight;
    camera.target = add(add(camera.target, right, -dx * metre), up, dy * metre);
  } else turnBy(-0.006 * dx, 0.006 * dy);
  dirty = true;
});
function turnBy(azimuth, elevation) {
  camera.azimuth += azimuth;
  camera.elevation = Math.min(1.55, Math.max(-1.55, camera.elevation + elevation));
  dirty = true;
}
canvas.addEventListener('wheel', (e) => {
  e.preventDefault();
  zoom(Math.exp(0.0012 * e.deltaY * (e.deltaMode ? 30 : 1)));
}, {passive: false});
const KEYS = {
  f: fit, F: fit, '+': () => zoom(0.9), '-': () => zoom(1.1),
  ArrowLeft: () => turnBy(-0.08, 0), ArrowRight: () => turnBy(0.08, 0),
  ArrowUp: () => turnBy(0, 0.08), ArrowDown: () => turnBy(0, -0.08),
};
addEventListener('keydown', (e) => { if (!e.ctrlKey && !e.metaKey) KEYS[e.key]?.(); });
addEventListener('resize', () => { dirty = true; });

// --- Drawing.
let placed = [];  // of each solid: where it is
function place() {
  placed = [];
  const flat = [];
  const draws = new Set();
  for (const {draw} of shapes.values()) if (draw) draw.solid = [], draw.clear = [], draws.add(draw);
  bodies.forEach(([index, ...parts], i) => {
    const row = rows.subarray(8 * i, 8 * i + 8), kind = row[7];
    if (row.length < 8 || kind < 0) return;
    const turned = row.subarray(3, 7);
    for (const part of parts) {
      const shape = shapes.get(part[0]);
      const at = add(row, turn(turned, part.slice(1, 4))), q = times(turned, part.slice(4, 8));
      if (shape?.plane) {
        const normal = turn(q, shape.plane.normal);
        flat.push({normal, level: dot(normal, at) + shape.plane.offset});
      } else if (shape?.draw) {
        placed.push({at, shape, kind});
        const floats = part[8] ? shape.draw.clear : shape.draw.solid;
        floats.push(...at, ...q, ...shape.scale, ...colourOf(index, kind), part[8] ? 0.3 : 1);
        shape.draw.quarters = shape.quarters;
      }
    }
  });
  return {draws, flat};
}
function drawSolids(draws, list) {
  for (const draw of draws) {
    if (draw[list].length === 0) continue;
    gl.bindVertexArray(draw.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, draw.instances);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(draw[list]), gl.DYNAMIC_DRAW);
    gl.uniform1i(solids.quarters, draw.quarters ? 1 : 0);
    gl.drawElementsInstanced(gl.TRIANGLES, draw.count, gl.UNSIGNED_INT, 0, draw[list].length / FLOATS);
  }
}
function drawPlane({normal, level}, eye, view) {
  gl.useProgram(planes.program);
  gl.bindVertexArray(PLANE.array);
  const q = upTo(normal), foot = add(camera.target, normal, level - dot(normal, camera.target));
  gl.uniformMatrix4fv(planes.camera, false, view);
  gl.uniform3fv(planes.at, foot);
  gl.uniform4fv(planes.q, q);
  gl.uniform1f(planes.size, 12 * camera.distance);
  gl.uniform1f(planes.cell, 10 ** Math.floor(Math.log10(camera.distance / 3)));
  const behind = dot(normal, eye) < level;
  gl.uniform1i(planes.behind, behind ? 1 : 0);
  gl.uniform1f(planes.tone, 0.86 + 0.07 * normal[0] + 0.14 * normal[2]);  // walls are darker than floors
  gl.depthMask(!behind);  // one sees through them from behind
  gl.drawElements(gl.TRIANGLES, 6, gl.UNSIGNED_INT, 0);
}
function draw() {
  requestAnimationFrame(draw);
  if (!dirty) return;
  dirty = false;
  const {draws, flat} = place();
  if (!camera.fitted && ![...shapes.values()].some(({draw, plane}) => !draw && !plane)) fit();  // all have come
  const ratio = Math.min(devicePixelRatio || 1, 2);
  const [w, h] = [Math.round(canvas.clientWidth * ratio) || 1, Math.round(canvas.clientHeight * ratio) || 1];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const {back, right, up} = axes(), eye = add(camera.target, back, camera.distance);
  const near = 0.02 * camera.distance, far = 60 * camera.distance, zoomed = 2;
  const depth = [(far + near) / (near - far), 2 * far * near / (near - far)];
  const sx = zoomed * Math.min(1, h / w * 1.4), sy = sx * w / h;
  const view = new Float32Array(16);  // perspective of the three axes, column by column
  for (let k = 0; k < 3; ++k) view.set([sx * right[k], sy * up[k], depth[0] * back[k], -back[k]], 4 * k);
  view.set([-sx * dot(right, eye), -sy * dot(up, eye), -depth[0] * dot(back, eye) + depth[1], dot(back, eye)], 12);

  gl.viewport(0, 0, w, h);
  gl.clearColor(0.914, 0.929, 0.945, 1);
  gl.depthMask(true);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.disable(gl.BLEND);
  gl.useProgram(solids.program);
  gl.uniformMatrix4fv(solids.camera, false, view);
  gl.uniform3fv(solids.eye, eye);
  gl.uniform1i(solids.shadow, 0);
  drawSolids(draws, 'solid');

  gl.enable(gl.BLEND);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  for (const plane of flat) drawPlane(plane, eye, view);
  gl.depthMask(false);
  gl.useProgram(solids.program);
  // Shadows on the first floor, once for each pixel.
  const floor = flat.find(({normal, level}) => normal[2] > 0.5 && dot(normal, eye) > level);
  if (floor) {
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(-2, -4);  // they lie in it
    gl.enable(gl.STENCIL_TEST);
    gl.stencilFunc(gl.EQUAL, 0, 255);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
    gl.uniform1i(solids.shadow, 1);
    gl.uniform4fv(solids.plane, [...floor.normal, floor.level]);
    drawSolids(draws, 'solid');
    gl.uniform1i(solids.shadow, 0);
    gl.disable(gl.STENCIL_TEST);
    gl.disable(gl.POLYGON_OFFSET_FILL);
  }
  drawSolids(draws, 'clear');
  gl.bindVertexArray(null);
  window.tandemView = {drawn: (window.tandemView?.drawn ?? 0) + 1, placed: placed.length, planes: flat.length};
}
requestAnimationFrame(draw);
follow();
