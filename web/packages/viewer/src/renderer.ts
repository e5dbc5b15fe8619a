// SPDX-License-Identifier: MIT
// Draws a model under a light, before its sky. Made anew when the browser loses its graphics.

import { type Light, type Matrix3, scaled, turned } from "@prt-relight/core";
import { Backdrop } from "./backdrop.js";
import { Display } from "./display.js";
import type { GL } from "./gl.js";
import { GpuInstance } from "./gpu_instance.js";
import { GpuMesh } from "./gpu_mesh.js";
import { isMirrored, type Matrix4, product } from "./matrix4.js";
import { MirroredSky } from "./mirrored_sky.js";
import type { Instance, Mesh, Model } from "./model.js";
import type { Orbit } from "./orbit.js";
import type { Quality } from "./pace.js";
import type { Sky } from "./sky.js";
import { type Shading, Surfaces, type Surroundings } from "./surfaces.js";
import { Target } from "./target.js";

/** What a frame shows, and how. */
export interface Frame {
  readonly sky: Sky;
  /** Along w, the sky shows what its picture holds along `turn` w. */
  readonly turn: Matrix3;
  readonly exposure: number;
  readonly shading: Shading;
  /** A table's bytes, red fastest; null for the view transform Standard. */
  readonly table: Uint8Array | null;
}

export class Renderer {
  private readonly surfaces: Surfaces;
  private readonly backdrop: Backdrop;
  private readonly mirrored: MirroredSky;
  private readonly display: Display;
  private readonly solid: readonly Instance[];
  private readonly clear: readonly Instance[];
  private readonly instances = new Map<Instance, GpuInstance>();
  private target: Target | null = null;
  private lit: { readonly light: Light; readonly baked: boolean } | null = null;

  constructor(private readonly gl: GL, { instances }: Model) {
    if (!gl.getExtension("EXT_color_buffer_float") && !gl.getExtension("EXT_color_buffer_half_float")) {
      throw new Error("This browser's graphics cannot draw light that is brighter than white: this is a still picture of the scene.");
    }
    gl.getExtension("EXT_float_blend");
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.surfaces = new Surfaces(gl);
    this.backdrop = new Backdrop(gl);
    this.mirrored = new MirroredSky(gl, this.backdrop);
    this.display = new Display(gl);
    this.solid = instances.filter(({ mesh }) => mesh.material.alpha !== "BLEND");
    this.clear = instances.filter(({ mesh }) => mesh.material.alpha === "BLEND");
    const meshes = new Map<Mesh, GpuMesh>();
    for (const instance of instances) {
      const mesh = meshes.get(instance.mesh) ?? new GpuMesh(gl, instance.mesh);
      meshes.set(instance.mesh, mesh);
      this.instances.set(instance, new GpuInstance(gl, instance, mesh));
    }
  }

  /** Draws a frame into the canvas, of which a share is covered from below. */
  draw(frame: Frame, orbit: Orbit, covered: number, quality: Quality): void {
    const { drawingBufferWidth: width, drawingBufferHeight: height } = this.gl, { target } = this;
    if (!target || target.width !== width || target.height !== height || target.samples !== quality.samples) {
      target?.dispose();
      this.target = new Target(this.gl, width, height, quality.samples);
    }
    this.drawInto(this.target!, frame, orbit, covered, quality);
    this.display.show(this.target!.finished(), frame.exposure, frame.table);
  }

  /**
   * Linear light of a frame, four floats a pixel, the lowest row first. Alpha is 0 where nothing is; the sky is left out.
   */
  radiance(frame: Frame, orbit: Orbit, width: number, height: number): Float32Array {
    const target = new Target(this.gl, width, height, 1, true);
    this.drawInto(target, frame, orbit, 0, null);
    const pixels = target.read();
    target.dispose();
    return pixels;
  }

  /** Draws what is solid, the sky where nothing is (if its quality is given), and what can be seen through, the farthest first. */
  private drawInto(target: Target, frame: Frame, orbit: Orbit, covered: number, sky: Quality | null): void {
    const { gl } = this, aspect = target.width / target.height, clip = orbit.clip(aspect, covered), eye = orbit.position;
    const distance = ({ centre }: Instance) => Math.hypot(...centre.map((value, k) => value - eye[k]!));
    const surroundings = { ...frame, eye: orbit.eye, mirrored: this.mirroredSky(frame) };
    const draw = (instance: Instance) => this.drawInstance(instance, product(clip, instance.world), surroundings);
    this.relight(frame);
    target.begin();
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    this.solid.forEach(draw);
    if (sky) this.backdrop.draw(frame.sky, frame.turn, orbit, aspect, covered, sky.smoothSky);
    [...this.clear].sort((a, b) => distance(b) - distance(a)).forEach(draw);
    gl.disable(gl.BLEND);
    gl.disable(gl.CULL_FACE);
  }

  /** Made before anything is drawn, and only if something mirrors it. */
  private mirroredSky({ sky, shading }: Frame): WebGLTexture | null {
    const isSeen = shading !== "light" && [...this.instances.keys()].some(({ mesh }) => mesh.material.gloss);
    return isSeen ? this.mirrored.textureOf(sky) : null;
  }

  private drawInstance(instance: Instance, place: Matrix4, surroundings: Surroundings): void {
    const { gl } = this;
    this.surfaces.begin(instance, place, surroundings);
    gl.frontFace(isMirrored(instance.world) ? gl.CW : gl.CCW);
    this.instances.get(instance)!.draw();
  }

  /** Sums the light of all vertices, unless it is as in the frame before. */
  private relight({ sky, turn, shading }: Frame): void {
    const light = scaled(turned(sky.light, turn), sky.strength), baked = shading !== "unshadowed";
    if (this.lit && this.lit.baked === baked && this.lit.light.every((value, k) => value === light[k])) return;
    for (const instance of this.instances.values()) instance.relight(light, baked);
    this.lit = { light, baked };
  }
}

