// SPDX-License-Identifier: MIT
// What a white surface shows of transport under a light: the sums of products, with no negative channel left.

import { COEFFICIENTS, type Light } from "./layout.js";
import type { Vector3 } from "./matrix.js";

/**
 * A colour with a negative channel, moved towards the grey of its mean until none is: channels clamped one by one would
 * show as saturated blotches.
 */
export function withoutNegatives([r, g, b]: Vector3): Vector3 {
  const least = Math.min(r, g, b), mean = (r + g + b) / 3;
  const share = Math.min(Math.max(-least, 0) / Math.max(mean - least, 1e-9), 1);
  const moved = (value: number) => Math.max(value + share * (mean - value), 0);
  return [moved(r), moved(g), moved(b)];
}

/** Radiance of a white surface; transport is nine RGB coefficients, 27 numbers, in the light's axes. */
export function shown(transport: ArrayLike<number>, light: Light): Vector3 {
  const sum = [0, 0, 0];
  for (let i = 0; i < 3 * COEFFICIENTS; i++) sum[i % 3]! += transport[i]! * light[i]!;
  return withoutNegatives([sum[0]!, sum[1]!, sum[2]!]);
}

/** The same in GLSL, for shaders that have summed already. */
export const GLSL_WITHOUT_NEGATIVES = `
vec3 withoutNegatives(vec3 c) {
  float least = min(c.r, min(c.g, c.b)), mean = (c.r + c.g + c.b) / 3.0;
  float share = min(max(-least, 0.0) / max(mean - least, 1e-9), 1.0);
  return max(mix(c, vec3(mean), share), 0.0);
}`;
