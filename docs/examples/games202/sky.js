// SPDX-License-Identifier: GPL-3.0-or-later
// Sky draws a cube map behind everything, as the camera sees it.
"use strict";

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

class Sky {
  constructor(gl) {
    this.gl = gl;
    this._program = linkedProgram(gl, SKY_SHADERS, { aCorner: 0 });
    this._screen = filledBuffer(gl, WHOLE_PICTURE);
  }

  /** Six pictures of one size, in the order of `Files.FACES`. */
  setFaces(pictures) {
    const gl = this.gl;
    this._texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_CUBE_MAP, this._texture);
    pictures.forEach((picture, i) =>
      gl.texImage2D(gl.TEXTURE_CUBE_MAP_POSITIVE_X + i, 0, gl.RGB, gl.RGB, gl.UNSIGNED_BYTE, picture));
    for (const [name, value] of [["MIN_FILTER", "LINEAR"], ["MAG_FILTER", "LINEAR"], ["WRAP_S", "CLAMP_TO_EDGE"], ["WRAP_T", "CLAMP_TO_EDGE"]])
      gl.texParameteri(gl.TEXTURE_CUBE_MAP, gl[`TEXTURE_${name}`], gl[value]);
  }

  /** Along a ray of the view, what the unturned sky holds along R^T of it; nothing, if there are no faces. */
  draw(camera, turn, aspect) {
    if (!this._texture) return;
    const gl = this.gl, { axes } = camera.place(), [across, up] = Camera.tangents(aspect);
    const rays = [axes[0].map((v) => v * across), axes[1].map((v) => v * up), axes[2].map((v) => -v)];
    const turned = rays.flatMap((ray) => [0, 1, 2].map((k) => turn.reduce((sum, row, i) => sum + row[k] * ray[i], 0)));
    gl.useProgram(this._program);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.uniformMatrix3fv(gl.getUniformLocation(this._program, "uRays"), false, turned);
    gl.uniform1i(gl.getUniformLocation(this._program, "uSky"), 0);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_CUBE_MAP, this._texture);
    feed(gl, this._screen, 0, 2);
    drawFed(gl, 3, 1);
  }
}
