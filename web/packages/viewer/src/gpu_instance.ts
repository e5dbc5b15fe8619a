// SPDX-License-Identifier: MIT
// An instance on the graphics card: a mesh, and the light of its vertices, which is summed anew when the light changes.

import { type Light, sumTransport, sumUnshadowed, takeLamps, turned } from "@prt-relight/core";
import { ATTRIBUTES, type GL } from "./gl.js";
import type { Attribute, GpuMesh } from "./gpu_mesh.js";
import { normalMatrix } from "./matrix4.js";
import type { Instance } from "./model.js";

export class GpuInstance {
  private readonly light: Float32Array<ArrayBuffer>;
  private readonly lightBuffer: WebGLBuffer;
  private readonly vertices: WebGLVertexArrayObject;

  constructor(private readonly gl: GL, private readonly instance: Instance, on: GpuMesh) {
    this.light = new Float32Array(3 * instance.mesh.vertices);
    this.lightBuffer = gl.createBuffer();
    this.vertices = gl.createVertexArray();
    gl.bindVertexArray(this.vertices);
    const light = { values: this.lightBuffer, width: 3 };
    on.attributes.forEach((shared, index) => {
      const attribute: Attribute | null = ATTRIBUTES[index] === "light" ? light : shared;
      if (!attribute) return;
      const { values, width, stride, offset } = attribute;
      gl.bindBuffer(gl.ARRAY_BUFFER, values);
      gl.enableVertexAttribArray(index);
      gl.vertexAttribPointer(index, width, stride ? gl.SHORT : gl.FLOAT, false, stride ?? 0, offset ?? 0);
    });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, on.triangles);
    gl.bindVertexArray(null);
  }

  /** Lights the vertices, by their transport if there is any and it is wanted: then without the direct light of lamps. */
  relight(light: Light, lamps: Light | null, baked: boolean): void {
    const { gl, instance } = this, { mesh, axes, world } = instance;
    if (baked && mesh.transport) {
      const { numbers, scale, inOwnAxes, direct } = mesh.transport, own = (of: Light) => (inOwnAxes ? turned(of, axes) : of);
      sumTransport(numbers, scale, own(light), this.light);
      if (lamps && direct) takeLamps(direct, scale, own(lamps), this.light);
    } else {
      sumUnshadowed(mesh.normals, normalMatrix(world), light, this.light);
    }
    gl.bindBuffer(gl.ARRAY_BUFFER, this.lightBuffer);
    gl.bufferData(gl.ARRAY_BUFFER, this.light, gl.DYNAMIC_DRAW);
  }

  draw(): void {
    this.gl.bindVertexArray(this.vertices);
    this.gl.drawElements(this.gl.TRIANGLES, this.instance.mesh.triangles.length, this.gl.UNSIGNED_INT, 0);
  }
}
