// SPDX-License-Identifier: MIT
// Real spherical harmonics of bands 0 to 2: orthonormal, index l (l + 1) + m, without the Condon-Shortley sign, Z up.

import type { Light } from "./layout.js";
import type { Vector3 } from "./matrix.js";

export const K_0 = Math.sqrt(1 / (4 * Math.PI));
export const K_1 = Math.sqrt(3 / (4 * Math.PI));
export const K_XY = Math.sqrt(15 / (4 * Math.PI));
export const K_ZZ = Math.sqrt(5 / (16 * Math.PI));
export const K_XX = K_XY / 2;

/** The nine harmonics along a unit vector. */
export function basis([x, y, z]: Vector3): number[] {
  return [
    K_0,
    K_1 * y, K_1 * z, K_1 * x,
    K_XY * x * y, K_XY * y * z, K_ZZ * (3 * z * z - 1), K_XY * x * z, K_XX * (x * x - y * y),
  ];
}

/** What is left of each coefficient where a white surface without shadows is lit: A_l / pi of Ramamoorthi and Hanrahan (2001). */
export const COSINE_LOBE: readonly number[] = [1, 2 / 3, 2 / 3, 2 / 3, 1 / 4, 1 / 4, 1 / 4, 1 / 4, 1 / 4];

/** Radiance of a white surface with a unit normal that all of the sky lights; negative where nine coefficients leave it so. */
export function unshadowed(light: Light, normal: Vector3): Vector3 {
  const weights = basis(normal).map((value, i) => value * COSINE_LOBE[i]!);
  const sum = (channel: number) => weights.reduce((total, weight, i) => total + weight * light[3 * i + channel]!, 0);
  return [sum(0), sum(1), sum(2)];
}
