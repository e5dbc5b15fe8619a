// SPDX-License-Identifier: MIT
// A mesh on the graphics card: what all its instances share, which is its shape.

import { buffer, type GL } from "./gl.js";
import type { Mesh } from "./model.js";

export interface Attribute {
  readonly values: WebGLBuffer;
  /** Floats a vertex. */
  readonly width: number;
}

export class GpuMesh {
  readonly positions: Attribute;
  readonly coordinates: readonly (Attribute | null)[];
  readonly triangles: WebGLBuffer;

  constructor(private readonly gl: GL, mesh: Mesh) {
    this.positions = this.attribute(mesh.positions, 3);
    this.coordinates = mesh.coordinates.map((data) => data && this.attribute(data, 2));
    this.triangles = buffer(gl, gl.ELEMENT_ARRAY_BUFFER, mesh.triangles as Uint32Array<ArrayBuffer>);
  }

  private attribute(data: Float32Array, width: number): Attribute {
    return { values: buffer(this.gl, this.gl.ARRAY_BUFFER, data as Float32Array<ArrayBuffer>), width };
  }
}
