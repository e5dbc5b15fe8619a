// SPDX-License-Identifier: MIT
// 3 x 3 matrices, nine numbers row by row, and vectors of three.

export type Vector3 = readonly [number, number, number];
export type Matrix3 = readonly [number, number, number, number, number, number, number, number, number];

export const IDENTITY: Matrix3 = [1, 0, 0, 0, 1, 0, 0, 0, 1];

/** The matrix whose columns are three vectors. */
export function fromColumns(x: Vector3, y: Vector3, z: Vector3): Matrix3 {
  return [x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]];
}

export function transposed(m: Matrix3): Matrix3 {
  return [m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]];
}

export function multiplied(a: Matrix3, b: Matrix3): Matrix3 {
  const entry = (row: number, column: number) =>
    a[3 * row]! * b[column]! + a[3 * row + 1]! * b[column + 3]! + a[3 * row + 2]! * b[column + 6]!;
  return [
    entry(0, 0), entry(0, 1), entry(0, 2),
    entry(1, 0), entry(1, 1), entry(1, 2),
    entry(2, 0), entry(2, 1), entry(2, 2),
  ];
}

export function applied(m: Matrix3, v: Vector3): Vector3 {
  return [
    m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
    m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
    m[6] * v[0] + m[7] * v[1] + m[8] * v[2],
  ];
}

/** The rotation about a unit vector by an angle in radians, counterclockwise for those whom it points at (Rodrigues). */
export function about([x, y, z]: Vector3, angle: number): Matrix3 {
  const cos = Math.cos(angle), sin = Math.sin(angle), rest = 1 - cos;
  return [
    cos + x * x * rest, x * y * rest - z * sin, x * z * rest + y * sin,
    y * x * rest + z * sin, cos + y * y * rest, y * z * rest - x * sin,
    z * x * rest - y * sin, z * y * rest + x * sin, cos + z * z * rest,
  ];
}

/** The rotation about Blender's Z, upwards, by an angle in radians. */
export function aboutZ(angle: number): Matrix3 {
  return about([0, 0, 1], angle);
}

/** A matrix with its columns scaled to length 1: the axes of an object in space. */
export function unitColumns(m: Matrix3): Matrix3 {
  const [x, y, z] = [0, 1, 2].map((column) => 1 / Math.hypot(m[column]!, m[column + 3]!, m[column + 6]!));
  return multiplied(m, [x!, 0, 0, 0, y!, 0, 0, 0, z!]);
}
