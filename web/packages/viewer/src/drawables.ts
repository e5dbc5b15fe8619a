// SPDX-License-Identifier: MIT
// All instances of a model on the graphics card, in one fineness, under one light.

import type { Light } from "@prt-relight/core";
import type { GL } from "./gl.js";
import { GpuInstance } from "./gpu_instance.js";
import { GpuMesh } from "./gpu_mesh.js";
import type { Instance, Mesh, Model } from "./model.js";

export class Drawables {
  private readonly instances = new Map<Instance, GpuInstance>();
  private lit: { readonly light: Light; readonly baked: boolean } | null = null;

  /** With each mesh as it is, or as another stands for it. */
  constructor(gl: GL, { instances }: Model, stands: ReadonlyMap<Mesh, Mesh> | null = null) {
    const meshes = new Map<Mesh, GpuMesh>();
    for (const instance of instances) {
      const mesh = stands?.get(instance.mesh) ?? instance.mesh, made = meshes.get(mesh) ?? new GpuMesh(gl, mesh);
      meshes.set(mesh, made);
      this.instances.set(instance, new GpuInstance(gl, { ...instance, mesh }, made));
    }
  }

  /** Sums the light of all vertices, unless it is as before; that which is baked without the direct light of lamps. */
  relight(light: Light, lamps: Light | null, baked: boolean): void {
    if (this.lit && this.lit.baked === baked && this.lit.light.every((value, k) => value === light[k])) return;
    for (const instance of this.instances.values()) instance.relight(light, lamps, baked);
    this.lit = { light, baked };
  }

  draw(instance: Instance): void {
    this.instances.get(instance)!.draw();
  }
}
