// SPDX-License-Identifier: MIT
// What is shown of transport, and the view transform, against the golden numbers.

import assert from "node:assert/strict";
import { test } from "node:test";
import { lightOf, shown, standard, TABLE_TOP, tableCoordinate } from "../src/index.js";
import { golden, near } from "./golden.js";

const numbers = golden<{
  transport: number[][][]; light: number[][]; shown: number[][]; linear: number[]; srgb: number[];
}>("shading");

test("sums of transport and light, without negative channels", () => {
  const light = lightOf(numbers.light);
  numbers.transport.forEach((rows, k) => near(shown(rows.flat(), light), numbers.shown[k]!, 1e-12));
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
