// SPDX-License-Identifier: MIT
// Equirectangular pictures, projected onto the harmonics as Blender lays them round the world.

import { basis } from "./harmonics.js";
import { COEFFICIENTS, type Light } from "./layout.js";

/** Linear radiance, RGB, the top row first; the middle column looks along +x, and +y is to the left of it. */
export interface Picture {
  readonly width: number;
  readonly height: number;
  readonly pixels: Float32Array;
}

const POINTS = 8; // of the quadrature over half a row: exact to 1e-13 in pictures of four rows

/**
 * L_i, the integral of radiance times Y_i over the sphere. Radiance goes linearly from the centre of one texel to the next,
 * as renderers show pictures; beyond the outermost rows it stays. Sums are in double precision.
 */
export function projected({ width, height, pixels }: Picture): Light {
  const light = new Float64Array(3 * COEFFICIENTS);
  const columns = azimuthal(width), rows = polar(height);
  for (let y = 0; y < height; y++) {
    const moments = rowMoments(pixels, 3 * y * width, width, columns);
    for (let i = 0; i < COEFFICIENTS; i++) {
      const weight = rows[i]![y]!, moment = moments[ORDER_OF_AZIMUTH[i]!]!;
      for (let c = 0; c < 3; c++) light[3 * i + c]! += weight * moment[c]!;
    }
  }
  return light;
}

/** Which of 1, cos, sin, cos 2, sin 2 of the azimuth each harmonic holds. */
const ORDER_OF_AZIMUTH = [0, 2, 0, 1, 4, 2, 0, 1, 3];

function rowMoments(pixels: Float32Array, first: number, width: number, columns: Float64Array[]): number[][] {
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

/** The functions of the azimuth, integrated over each column's tent. */
function azimuthal(width: number): Float64Array[] {
  const step = (2 * Math.PI) / width;
  const sinc = (m: number) => (m ? Math.sin((Math.PI * m) / width) / ((Math.PI * m) / width) : 1);
  const over = (m: number, wave: (angle: number) => number) =>
    Float64Array.from({ length: width }, (_, x) => wave(m * 2 * Math.PI * (0.5 - (x + 0.5) / width)) * step * sinc(m) ** 2);
  return [over(0, Math.cos), over(1, Math.cos), over(1, Math.sin), over(2, Math.cos), over(2, Math.sin)];
}

/** For each harmonic, its part that depends on the elevation, integrated over the solid angle of each row's tent. */
function polar(height: number): Float64Array[] {
  const out = Array.from({ length: COEFFICIENTS }, () => new Float64Array(height));
  const step = Math.PI / height, { nodes, weights } = gaussLegendre(POINTS);
  for (let y = 0; y < height; y++) {
    for (const side of [-1, 1]) {
      const next = Math.min(Math.max(y + side, 0), height - 1);
      nodes.forEach((node, k) => {
        const away = (node + 1) / 4; // of a row, from its centre
        const elevation = Math.PI * (0.5 - (y + 0.5 + side * away) / height);
        const measure = Math.cos(elevation) * step * (weights[k]! / 4);
        polarParts(elevation).forEach((value, i) => {
          out[i]![y]! += value * measure * (1 - away);
          out[i]![next]! += value * measure * away;
        });
      });
    }
  }
  return out;
}

/** The harmonics without their functions of the azimuth: read where these are 1. */
function polarParts(elevation: number): number[] {
  const ring = Math.cos(elevation), z = Math.sin(elevation);
  const along = basis([ring, 0, z]), aside = basis([0, ring, z]);
  const diagonal = basis([ring * Math.SQRT1_2, ring * Math.SQRT1_2, z]);
  return [along[0]!, aside[1]!, along[2]!, along[3]!, diagonal[4]!, aside[5]!, along[6]!, along[7]!, along[8]!];
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
