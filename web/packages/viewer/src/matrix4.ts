// SPDX-License-Identifier: MIT
// 4 x 4 matrices, column by column, as WebGL takes them.

import type { Matrix3, Vector3 } from "@prt-relight/core";

export type Matrix4 = Float64Array;

export function product(a: Matrix4, b: Matrix4): Matrix4 {
  const out = new Float64Array(16);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * k + row]! * b[4 * column + k]!;
      out[4 * column + row] = sum;
    }
  }
  return out;
}

/** A rotation or any other linear map, as a 4 x 4 matrix. */
export function fromLinear(m: Matrix3): Matrix4 {
  return Float64Array.of(m[0], m[3], m[6], 0, m[1], m[4], m[7], 0, m[2], m[5], m[8], 0, 0, 0, 0, 1);
}

/** The linear part, row by row. */
export function linearPart(m: Matrix4): Matrix3 {
  return [m[0]!, m[4]!, m[8]!, m[1]!, m[5]!, m[9]!, m[2]!, m[6]!, m[10]!];
}

export function transformed(m: Matrix4, [x, y, z]: Vector3): Vector3 {
  const row = (k: number) => m[k]! * x + m[k + 4]! * y + m[k + 8]! * z + m[k + 12]!;
  return [row(0), row(1), row(2)];
}

/** What a glTF node says of its place: translation, rotation as a quaternion, scale. */
export function placed(t: readonly number[], q: readonly number[], s: readonly number[]): Matrix4 {
  const [x, y, z, w] = q as [number, number, number, number];
  return Float64Array.of(
    (1 - 2 * (y * y + z * z)) * s[0]!, 2 * (x * y + z * w) * s[0]!, 2 * (x * z - y * w) * s[0]!, 0,
    2 * (x * y - z * w) * s[1]!, (1 - 2 * (x * x + z * z)) * s[1]!, 2 * (y * z + x * w) * s[1]!, 0,
    2 * (x * z + y * w) * s[2]!, 2 * (y * z - x * w) * s[2]!, (1 - 2 * (x * x + y * y)) * s[2]!, 0,
    t[0]!, t[1]!, t[2]!, 1,
  );
}

/** Whether a matrix turns left hands into right ones. */
export function isMirrored(m: Matrix4): boolean {
  const [a, b, c, d, e, f, g, h, i] = linearPart(m);
  return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0;
}

/** Transposed inverse of the linear part, but for its scale: what normals are turned by. */
export function normalMatrix(m: Matrix4): Matrix3 {
  const [a, b, c, d, e, f, g, h, i] = linearPart(m), sign = isMirrored(m) ? -1 : 1;
  return [
    sign * (e * i - f * h), sign * (f * g - d * i), sign * (d * h - e * g),
    sign * (c * h - b * i), sign * (a * i - c * g), sign * (b * g - a * h),
    sign * (b * f - c * e), sign * (c * d - a * f), sign * (a * e - b * d),
  ];
}
