// SPDX-License-Identifier: MIT
// The light of whole meshes, summed once for each light: three floats a vertex, negative where nine coefficients leave it so.

import { COSINE_LOBE, K_0, K_1, K_XX, K_XY, K_ZZ } from "./harmonics.js";
import { COEFFICIENTS, type Light } from "./layout.js";
import type { Matrix3 } from "./matrix.js";

const NUMBERS = 3 * COEFFICIENTS;

/**
 * Radiance of white surfaces with transport: 27 numbers for each vertex of `out`, in the axes of the light, which
 * times a scale are transport.
 */
export function sumTransport(numbers: ArrayLike<number>, scale: number, light: Light, out: Float32Array): void {
  const weights = light.map((value) => value * scale);
  for (let vertex = 0, at = 0; vertex < out.length; vertex += 3) {
    let r = 0, g = 0, b = 0;
    for (let k = 0; k < NUMBERS; k += 3, at += 3) {
      r += numbers[at]! * weights[k]!;
      g += numbers[at + 1]! * weights[k + 1]!;
      b += numbers[at + 2]! * weights[k + 2]!;
    }
    out[vertex] = r;
    out[vertex + 1] = g;
    out[vertex + 2] = b;
  }
}

/**
 * Takes from the radiance of white surfaces what lamps of the sky show instead: their part of the direct transport, of which there are nine
 * whole numbers for each vertex of `out`, times a scale, at places 0 to 2, 4 to 6 and 8 to 10 of twelve.
 */
export function takeLamps(direct: ArrayLike<number>, scale: number, lamps: Light, out: Float32Array): void {
  const weights = lamps.map((value) => value * scale);
  for (let vertex = 0, at = 0; vertex < out.length; vertex += 3, at += 12) {
    let r = 0, g = 0, b = 0;
    for (let i = 0; i < COEFFICIENTS; i++) {
      const value = direct[at + 4 * Math.floor(i / 3) + (i % 3)]!;
      r += value * weights[3 * i]!;
      g += value * weights[3 * i + 1]!;
      b += value * weights[3 * i + 2]!;
    }
    out[vertex]! -= r;
    out[vertex + 1]! -= g;
    out[vertex + 2]! -= b;
  }
}

/** Radiance of white surfaces that all of the sky lights, by their normals: three for each vertex, of any length before `toWorld`. */
export function sumUnshadowed(normals: ArrayLike<number>, toWorld: Matrix3, light: Light, out: Float32Array): void {
  const [a, b, c, d, e, f, g, h, i] = toWorld, lobes = light.map((value, k) => value * COSINE_LOBE[Math.floor(k / 3)]!);
  for (let at = 0; at < out.length; at += 3) {
    const nx = normals[at]!, ny = normals[at + 1]!, nz = normals[at + 2]!;
    let x = a * nx + b * ny + c * nz, y = d * nx + e * ny + f * nz, z = g * nx + h * ny + i * nz;
    const length = Math.sqrt(x * x + y * y + z * z) || 1;
    x /= length;
    y /= length;
    z /= length;
    const xy = K_XY * x * y, yz = K_XY * y * z, zz = K_ZZ * (3 * z * z - 1), xz = K_XY * x * z, xx = K_XX * (x * x - y * y);
    for (let k = 0; k < 3; k++) {
      out[at + k] = K_0 * lobes[k]! + K_1 * (y * lobes[3 + k]! + z * lobes[6 + k]! + x * lobes[9 + k]!)
        + xy * lobes[12 + k]! + yz * lobes[15 + k]! + zz * lobes[18 + k]! + xz * lobes[21 + k]! + xx * lobes[24 + k]!;
    }
  }
}
