// SPDX-License-Identifier: MIT
// Draws a model under a light, before its sky. Made anew when the browser loses its graphics.

import { type Light, type Matrix3, scaled, turned } from "@prt-relight/core";
import { Backdrop } from "./backdrop.js";
import { coarsened } from "./coarse.js";
import { Display } from "./display.js";
import { Drawables } from "./drawables.js";
import type { GL } from "./gl.js";
import { isMirrored, type Matrix4, product } from "./matrix4.js";
import { MirroredSky } from "./mirrored_sky.js";
import type { Instance, Material, Model } from "./model.js";
import type { Orbit } from "./orbit.js";
import type { Quality } from "./pace.js";
import { Shadows } from "./shadows.js";
import type { Sky } from "./sky.js";
import { type SeenLight, type Shading, Surfaces, type Surroundings } from "./surfaces.js";
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

/** What is drawn of an instance at once. */
interface Part {
  readonly instance: Instance;
  readonly material: Material;
}

/** The light of a sky as a frame has it. */
function seenOf({ sky, turn }: Frame): SeenLight {
  const seen = (light: Light) => scaled(turned(light, turn), sky.strength);
  const whole = seen(sky.light), lamps = sky.suns.length ? seen(sky.lamps) : null;
  return { whole, lamps, soft: lamps ? whole.map((value, k) => value - lamps[k]!) : whole };
}

const SOLID = 0.99; // alpha, from which on a texel of what is clear hides what is behind

/** Of what is clear the texels that are not: drawn before what is seen through the others, they need no order. */
function solidPart(instance: Instance): Part[] {
  const { material } = instance.mesh;
  if (material.alpha !== "BLEND") return [{ instance, material }];
  return material.texture ? [{ instance, material: { ...material, alpha: "MASK", cutoff: SOLID } }] : [];
}

export class Renderer {
  private readonly surfaces: Surfaces;
  private readonly backdrop: Backdrop;
  private readonly mirrored: MirroredSky;
  private readonly shadows: Shadows;
  private readonly display: Display;
  private readonly solid: readonly Part[];
  private readonly clear: readonly Part[];
  private readonly fine: Drawables;
  private coarse: Drawables | null = null;
  private target: Target | null = null;

  constructor(private readonly gl: GL, private readonly model: Model) {
    const { instances } = model;
    if (!gl.getExtension("EXT_color_buffer_float") && !gl.getExtension("EXT_color_buffer_half_float")) {
      throw new Error("This browser's graphics cannot draw light that is brighter than white: this is a still picture of the scene.");
    }
    gl.getExtension("EXT_float_blend");
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.surfaces = new Surfaces(gl);
    this.backdrop = new Backdrop(gl);
    this.mirrored = new MirroredSky(gl, this.backdrop);
    this.shadows = new Shadows(gl, this.surfaces, model);
    this.display = new Display(gl);
    this.solid = instances.flatMap(solidPart);
    this.clear = instances.filter(({ mesh }) => mesh.material.alpha === "BLEND").map((instance) => ({ instance, material: instance.mesh.material }));
    this.fine = new Drawables(gl, model);
  }

  /** Draws a frame into the canvas, of which a share is covered from below. */
  draw(frame: Frame, orbit: Orbit, covered: number, quality: Quality): void {
    const { drawingBufferWidth: width, drawingBufferHeight: height } = this.gl, { target } = this;
    if (!target || target.width !== width || target.height !== height || target.samples !== quality.samples) {
      target?.dispose();
      this.target = new Target(this.gl, width, height, quality.samples);
    }
    this.drawInto(this.target!, frame, orbit, covered, quality.coarse, quality);
    this.display.show(this.target!.finished(), frame.exposure, frame.table);
  }

  /**
   * Linear light of a frame, four floats a pixel, the lowest row first. Alpha is 0 where nothing is; the sky is left out. Coarse is what
   * is drawn of movements on slow machines.
   */
  radiance(frame: Frame, orbit: Orbit, width: number, height: number, coarse: boolean): Float32Array {
    const target = new Target(this.gl, width, height, 1, true);
    this.drawInto(target, frame, orbit, 0, coarse, null);
    const pixels = target.read();
    target.dispose();
    return pixels;
  }

  /** Draws what is solid, the nearest object first, the sky where nothing is (if its quality is given), and what can be seen through, the farthest first. */
  private drawInto(target: Target, frame: Frame, orbit: Orbit, covered: number, coarse: boolean, sky: Quality | null): void {
    const { gl } = this, aspect = target.width / target.height, clip = orbit.clip(aspect, covered), eye = orbit.position;
    const distance = ({ instance: { centre } }: Part) => Math.hypot(...centre.map((value, k) => value - eye[k]!));
    const baked = frame.shading !== "unshadowed", light = seenOf(frame), drawables = this.lit(coarse, light, baked);
    const suns = baked ? this.shadows.of(frame.sky, frame.turn, drawables, coarse) : null;
    const surroundings = { ...frame, coarse, suns, eye: orbit.eye, light, mirrored: this.mirroredSky(frame) };
    const draw = (part: Part) => this.drawPart(drawables, part, product(clip, part.instance.world), surroundings);
    target.begin();
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    [...this.solid].sort((a, b) => distance(a) - distance(b)).forEach(draw); // what is hidden is not shaded
    if (sky) this.backdrop.draw(frame.sky, frame.turn, orbit, aspect, covered, sky.smoothSky);
    [...this.clear].sort((a, b) => distance(b) - distance(a)).forEach(draw);
    gl.disable(gl.BLEND);
    gl.disable(gl.CULL_FACE);
  }

  /** Made before anything is drawn, and only if something mirrors it. */
  private mirroredSky({ sky, shading }: Frame): WebGLTexture | null {
    const isSeen = shading !== "light" && this.model.instances.some(({ mesh }) => mesh.material.gloss);
    return isSeen ? this.mirrored.textureOf(sky) : null;
  }

  private drawPart(drawables: Drawables, { instance, material }: Part, place: Matrix4, surroundings: Surroundings): void {
    const { gl } = this;
    this.surfaces.begin(instance, material, place, surroundings);
    gl.frontFace(isMirrored(instance.world) ? gl.CW : gl.CCW);
    drawables.draw(instance);
  }

  /** What is drawn, under the light of a frame. Coarse meshes are made when they are first drawn. */
  private lit(coarse: boolean, { whole, lamps }: SeenLight, baked: boolean): Drawables {
    const drawables = coarse ? (this.coarse ??= new Drawables(this.gl, this.model, coarsened(this.model))) : this.fine;
    drawables.relight(whole, lamps, baked);
    return drawables;
  }
}
