// SPDX-License-Identifier: GPL-3.0-or-later
// View is a camera before a sky that turns. What stands in it is drawn by `_drawMesh(width, height, encoded)` of who extends it.
"use strict";

class View {
  constructor(gl) {
    this.gl = gl;
    this.turn = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]; // of the sky
    this.camera = new Camera();
    this._sky = new Sky(gl);
  }

  /** Six pictures of one size, in the order of `Files.FACES`. */
  setSky(pictures) {
    this._sky.setFaces(pictures);
  }

  /** Draw into what is bound; encoded as screens want it, or linear. */
  draw(width, height, encoded = true) {
    const gl = this.gl;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (this.light) this._drawMesh(width, height, encoded);
    this._sky.draw(this.camera, this.turn, width / height);
  }
}
