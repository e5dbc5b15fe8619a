// SPDX-License-Identifier: MIT
// Where scenes are drawn: linear light, which no screen shows. It is blended and smoothed before the view transform, as in EEVEE.

import { type GL, texture } from "./gl.js";

export class Target {
  private readonly drawn: WebGLFramebuffer;
  private readonly shown: WebGLFramebuffer;
  private readonly light: WebGLTexture;
  private readonly parts: WebGLRenderbuffer[] = [];
  private readonly taken: number;

  /** More than one sample a pixel smooths edges, as far as the graphics card takes so many; float32 is for measurements. */
  constructor(private readonly gl: GL, readonly width: number, readonly height: number, readonly samples: number, float32 = false) {
    const format = float32 ? gl.RGBA32F : gl.RGBA16F;
    const most = samples > 1 ? (gl.getInternalformatParameter(gl.RENDERBUFFER, format, gl.SAMPLES) as Int32Array)[0] ?? 1 : 1;
    this.taken = Math.min(samples, most);
    this.light = texture(gl, gl.TEXTURE_2D);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    this.shown = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shown);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.light, 0);
    this.drawn = this.taken > 1 ? gl.createFramebuffer() : this.shown;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.drawn);
    if (this.taken > 1) this.attach(gl.COLOR_ATTACHMENT0, format);
    this.attach(gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24);
  }

  /** Makes it the one that is drawn into, empty. */
  begin(): void {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.drawn);
    gl.viewport(0, 0, this.width, this.height);
    gl.clearColor(0, 0, 0, 0);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  /** What has been drawn. */
  finished(): WebGLTexture {
    const { gl, width, height } = this;
    if (this.taken > 1) {
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.drawn);
      gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, this.shown);
      gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    }
    return this.light;
  }

  /** Four floats a pixel, the lowest row first. */
  read(): Float32Array {
    const { gl, width, height } = this, pixels = new Float32Array(4 * width * height);
    this.finished();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shown);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, pixels);
    return pixels;
  }

  dispose(): void {
    const { gl } = this;
    for (const part of this.parts) gl.deleteRenderbuffer(part);
    gl.deleteTexture(this.light);
    for (const framebuffer of new Set([this.drawn, this.shown])) gl.deleteFramebuffer(framebuffer);
  }

  private attach(where: number, format: number): void {
    const { gl } = this, part = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, part);
    gl.renderbufferStorageMultisample(gl.RENDERBUFFER, this.taken > 1 ? this.taken : 0, format, this.width, this.height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, where, gl.RENDERBUFFER, part);
    this.parts.push(part);
  }
}
