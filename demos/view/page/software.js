// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

/** True without a graphics processor: shadows then cost too much processor time. */
export function drawsInSoftware() {
  const gl = document.createElement('canvas').getContext('webgl2');
  const names = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = names ? String(gl.getParameter(names.UNMASKED_RENDERER_WEBGL)) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}
