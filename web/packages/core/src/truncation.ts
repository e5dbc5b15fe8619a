// SPDX-License-Identifier: MIT
// What nine coefficients lose of a light where it matters, as the engine measures it (core/sky/truncation.py).

import { coefficientCount } from "./bands.js";
import type { Light } from "./layout.js";
import { projected } from "./sky.js";

/** Up to which order what is lost is counted. */
export const MEASURED_ORDER = 8;

const SHOWN_ORDER = 2;
const WALL_ROWS = 64; // of the picture of what is seen at the foot of a wall

/**
 * Share of the light that is lost beyond order 2 at the foot of a wall, turned in all ways, of all that arrives there; RMS. There a
 * sharp light casts a sharp shadow, while in the open nothing of it would be lost. Both lights are of `MEASURED_ORDER`.
 */
export function truncation(left: Light, whole: Light = left): number {
  const sum = (values: readonly number[]) => values.reduce((total, value) => total + value, 0);
  const lost = sum(arriving(left).slice(SHOWN_ORDER + 1)), everything = sum(arriving(whole));
  return everything > 0 ? Math.sqrt(lost / everything) : 0;
}

/** Mean square of what each band of a light sends to the foot of a wall. */
function arriving(light: Light): number[] {
  return (shares ??= wall()).map((share, band) => {
    let squares = 0;
    for (let k = 3 * band * band; k < 3 * coefficientCount(band); k++) squares += light[k]! ** 2;
    return (share * squares) / 3;
  });
}

let shares: readonly number[] | null = null;

/** Mean square, over all turns, of the transport at the foot of a wall, per coefficient of each band. */
export function wall(): number[] {
  const height = WALL_ROWS, width = 2 * height, pixels = new Float32Array(3 * width * height);
  for (let y = 0, k = 0; y < height; y++) {
    const elevation = Math.PI * (0.5 - (y + 0.5) / height);
    for (let x = 0; x < width; x++, k += 3) {
      const isSeen = Math.cos(2 * Math.PI * (0.5 - (x + 0.5) / width)) > 0;
      pixels.fill(isSeen ? Math.max(Math.sin(elevation), 0) / Math.PI : 0, k, k + 3);
    }
  }
  const transport = projected({ width, height, pixels }, MEASURED_ORDER, false);
  return Array.from({ length: MEASURED_ORDER + 1 }, (_, band) => {
    let squares = 0;
    for (let i = band * band; i < coefficientCount(band); i++) squares += transport[3 * i]! ** 2;
    return squares / (2 * band + 1);
  });
}
