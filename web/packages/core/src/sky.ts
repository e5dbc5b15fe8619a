// SPDX-License-Identifier: MIT
// Equirectangular pictures, projected onto the harmonics as Blender lays them round the world.

import { coefficientCount, legendre } from "./bands.js";
import type { Light } from "./layout.js";

/** Linear radiance, RGB, the top row first; the middle column looks along +x, and +y is to the left of it. */
export interface Picture {
  readonly width: number;
  readonly height: number;
  readonly pixels: Float32Array;
}

const POINTS = 12; // of the quadrature over half a row

/**
 * L_i, the integral of radiance times Y_i over the sphere, up to an order: three numbers each. Radiance goes linearly from the centre of
 * one texel to the next, as renderers show pictures, and stays beyond the outermost rows; or texels are flat. Sums are in double precision.
 */
export function projected({ width, height, pixels }: Picture, order = 2, smooth = true): Light {
  const light = new Float64Array(3 * coefficientCount(order)), columns = azimuthal(width, order, smooth), rows = polar(height, order, smooth);
  for (let y = 0; y < height; y++) {
    const moments = rowMoments(pixels, 3 * y * width, width, columns);
    for (let band = 0, k = 0; band <= order; band++) {
      for (let m = -band; m <= band; m++, k += 3) {
        const weight = rows[band * (band + 1) + Math.abs(m)]![y]!, moment = moments[m < 0 ? order - m : m]!;
        for (let c = 0; c < 3; c++) light[k + c]! += weight * moment[c]!;
      }
    }
  }
  return light;
}

function rowMoments(pixels: Float32Array, first: number, width: number, columns: readonly Float64Array[]): number[][] {
  return columns.map((weights) => {
    let r = 0, g = 0, b = 0;
    for (let x = 0, k = first; x < width; x++, k += 3) {
      const weight = weights[x]!;
      r += weight * pixels[k]!;
      g += weight * pixels[k + 1]!;
      b += weight * pixels[k + 2]!;
    }
    return [r, g, b];
  });
}

/** cos m of the azimuth for each m up to an order, then sin m for each from 1: integrated over each column, a box, or a tent twice as wide. */
function azimuthal(width: number, order: number, smooth: boolean): Float64Array[] {
  const step = (2 * Math.PI) / width, blur = smooth ? 2 : 1; // a tent is a box, blurred by a box
  const sinc = (m: number) => (m ? Math.sin((Math.PI * m) / width) / ((Math.PI * m) / width) : 1);
  const over = (m: number, wave: (angle: number) => number) =>
    Float64Array.from({ length: width }, (_, x) => wave(m * 2 * Math.PI * (0.5 - (x + 0.5) / width)) * step * sinc(m) ** blur);
  const waves = Array.from({ length: order + 1 }, (_, m) => m);
  return [...waves.map((m) => over(m, Math.cos)), ...waves.slice(1).map((m) => over(m, Math.sin))];
}

/** At l (l + 1) + m for m of 0 and more: the harmonic's part that depends on the elevation, integrated over the solid angle of each row. */
function polar(height: number, order: number, smooth: boolean): Float64Array[] {
  const out = Array.from({ length: coefficientCount(order) }, () => new Float64Array(height));
  const step = Math.PI / height, { nodes, weights } = gaussLegendre(POINTS);
  for (let y = 0; y < height; y++) {
    for (const side of [-1, 1]) {
      const next = Math.min(Math.max(y + side, 0), height - 1);
      nodes.forEach((node, k) => {
        const away = (node + 1) / 4, blended = smooth ? away : 0; // of a row, from its centre
        const elevation = Math.PI * (0.5 - (y + 0.5 + side * away) / height), ring = Math.cos(elevation);
        const parts = legendre(Math.sin(elevation), order), measure = ring * step * (weights[k]! / 4);
        for (let band = 0; band <= order; band++) {
          for (let m = 0, i = band * (band + 1), rings = measure; m <= band; m++, i++, rings *= ring) {
            out[i]![y]! += parts[i]! * rings * (1 - blended);
            out[i]![next]! += parts[i]! * rings * blended;
          }
        }
      });
    }
  }
  return out;
}

/** Nodes and weights on [-1, 1], by Newton's method on Legendre's polynomial. */
function gaussLegendre(count: number): { nodes: number[]; weights: number[] } {
  const nodes: number[] = [], weights: number[] = [];
  for (let k = 0; k < count; k++) {
    let x = Math.cos((Math.PI * (k + 0.75)) / (count + 0.5)), slope = 0;
    for (let step = 0; step < 8; step++) {
      let before = 1, value = x;
      for (let n = 2; n <= count; n++) [before, value] = [value, ((2 * n - 1) * x * value - (n - 1) * before) / n];
      slope = (count * (x * value - before)) / (x * x - 1);
      x -= value / slope;
    }
    nodes.push(x);
    weights.push(2 / ((1 - x * x) * slope * slope));
  }
  return { nodes, weights };
}
