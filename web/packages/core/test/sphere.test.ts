// SPDX-License-Identifier: MIT
// Harmonics and turns against the golden numbers.

import assert from "node:assert/strict";
import { test } from "node:test";
import { aboutZ, basis, IDENTITY, lightOf, type Matrix3, multiplied, transposed, turned, unitColumns, unshadowed, type Vector3 } from "../src/index.js";
import { golden, near } from "./golden.js";

const numbers = golden<{
  directions: Vector3[]; basis: number[][]; light: number[][]; rotations: number[][][]; turned: number[][][];
  normals: Vector3[]; unshadowed: number[][];
}>("sphere");
const light = lightOf(numbers.light);

test("the harmonics along directions", () => {
  numbers.directions.forEach((direction, k) => near(basis(direction), numbers.basis[k]!, 1e-13));
});

test("a turned light is seen along w as the light was along R w", () => {
  numbers.rotations.forEach((rows, k) => {
    near(turned(light, rows.flat() as unknown as Matrix3), numbers.turned[k]!.flat(), 1e-12);
  });
});

test("turns follow one another, and back again", () => {
  const [a, b] = numbers.rotations.slice(1, 3).map((rows) => rows.flat() as unknown as Matrix3);
  near(turned(turned(light, a!), b!), turned(light, multiplied(a!, b!)), 1e-12);
  near(turned(turned(light, a!), transposed(a!)), light, 1e-12);
  near(turned(light, IDENTITY), light, 1e-15);
  near(aboutZ(Math.PI / 2), numbers.rotations[0]!.flat(), 1e-15);
});

test("white surfaces that nothing shadows", () => {
  numbers.normals.forEach((normal, k) => near(unshadowed(light, normal), numbers.unshadowed[k]!, 1e-12));
});

test("axes of a scaled matrix", () => {
  const turn = numbers.rotations[1]!.flat() as unknown as Matrix3;
  near(unitColumns(multiplied(turn, [2, 0, 0, 0, 3, 0, 0, 0, 0.5])), turn, 1e-12);
});

test("a light of another size is refused", () => {
  assert.throws(() => lightOf(numbers.light.slice(1)), /9 RGB coefficients, and not these 8/);
});
