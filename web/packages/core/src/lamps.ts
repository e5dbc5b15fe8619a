// SPDX-License-Identifier: MIT
// Lamps that stand for bright spots of a sky, and what they are of its light.

import { coefficientCount, harmonics } from "./bands.js";
import type { Light } from "./layout.js";
import type { Vector3 } from "./matrix.js";

/** A distant disc that stands for a spot. */
export interface Lamp {
  readonly direction: Vector3;
  /** Of a surface that faces it, mean of the channels. */
  readonly irradiance: number;
  /** In radians. */
  readonly radius: number;
}

/** What is taken out of a sky; all lamps have one colour, whose mean is 1. */
export interface Lamps {
  readonly lamps: readonly Lamp[];
  readonly colour: Vector3;
}

export const NO_LAMPS: Lamps = { lamps: [], colour: [1, 1, 1] };

/** What lamps are of a light: nine RGB coefficients, or as many as an order has. */
export function lightOfLamps({ lamps, colour }: Lamps, order = 2): Light {
  const light = new Float64Array(3 * coefficientCount(order));
  for (const { direction, irradiance, radius } of lamps) {
    const bands = discBands(Math.cos(radius), order);
    harmonics(direction, order).forEach((value, i) => {
      const part = irradiance * value * bands[Math.floor(Math.sqrt(i))]!;
      for (let c = 0; c < 3; c++) light[3 * i + c]! += part * colour[c]!;
    });
  }
  return light;
}

/** What a disc leaves of each band of a point: (P_(l-1)(c) - P_(l+1)(c)) / ((2 l + 1) (1 - c)), c being the cosine of its radius. */
function discBands(c: number, order: number): number[] {
  const polynomials = [1, c], bands = [1];
  for (let l = 1; l <= order; l++) {
    polynomials.push(((2 * l + 1) * c * polynomials[l]! - l * polynomials[l - 1]!) / (l + 1));
    bands.push(1 - c < 1e-9 ? 1 : (polynomials[l - 1]! - polynomials[l + 1]!) / ((2 * l + 1) * (1 - c)));
  }
  return bands;
}
