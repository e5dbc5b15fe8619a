// SPDX-License-Identifier: GPL-3.0-or-later
// Viewer draws a mesh by its transport in WebGL 1: one dot product per vertex and channel, as the homework has it.
"use strict";

const CARRIED = `float carried(mat3 transport, mat3 light) { // both nine numbers: their product is the light that leaves
     return dot(transport[0], light[0]) + dot(transport[1], light[1]) + dot(transport[2], light[2]);
   }`;
const MESH_SHADERS = [
  `attribute vec3 aPlace;
   attribute mat3 aTransport;
   uniform mat4 uCamera;
   uniform mat3 uLight[3];
   varying vec3 vColour;
   ${CARRIED}
   void main() {
     gl_Position = uCamera * vec4(aPlace, 1.0);
     vColour = vec3(carried(aTransport, uLight[0]), carried(aTransport, uLight[1]), carried(aTransport, uLight[2]));
   }`,
  `precision highp float;
   varying vec3 vColour;
   uniform bool uEncoded;
   ${ENCODED}
   void main() {
     vec3 linear = max(vColour, 0.0);
     gl_FragColor = vec4(uEncoded ? encoded(linear) : linear, 1.0);
   }`,
];
const MESH_SLOTS = { aPlace: 0, aTransport: 1 }; // a mat3 fills three

class Viewer extends View {
  constructor(gl) {
    super(gl);
    this._program = linkedProgram(gl, MESH_SHADERS, MESH_SLOTS);
  }

  /** A mesh of `Files`, nine numbers of transport for each of its corners, and the light as nine [r, g, b]. */
  setScene({ places }, transport, light) {
    this.camera.lookAt(places);
    this.count = places.length / 3;
    this.light = light;
    this._places = filledBuffer(this.gl, places);
    this._transport = filledBuffer(this.gl, transport);
  }

  _drawMesh(width, height, encoded) {
    const gl = this.gl, uniform = (name) => gl.getUniformLocation(this._program, name);
    gl.useProgram(this._program);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.uniformMatrix4fv(uniform("uCamera"), false, this.camera.matrix(width / height));
    gl.uniformMatrix3fv(uniform("uLight"), false, Harmonics.byChannel(Harmonics.turned(this.light, this.turn)));
    gl.uniform1i(uniform("uEncoded"), encoded ? 1 : 0);
    feed(gl, this._places, MESH_SLOTS.aPlace, 3);
    feed(gl, this._transport, MESH_SLOTS.aTransport, 9);
    drawFed(gl, this.count, 4);
  }
}
