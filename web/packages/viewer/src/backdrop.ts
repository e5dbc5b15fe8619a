// SPDX-License-Identifier: MIT
// The sky behind the scene: drawn where nothing solid is.

import { type Matrix3, multiplied } from "@prt-relight/core";
import { bindTexture, compiled, type GL, type Program, smooth, texture } from "./gl.js";
import type { Orbit } from "./orbit.js";
import { SKY_CELLS, SKY_FRAGMENT, SKY_QUICK_FRAGMENT, SKY_QUICK_VERTEX, SKY_VERTEX } from "./shaders.js";
import type { Sky } from "./sky.js";

const MOST_WIDTH = 4096;
const MOST_LIGHT = 65504; // that a half float holds

export class Backdrop {
  private readonly fine: Program;
  private readonly quick: Program;
  private of: Sky | null = null;
  private picture: WebGLTexture | null = null;

  constructor(private readonly gl: GL) {
    this.fine = compiled(gl, SKY_VERTEX, SKY_FRAGMENT);
    this.quick = compiled(gl, SKY_QUICK_VERTEX, SKY_QUICK_FRAGMENT);
  }

  /** Along w, the sky shows what its picture holds along `turn` w. */
  draw(sky: Sky, turn: Matrix3, orbit: Orbit, aspect: number, covered: number, smoothly: boolean): void {
    const { gl } = this, program = smoothly ? this.fine : this.quick, { uniforms } = program;
    gl.disable(gl.CULL_FACE);
    gl.bindVertexArray(null);
    gl.useProgram(program.program);
    gl.uniform3f(uniforms["tangents"]!, ...orbit.skySeen(aspect, covered), covered);
    gl.uniformMatrix3fv(uniforms["toPicture"]!, true, Float32Array.from(multiplied(turn, orbit.rotation)));
    gl.uniform1f(uniforms["strength"]!, sky.strength);
    bindTexture(gl, 0, this.pictureOf(sky), program, "picture");
    gl.drawArrays(gl.TRIANGLES, 0, smoothly ? 3 : 6 * SKY_CELLS[0] * SKY_CELLS[1]);
  }

  /** The sky's picture on the graphics card. */
  pictureOf(sky: Sky): WebGLTexture {
    if (this.picture && this.of === sky) return this.picture;
    const { gl } = this;
    if (this.picture) gl.deleteTexture(this.picture);
    const { width, height, pixels } = sky.picture, step = Math.ceil(width / Math.min(MOST_WIDTH, gl.getParameter(gl.MAX_TEXTURE_SIZE) as number));
    const shown = step > 1 ? thinned(pixels, width, height, step) : pixels;
    this.picture = texture(gl, gl.TEXTURE_2D);
    const held = shown.map((value) => Math.min(value, MOST_LIGHT));
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB16F, Math.floor(width / step), Math.floor(height / step), 0, gl.RGB, gl.FLOAT, held);
    smooth(gl, gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.REPEAT);
    this.of = sky;
    return this.picture;
  }
}

/** Every so many texels of every so many rows. */
function thinned(pixels: Float32Array, width: number, height: number, step: number): Float32Array {
  const columns = Math.floor(width / step), rows = Math.floor(height / step), out = new Float32Array(3 * columns * rows);
  for (let y = 0, k = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++) for (let c = 0; c < 3; c++) out[k++] = pixels[3 * (y * step * width + x * step) + c]!;
  }
  return out;
}
