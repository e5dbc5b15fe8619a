// SPDX-License-Identifier: MIT
// The view transform: from linear light to the screen, at the end of each frame.

import { compiled, type GL, type Program, smooth, texture } from "./gl.js";
import { DISPLAY_FRAGMENT, DISPLAY_VERTEX } from "./shaders.js";

export class Display {
  private readonly program: Program;
  private readonly tables = new Map<Uint8Array, WebGLTexture>();

  constructor(private readonly gl: GL) {
    this.program = compiled(gl, DISPLAY_VERTEX, DISPLAY_FRAGMENT);
  }

  /** Shows light on the canvas; exposure is in stops, a table null for the view transform Standard. */
  show(light: WebGLTexture, exposure: number, table: Uint8Array | null): void {
    const { gl } = this, { program, uniforms } = this.program;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(null);
    gl.useProgram(program);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, light);
    gl.uniform1i(uniforms["light"]!, 0);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_3D, table && this.tableOf(table));
    gl.uniform1i(uniforms["table"]!, 1);
    gl.uniform1i(uniforms["asks"]!, Number(table !== null));
    gl.uniform1f(uniforms["exposure"]!, 2 ** exposure);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  private tableOf(table: Uint8Array): WebGLTexture {
    const known = this.tables.get(table);
    if (known) return known;
    const { gl } = this, size = Math.round(Math.cbrt(table.length / 3)), made = texture(gl, gl.TEXTURE_3D);
    gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGB8, size, size, size, 0, gl.RGB, gl.UNSIGNED_BYTE, table);
    smooth(gl, gl.TEXTURE_3D);
    this.tables.set(table, made);
    return made;
  }
}
