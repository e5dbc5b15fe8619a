// SPDX-License-Identifier: MIT
// Turning a light: band 1 turns as a vector, band 2 as a symmetric form without trace.

import { K_XX, K_ZZ } from "./harmonics.js";
import type { Light } from "./layout.js";
import { applied, type Matrix3, multiplied, transposed } from "./matrix.js";

/** The light that is seen along w where the given one is seen along R w. */
export function turned(light: Light, rotation: Matrix3): Light {
  const back = transposed(rotation);
  const out = light.slice();
  for (let c = 0; c < 3; c++) {
    const at = (i: number) => light[3 * i + c]!;
    const [x, y, z] = applied(back, [at(3), at(1), at(2)]); // Y_1 is ordered y, z, x
    out[3 + c] = y;
    out[6 + c] = z;
    out[9 + c] = x;
    const form: Matrix3 = [
      K_XX * at(8) - K_ZZ * at(6), K_XX * at(4), K_XX * at(7),
      K_XX * at(4), -K_XX * at(8) - K_ZZ * at(6), K_XX * at(5),
      K_XX * at(7), K_XX * at(5), 2 * K_ZZ * at(6),
    ];
    const q = multiplied(multiplied(back, form), rotation);
    out[12 + c] = q[1] / K_XX;
    out[15 + c] = q[5] / K_XX;
    out[18 + c] = q[8] / (2 * K_ZZ);
    out[21 + c] = q[2] / K_XX;
    out[24 + c] = (q[0] - q[4]) / (2 * K_XX);
  }
  return out;
}

export function scaled(light: Light, strength: number): Light {
  return light.map((value) => strength * value);
}
