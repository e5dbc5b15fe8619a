// SPDX-License-Identifier: MIT
// A mesh on the graphics card: what all its instances share, which is its shape.

import { buffer, type GL } from "./gl.js";
import type { Mesh } from "./model.js";
import { DIRECT_STRIDE, type Side } from "./transport.js";

export interface Attribute {
  readonly values: WebGLBuffer;
  /** Numbers a vertex. */
  readonly width: number;
  /** Bytes, where the attribute is one of several whole numbers of two bytes, which begin at an offset. */
  readonly stride?: number;
  readonly offset?: number;
}

export class GpuMesh {
  /** In the order of `ATTRIBUTES`; null are the light on both sides, which is each instance's own, and what the mesh has not. */
  readonly attributes: readonly (Attribute | null)[];
  readonly triangles: WebGLBuffer;

  constructor(private readonly gl: GL, { positions, coordinates, normals, material, transport, triangles }: Mesh) {
    const floats = (data: Float32Array | null, width: number) => data && { values: this.values(data), width };
    const isBent = material.normalTexture !== null, directOf = (side: Side | null | undefined) => {
      const values = (material.gloss || isBent) && side?.direct ? this.values(side.direct) : null;
      return [0, 8, 16].map((offset) => values && { values, width: 3, stride: 2 * DIRECT_STRIDE, offset });
    };
    this.attributes = [
      floats(positions, 3), null, null, ...coordinates.map((data) => floats(data, 2)), isBent || material.gloss || transport ? floats(normals, 3) : null,
      ...directOf(transport), ...directOf(transport?.backs),
    ];
    this.triangles = buffer(gl, gl.ELEMENT_ARRAY_BUFFER, triangles as Uint32Array<ArrayBuffer>);
  }

  private values(data: Float32Array | Int16Array): WebGLBuffer {
    return buffer(this.gl, this.gl.ARRAY_BUFFER, data as Float32Array<ArrayBuffer>);
  }
}
