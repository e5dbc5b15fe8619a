// SPDX-License-Identifier: MIT
// The sky as mirrors of all roughnesses show it: made once for each sky, in the levels of a texture.

import type { Backdrop } from "./backdrop.js";
import { bindTexture, compiled, type GL, type Program, texture } from "./gl.js";
import { MIRROR_FRAGMENT, ROUGHNESSES } from "./gloss_shaders.js";
import { DISPLAY_VERTEX, HEAD } from "./shaders.js";
import type { Sky } from "./sky.js";

const WIDTH = 512, HEIGHT = 256;
const BRIGHTEST = 10; // what is brighter, EEVEE takes out of the sky that it mirrors

export class MirroredSky {
  private readonly program: Program;
  private of: Sky | null = null;
  private made: WebGLTexture | null = null;

  constructor(private readonly gl: GL, private readonly backdrop: Backdrop) {
    this.program = compiled(gl, DISPLAY_VERTEX, HEAD + MIRROR_FRAGMENT);
  }

  textureOf(sky: Sky): WebGLTexture {
    if (this.made && this.of === sky) return this.made;
    const { gl } = this, small = this.empty(Math.log2(WIDTH) + 1);
    gl.useProgram(this.program.program);
    gl.uniform1f(this.program.uniforms["brightest"]!, BRIGHTEST / Math.max(sky.strength, 1e-6));
    this.draw(this.backdrop.pictureOf(sky), small, 0, 0);
    gl.bindTexture(gl.TEXTURE_2D, small);
    gl.generateMipmap(gl.TEXTURE_2D);
    if (this.made) gl.deleteTexture(this.made);
    this.made = this.empty(ROUGHNESSES);
    for (let level = 0; level < ROUGHNESSES; level++) this.draw(small, this.made, level, level / (ROUGHNESSES - 1));
    gl.deleteTexture(small);
    this.of = sky;
    return this.made;
  }

  private empty(levels: number): WebGLTexture {
    const { gl } = this, made = texture(gl, gl.TEXTURE_2D);
    gl.texStorage2D(gl.TEXTURE_2D, levels, gl.RGBA16F, WIDTH, HEIGHT);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.REPEAT);
    return made;
  }

  /** Draws a picture, as a mirror of some roughness shows it, into a level of a texture. */
  private draw(picture: WebGLTexture, into: WebGLTexture, level: number, roughness: number): void {
    const { gl } = this, { program, uniforms } = this.program, width = WIDTH >> level, height = HEIGHT >> level;
    const framebuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, into, level);
    gl.viewport(0, 0, width, height);
    gl.bindVertexArray(null);
    gl.useProgram(program);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    gl.uniform1f(uniforms["roughness"]!, roughness);
    gl.uniform2f(uniforms["size"]!, width, height);
    bindTexture(gl, 0, picture, this.program, "picture");
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.deleteFramebuffer(framebuffer);
  }
}
