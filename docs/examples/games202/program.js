// SPDX-License-Identifier: GPL-3.0-or-later
// What every drawing in WebGL begins with: a program of two shaders, and attributes from buffers.
"use strict";

const ENCODED = `vec3 encoded(vec3 linear) { // by the sRGB curve
     return mix(12.92 * linear, 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, linear));
   }`;

/** A program of a vertex and a fragment shader, its attributes in given slots. */
function linkedProgram(gl, sources, slots) {
  const program = gl.createProgram();
  sources.forEach((source, i) => {
    const shader = gl.createShader([gl.VERTEX_SHADER, gl.FRAGMENT_SHADER][i]);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  });
  for (const [name, slot] of Object.entries(slots)) gl.bindAttribLocation(program, slot, name);
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return program;
}

/** A buffer of floats. */
function filledBuffer(gl, values) {
  const buffer = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
  return buffer;
}

/** Have a slot read `size` floats of a buffer per vertex; a `mat3`, nine floats, fills three slots. */
function feed(gl, buffer, slot, size) {
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  for (let column = 0; column < size / 3; column++) {
    gl.enableVertexAttribArray(slot + column);
    gl.vertexAttribPointer(slot + column, Math.min(size, 3), gl.FLOAT, false, 4 * size, 12 * column);
  }
}

/** Draw that many vertices by what was fed, and let go of the slots. */
function drawFed(gl, count, slots) {
  gl.drawArrays(gl.TRIANGLES, 0, count);
  for (let slot = 0; slot < slots; slot++) gl.disableVertexAttribArray(slot);
}

/** Two numbers per corner of a triangle that covers the picture. */
const WHOLE_PICTURE = new Float32Array([-1, -1, 3, -1, -1, 3]);
