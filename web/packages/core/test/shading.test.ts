// SPDX-License-Identifier: MIT
// What is shown of transport, and the view transform, against the golden numbers.

import assert from "node:assert/strict";
import { test } from "node:test";
import { aboutZ, applied, layerScales, lightOf, shown, standard, sumTransport, sumUnshadowed, TABLE_TOP, tableCoordinate, takeLamps, unshadowed, type Vector3, withoutNegatives } from "../src/index.js";
import { golden, near } from "./golden.js";

const numbers = golden<{
  transport: number[][][]; light: number[][]; shown: number[][]; linear: number[]; srgb: number[];
}>("shading");

test("sums of transport and light, without negative channels", () => {
  const light = lightOf(numbers.light);
  numbers.transport.forEach((rows, k) => near(shown(rows.flat(), light), numbers.shown[k]!, 1e-12));
});

test("the light of whole meshes is that of their vertices, whatever they are scaled by", () => {
  const light = lightOf(numbers.light), scale = 0.25, out = new Float32Array(3 * numbers.transport.length);
  sumTransport(numbers.transport.flat(2).map((value) => value / scale), scale, light, out);
  numbers.shown.forEach((wanted, k) => near(withoutNegatives([...out.subarray(3 * k, 3 * k + 3)] as unknown as Vector3), wanted, 1e-6));
});

test("what lamps show is taken out by the direct transport, wherever its numbers are padded", () => {
  const lamps = lightOf(numbers.light), direct = numbers.transport.map((rows) => rows.map((rgb) => rgb[1]!));
  const padded = direct.flatMap(([a, b, c, d, e, f, g, h, i]) => [a!, b!, c!, 9, d!, e!, f!, 9, g!, h!, i!, 9].map((value) => value / 4));
  const out = new Float32Array(3 * direct.length).fill(1);
  takeLamps(padded, 4, lamps, out);
  const wanted = direct.flatMap((row) => [0, 1, 2].map((c) => 1 - row.reduce((sum, value, i) => sum + value * lamps[3 * i + c]!, 0)));
  near(out, wanted, 1e-5);
});

test("the scales of layers: those of the extras, 1 without, and no others", () => {
  const pairs = numbers.light.map((_, i) => [0.1 * i, 2]);
  assert.deepEqual(layerScales({ scales: pairs }), pairs);
  assert.deepEqual(layerScales(undefined), pairs.map(() => [1, 1]));
  for (const broken of [pairs.slice(1), pairs.map(() => [1]), pairs.map(() => [NaN, 1])]) {
    assert.throws(() => layerScales({ scales: broken }), /9 pairs of scales/);
  }
  assert.deepEqual(layerScales({ scales: pairs, backs: pairs.slice(6) }, "backs"), pairs.slice(6));
  assert.deepEqual(layerScales({}, "backs"), [[1, 1], [1, 1], [1, 1]]);
  assert.throws(() => layerScales({ backs: pairs }, "backs"), /3 pairs of scales/);
});

test("without transport it is that of their normals, which are turned and may have any length", () => {
  const light = lightOf(numbers.light), normals: Vector3[] = [[0, 0, 3], [0.6, 0.8, 0], [-0.1, -0.1, 0.2]], turn = aboutZ(0.7);
  const out = new Float32Array(9);
  sumUnshadowed(normals.flat(), turn, light, out);
  normals.forEach((normal, k) => {
    const length = Math.hypot(...normal), unit = applied(turn, normal).map((value) => value / length) as unknown as Vector3;
    near(out.subarray(3 * k, 3 * k + 3), unshadowed(light, unit), 1e-6);
  });
});

test("the view transform Standard", () => near(numbers.linear.map(standard), numbers.srgb, 1e-12));

test("a table's coordinate goes from 0 to 1, always upwards, and stays there", () => {
  assert.equal(tableCoordinate(-1), 0);
  assert.equal(tableCoordinate(0), 0);
  assert.equal(tableCoordinate(TABLE_TOP), 1);
  assert.equal(tableCoordinate(1e6), 1);
  const ramp = [1e-4, 1e-3, 0.01, 0.18, 1, 10, 40].map(tableCoordinate);
  assert.deepEqual(ramp, [...ramp].sort((a, b) => a - b));
});
