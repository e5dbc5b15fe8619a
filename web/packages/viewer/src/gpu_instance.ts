// SPDX-License-Identifier: MIT
// An instance on the graphics card: a mesh, and the light of its vertices, which is summed anew when the light changes. Where backs have
// transport of their own there is light on either side.

import { type Light, type Matrix3, sumTransport, sumUnshadowed, takeLamps, turned } from "@prt-relight/core";
import { ATTRIBUTES, type GL } from "./gl.js";
import type { Attribute, GpuMesh } from "./gpu_mesh.js";
import { normalMatrix } from "./matrix4.js";
import type { Instance } from "./model.js";
import type { Side } from "./transport.js";

export class GpuInstance {
  private readonly light: Float32Array<ArrayBuffer>; // of all fronts, then of all backs
  private readonly lightBuffer: WebGLBuffer;
  private readonly vertices: WebGLVertexArrayObject;

  constructor(private readonly gl: GL, private readonly instance: Instance, on: GpuMesh) {
    const sides = instance.mesh.transport?.backs ? 2 : 1, side = 3 * instance.mesh.vertices;
    this.light = new Float32Array(sides * side);
    this.lightBuffer = gl.createBuffer();
    this.vertices = gl.createVertexArray();
    gl.bindVertexArray(this.vertices);
    const light = { values: this.lightBuffer, width: 3 }, behind = sides > 1 ? { ...light, offset: 4 * side } : null;
    on.attributes.forEach((shared, index) => {
      const name = ATTRIBUTES[index], attribute: Attribute | null = name === "light" ? light : name === "behind" ? behind : shared;
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
    const { gl, instance } = this, { mesh: { transport, normals, vertices }, axes, world } = instance;
    const own = (of: Light) => (transport?.inOwnAxes ? turned(of, axes) : of);
    const sides = [this.light.subarray(0, 3 * vertices), this.light.subarray(3 * vertices)].filter((out) => out.length);
    sides.forEach((out, behind) => {
      const side = behind ? transport!.backs : transport;
      if (baked && side) sumSide(side, own(light), lamps && own(lamps), out);
      else sumUnshadowed(normals, normalMatrix(world).map((value) => (behind ? -value : value)) as unknown as Matrix3, light, out);
    });
    gl.bindBuffer(gl.ARRAY_BUFFER, this.lightBuffer);
    gl.bufferData(gl.ARRAY_BUFFER, this.light, gl.DYNAMIC_DRAW);
  }

  draw(): void {
    this.gl.bindVertexArray(this.vertices);
    this.gl.drawElements(this.gl.TRIANGLES, this.instance.mesh.triangles.length, this.gl.UNSIGNED_INT, 0);
  }
}

/** Radiance of white surfaces by what one side of them receives, without the direct light of lamps. */
function sumSide({ numbers, scale, direct }: Side, light: Light, lamps: Light | null, out: Float32Array): void {
  sumTransport(numbers, scale, light, out);
  if (lamps && direct) takeLamps(direct, scale, lamps, out);
}
