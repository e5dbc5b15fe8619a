// SPDX-License-Identifier: GPL-3.0-or-later
// Viewer draws a mesh by its transport in WebGL 1: one dot product per vertex and channel, as the homework has it.
"use strict";

const MESH_SHADERS = [
  `attribute vec3 aPlace;
   attribute mat3 aTransport;
   uniform mat4 uCamera;
   uniform mat3 uLight[3];
   varying vec3 vColour;
   float carried(mat3 light) {
     return dot(aTransport[0], light[0]) + dot(aTransport[1], light[1]) + dot(aTransport[2], light[2]);
   }
   void main() {
     gl_Position = uCamera * vec4(aPlace, 1.0);
     vColour = vec3(carried(uLight[0]), carried(uLight[1]), carried(uLight[2]));
   }`,
  `precision highp float;
   varying vec3 vColour;
   uniform bool uEncoded;
   void main() {
     vec3 linear = max(vColour, 0.0);
     vec3 curve = mix(12.92 * linear, 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, linear));
     gl_FragColor = vec4(uEncoded ? curve : linear, 1.0);
   }`,
];
const SKY_SHADERS = [
  `attribute vec2 aCorner;
   uniform mat3 uRays;
   varying vec3 vRay;
   void main() {
     gl_Position = vec4(aCorner, 1.0, 1.0);
     vRay = uRays * vec3(aCorner, 1.0);
   }`,
  `precision highp float;
   varying vec3 vRay;
   uniform samplerCube uSky;
   void main() { gl_FragColor = textureCube(uSky, vRay); }`,
];
const FIELD_OF_VIEW = 40 * Math.PI / 180;
const SLOTS = { aPlace: 0, aTransport: 1, aCorner: 0 }; // a mat3 fills three

class Viewer {
  constructor(gl) {
    this.gl = gl;
    this.turn = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]; // of the sky
    this.azimuth = 0.35;
    this.elevation = 0.12;
    this._meshProgram = linkedProgram(gl, MESH_SHADERS, SLOTS);
    this._skyProgram = linkedProgram(gl, SKY_SHADERS, SLOTS);
    this._screen = this._buffer(new Float32Array([-1, -1, 3, -1, -1, 3]));
  }

  /** Places and transport of face corners, three and nine numbers each, and the light as nine [r, g, b]. */
  setScene(places, transport, light) {
    const least = [0, 1, 2].map((k) => places.reduce((m, v, i) => (i % 3 === k ? Math.min(m, v) : m), Infinity));
    const most = [0, 1, 2].map((k) => places.reduce((m, v, i) => (i % 3 === k ? Math.max(m, v) : m), -Infinity));
    this.centre = least.map((value, k) => (value + most[k]) / 2);
    this.radius = Math.hypot(...most.map((value, k) => value - least[k])) / 2;
    this.count = places.length / 3;
    this.light = light;
    this._places = this._buffer(places);
    this._transport = this._buffer(transport);
  }

  /** Six pictures of one size, in the order of `Files.FACES`. */
  setSky(pictures) {
    const gl = this.gl;
    this._sky = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_CUBE_MAP, this._sky);
    pictures.forEach((picture, i) =>
      gl.texImage2D(gl.TEXTURE_CUBE_MAP_POSITIVE_X + i, 0, gl.RGB, gl.RGB, gl.UNSIGNED_BYTE, picture));
    for (const [name, value] of [["MIN_FILTER", "LINEAR"], ["MAG_FILTER", "LINEAR"], ["WRAP_S", "CLAMP_TO_EDGE"], ["WRAP_T", "CLAMP_TO_EDGE"]])
      gl.texParameteri(gl.TEXTURE_CUBE_MAP, gl[`TEXTURE_${name}`], gl[value]);
  }

  /** Draw into what is bound; encoded as screens want it, or linear. */
  draw(width, height, encoded = true) {
    const gl = this.gl;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (this.count) this._drawMesh(width / height, encoded);
    if (this._sky) this._drawSky(width / height);
  }

  /** Where the camera is, and its axes: right, up and back. */
  camera() {
    const [sa, ca, se, ce] = [Math.sin(this.azimuth), Math.cos(this.azimuth), Math.sin(this.elevation), Math.cos(this.elevation)];
    const axes = [[ca, 0, -sa], [-se * sa, ce, -se * ca], [ce * sa, se, ce * ca]];
    const distance = this.radius / Math.sin(FIELD_OF_VIEW / 2);
    return { eye: this.centre.map((value, k) => value + distance * axes[2][k]), axes, distance };
  }

  _drawMesh(aspect, encoded) {
    const gl = this.gl, program = this._meshProgram, light = Harmonics.turned(this.light, this.turn);
    gl.useProgram(program);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.uniformMatrix4fv(gl.getUniformLocation(program, "uCamera"), false, this._matrix(aspect));
    gl.uniformMatrix3fv(gl.getUniformLocation(program, "uLight"), false, [0, 1, 2].flatMap((c) => light.map((rgb) => rgb[c])));
    gl.uniform1i(gl.getUniformLocation(program, "uEncoded"), encoded ? 1 : 0);
    this._attribute(this._places, SLOTS.aPlace, 3);
    for (let column = 0; column < 3; column++) this._attribute(this._transport, SLOTS.aTransport + column, 3, 36, 12 * column);
    gl.drawArrays(gl.TRIANGLES, 0, this.count);
    for (let slot = 0; slot < 4; slot++) gl.disableVertexAttribArray(slot);
  }

  /** Behind everything: along a ray of the view, what the unturned sky holds along R^T of it. */
  _drawSky(aspect) {
    const gl = this.gl, tangent = Math.tan(FIELD_OF_VIEW / 2), { axes } = this.camera();
    const rays = [axes[0].map((v) => v * tangent * aspect), axes[1].map((v) => v * tangent), axes[2].map((v) => -v)];
    const turned = rays.flatMap((ray) => [0, 1, 2].map((k) => this.turn.reduce((sum, row, i) => sum + row[k] * ray[i], 0)));
    gl.useProgram(this._skyProgram);
    gl.uniformMatrix3fv(gl.getUniformLocation(this._skyProgram, "uRays"), false, turned);
    gl.bindTexture(gl.TEXTURE_CUBE_MAP, this._sky);
    this._attribute(this._screen, SLOTS.aCorner, 2);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disableVertexAttribArray(SLOTS.aCorner);
  }

  /** World to clip space, column by column. */
  _matrix(aspect) {
    const { eye, axes, distance } = this.camera(), scale = 1 / Math.tan(FIELD_OF_VIEW / 2);
    const near = distance - 1.01 * this.radius, far = distance + 1.01 * this.radius;
    const moved = axes.map((axis) => -axis.reduce((sum, v, k) => sum + v * eye[k], 0));
    const rows = axes.map((axis, i) => [...axis, moved[i]]);
    const clip = [
      rows[0].map((v) => v * scale / aspect),
      rows[1].map((v) => v * scale),
      rows[2].map((v, k) => (v * (far + near) + (k === 3 ? 2 * far * near : 0)) / (near - far)),
      rows[2].map((v) => -v),
    ];
    return [0, 1, 2, 3].flatMap((column) => clip.map((row) => row[column]));
  }

  _buffer(values) {
    const gl = this.gl, buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    return buffer;
  }

  _attribute(buffer, slot, size, stride = 0, offset = 0) {
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(slot);
    gl.vertexAttribPointer(slot, size, gl.FLOAT, false, stride, offset);
  }
}
