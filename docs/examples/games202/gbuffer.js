// SPDX-License-Identifier: GPL-3.0-or-later
// GBuffer keeps what the camera sees first in each pixel: depth, normal, albedo, and the direct light that leaves there.
"use strict";

const GBUFFER_SHADERS = [
  `#version 300 es
   in vec3 aPlace, aNormal, aAlbedo;
   in mat3 aTransport;
   uniform mat4 uCamera;
   uniform mat4 uView; // its last row is not used
   uniform mat3 uLight[3];
   out vec3 vNormal, vAlbedo, vLight;
   out float vDepth;
   ${CARRIED}
   void main() {
     gl_Position = uCamera * vec4(aPlace, 1.0);
     vDepth = -(uView * vec4(aPlace, 1.0)).z;
     vNormal = mat3(uView) * aNormal;
     vAlbedo = aAlbedo;
     vLight = vec3(carried(aTransport, uLight[0]), carried(aTransport, uLight[1]), carried(aTransport, uLight[2]));
   }`,
  `#version 300 es
   precision highp float;
   in vec3 vNormal, vAlbedo, vLight;
   in float vDepth;
   layout(location = 0) out vec4 surface;
   layout(location = 1) out vec4 albedo;
   layout(location = 2) out vec4 direct;
   void main() {
     surface = vec4(normalize(vNormal), vDepth);
     albedo = vec4(vAlbedo, 1.0);
     direct = vec4(vAlbedo * max(vLight, 0.0), 1.0);
   }`,
];
const GBUFFER_SLOTS = { aPlace: 0, aTransport: 1, aNormal: 4, aAlbedo: 5 };

class GBuffer {
  /** Of a WebGL 2 context. */
  constructor(gl) {
    if (!gl.getExtension("EXT_color_buffer_float")) throw new Error("This browser draws no floats: try another, or another graphics driver.");
    this.gl = gl;
    this._program = linkedProgram(gl, GBUFFER_SHADERS, GBUFFER_SLOTS);
    this._target = gl.createFramebuffer();
  }

  setScene({ places, normals, albedos }, transport) {
    this.count = places.length / 3;
    this._fed = [["aPlace", places, 3], ["aTransport", transport, 9], ["aNormal", normals, 3], ["aAlbedo", albedos, 3]].map(
      ([name, values, size]) => [filledBuffer(this.gl, values), GBUFFER_SLOTS[name], size]);
  }

  /** Fill it under a light of nine [r, g, b]; what was bound is bound again. */
  draw(camera, light, width, height) {
    const gl = this.gl, before = gl.getParameter(gl.FRAMEBUFFER_BINDING), uniform = (name) => gl.getUniformLocation(this._program, name);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this._target);
    this._resize(width, height);
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this._program);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.uniformMatrix4fv(uniform("uCamera"), false, camera.matrix(width / height));
    gl.uniformMatrix4fv(uniform("uView"), true, [...camera.view().flat(), 0, 0, 0, 1]);
    gl.uniformMatrix3fv(uniform("uLight"), false, Harmonics.byChannel(light));
    for (const [buffer, slot, size] of this._fed) feed(gl, buffer, slot, size);
    drawFed(gl, this.count, 6);
    gl.bindFramebuffer(gl.FRAMEBUFFER, before);
  }

  /** Hand its textures to a program by their names, in the units 1 to 3: normal and depth (0: nothing is seen), albedo, direct. */
  bind(program, names) {
    names.forEach((name, i) => {
      this.gl.activeTexture(this.gl.TEXTURE1 + i);
      this.gl.bindTexture(this.gl.TEXTURE_2D, this._textures[i]);
      this.gl.uniform1i(this.gl.getUniformLocation(program, name), 1 + i);
    });
  }

  /** New textures, if the size is another. */
  _resize(width, height) {
    if (this._size === `${width} x ${height}`) return;
    const gl = this.gl, depth = gl.createRenderbuffer();
    this._size = `${width} x ${height}`;
    for (const old of this._textures ?? []) gl.deleteTexture(old);
    gl.deleteRenderbuffer(this._depth);
    this._depth = depth;
    this._textures = [gl.RGBA32F, gl.RGBA8, gl.RGBA32F].map((format, i) => {
      const texture = gl.createTexture();
      gl.activeTexture(gl.TEXTURE1 + i);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0);
      return texture;
    });
    gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1, gl.COLOR_ATTACHMENT2]);
  }
}
