// SPDX-License-Identifier: MIT
// A mesh on the graphics card: attributes, triangles, and transport in a texture that the vertex shader reads by number.

import { ATTRIBUTES, buffer, type GL, texture } from "./gl.js";
import type { Mesh } from "./model.js";
import { NUMBERS } from "./transport.js";

const TEXELS = NUMBERS / 3; // a vertex
const WIDTH = 4095; // of the texture: a multiple of the nine, and no larger than any card allows

export class GpuMesh {
  readonly transport: WebGLTexture | null;
  private readonly vertices: WebGLVertexArrayObject;
  private readonly count: number;

  constructor(private readonly gl: GL, mesh: Mesh) {
    this.vertices = gl.createVertexArray();
    this.count = mesh.triangles.length;
    gl.bindVertexArray(this.vertices);
    const given = [mesh.positions, mesh.normals, mesh.coordinates[0], mesh.coordinates[1]];
    ATTRIBUTES.forEach((_, index) => {
      const data = given[index];
      if (!data) return;
      buffer(gl, gl.ARRAY_BUFFER, data as Float32Array<ArrayBuffer>);
      gl.enableVertexAttribArray(index);
      gl.vertexAttribPointer(index, data.length / mesh.vertices, gl.FLOAT, false, 0, 0);
    });
    buffer(gl, gl.ELEMENT_ARRAY_BUFFER, mesh.triangles as Uint32Array<ArrayBuffer>);
    gl.bindVertexArray(null);
    this.transport = mesh.transport ? upload(gl, mesh.transport.numbers) : null;
  }

  draw(): void {
    this.gl.bindVertexArray(this.vertices);
    this.gl.drawElements(this.gl.TRIANGLES, this.count, this.gl.UNSIGNED_INT, 0);
  }
}

function upload(gl: GL, numbers: Int16Array): WebGLTexture {
  const texels = numbers.length / 3, width = Math.min(WIDTH, Math.max(texels, TEXELS)), height = Math.ceil(texels / width);
  const padded = new Int16Array(3 * width * height);
  padded.set(numbers);
  const made = texture(gl, gl.TEXTURE_2D);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB16I, width, height, 0, gl.RGB_INTEGER, gl.SHORT, padded);
  return made;
}
