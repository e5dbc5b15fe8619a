// SPDX-License-Identifier: MIT
// Shadow maps of the sky's suns: how far each sees, as a layer of one texture. Drawn anew when the sky turns, not when the camera moves.

import { applied, type Matrix3, transposed, type Vector3 } from "@prt-relight/core";
import type { Drawables } from "./drawables.js";
import type { GL } from "./gl.js";
import { type Matrix4, product } from "./matrix4.js";
import type { Instance, Model } from "./model.js";
import type { SunEntry } from "./page.js";
import type { Sky } from "./sky.js";
import { MOST_SUNS } from "./sun_shaders.js";
import type { Surfaces } from "./surfaces.js";

const FINE = 2048, COARSE = 1024; // texels of a map, along each side

/** The suns of a sky as it is turned. */
export interface Suns {
  /** Unit vectors towards them, three numbers each. */
  readonly directions: Float32Array;
  readonly irradiances: Float32Array;
  /** Tangents of their radii. */
  readonly radii: Float32Array;
  /** From the world to each one's map, in 0 to 1, whose depth is in units of the map's width: four columns of four each. */
  readonly places: Float32Array;
  readonly count: number;
  readonly maps: WebGLTexture;
  /** Half of what a map shows across, in the world's units. */
  readonly reach: number;
}

export class Shadows {
  private readonly casters: readonly Instance[];
  private readonly centre: Vector3;
  private readonly reach: number;
  private readonly maps = new Map<number, WebGLTexture>();
  private drawn: { readonly sky: Sky; readonly turn: Matrix3; readonly coarse: boolean; readonly suns: Suns } | null = null;

  constructor(private readonly gl: GL, private readonly surfaces: Surfaces, { instances, least, most }: Model) {
    this.casters = instances;
    this.centre = [0, 1, 2].map((k) => (least[k]! + most[k]!) / 2) as unknown as Vector3;
    this.reach = (Math.hypot(most[0] - least[0], most[1] - least[1], most[2] - least[2]) / 2 || 1) * 1.01;
  }

  /** The suns of a sky, with maps of what they see of these drawables; null if it has none. */
  of(sky: Sky, turn: Matrix3, drawables: Drawables, coarse: boolean): Suns | null {
    const suns = sky.suns.slice(0, MOST_SUNS), last = this.drawn;
    if (!suns.length) return null;
    if (last && last.sky === sky && last.coarse === coarse && last.turn.every((value, k) => value === turn[k])) return last.suns;
    const towards = suns.map(({ direction }) => applied(transposed(turn), direction)), places = towards.map((sun) => this.placeOf(sun));
    const maps = this.mapsOf(coarse ? COARSE : FINE, coarse);
    this.draw(maps, coarse ? COARSE : FINE, places, drawables);
    const made: Suns = {
      directions: Float32Array.from(towards.flat()),
      irradiances: Float32Array.from(suns.flatMap(({ irradiance }: SunEntry) => irradiance.map((value) => value * sky.strength))),
      radii: Float32Array.from(suns, ({ radius }) => Math.tan(radius)),
      places: Float32Array.from(places.flatMap((place) => [...place])),
      count: suns.length, maps, reach: this.reach,
    };
    this.drawn = { sky, turn, coarse, suns: made };
    return made;
  }

  /** From the world to what WebGL clips, seen from a sun far away. */
  private placeOf(sun: Vector3): Matrix4 {
    const [x, y, z] = sun, side: Vector3 = Math.abs(z) < 0.9 ? [-y, x, 0] : [0, -z, y], length = Math.hypot(...side);
    const a = side.map((value) => value / length) as unknown as Vector3;
    const b: Vector3 = [y * a[2] - z * a[1], z * a[0] - x * a[2], x * a[1] - y * a[0]];
    const along = (axis: Vector3, sign: number) => axis.map((value) => (sign * value) / this.reach);
    const rows = [along(a, 1), along(b, 1), along(sun, -1)];
    const moved = rows.map((row) => -row.reduce((sum, value, k) => sum + value * this.centre[k]!, 0));
    return Float64Array.from([0, 1, 2].flatMap((k) => [...rows.map((row) => row[k]!), 0]).concat(moved, 1));
  }

  private draw(maps: WebGLTexture, size: number, places: readonly Matrix4[], drawables: Drawables): void {
    const { gl, surfaces } = this, framebuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(0, 0, size, size);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.depthMask(true);
    gl.disable(gl.CULL_FACE);
    places.forEach((place, layer) => {
      gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, maps, 0, layer);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      for (const instance of this.casters) {
        surfaces.beginShadow(instance, product(place, instance.world));
        drawables.draw(instance);
      }
    });
    gl.deleteFramebuffer(framebuffer);
  }

  private mapsOf(size: number, coarse: boolean): WebGLTexture {
    const known = this.maps.get(size);
    if (known) return known;
    const { gl } = this, made = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, made);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, coarse ? gl.DEPTH_COMPONENT16 : gl.DEPTH_COMPONENT24, size, size, MOST_SUNS);
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D_ARRAY, side, gl.CLAMP_TO_EDGE);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D_ARRAY, filter, gl.NEAREST);
    this.maps.set(size, made);
    return made;
  }
}
