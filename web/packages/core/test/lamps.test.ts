// SPDX-License-Identifier: MIT
// Lamps of skies, against the engine's by way of the golden numbers.

import assert from "node:assert/strict";
import { test } from "node:test";
import { findLamps, lightOfLamps, type Picture } from "../src/index.js";
import { golden, near } from "./golden.js";

const numbers = golden<{
  height: number; background: number[]; texels: number[][]; most: number; directions: number[][]; irradiances: number[]; radii: number[];
  colour: number[]; light: number[][]; one: number[];
}>("lamps");

/** The top row first. */
function picture(): Picture {
  const { height, background, texels } = numbers, width = 2 * height, pixels = new Float32Array(3 * width * height);
  pixels.forEach((_, k) => (pixels[k] = background[k % 3]!));
  for (const [row, column, ...rgb] of texels) pixels.set(rgb, 3 * (row! * width + column!));
  return { width, height, pixels };
}

test("the lamps that Blender takes out of a sky, and what they are of its light", () => {
  const found = findLamps(picture(), numbers.most);
  assert.equal(found.lamps.length, numbers.directions.length);
  near(found.lamps.flatMap(({ direction }) => direction), numbers.directions.flat(), 1e-6);
  near(found.lamps.map(({ irradiance }) => irradiance), numbers.irradiances, 1e-5);
  near(found.lamps.map(({ radius }) => radius), numbers.radii, 1e-5);
  near(found.colour, numbers.colour, 1e-5);
  near(lightOfLamps(found), numbers.light.flat(), 1e-5);
});

test("one alone is where the most light is", () => near(findLamps(picture(), 1).lamps[0]!.direction, numbers.one, 1e-6));

test("a sky without spots has none, and none are found that are not wanted", () => {
  const even = { width: 8, height: 4, pixels: new Float32Array(96).fill(2) };
  for (const found of [findLamps(even, 4), findLamps(picture(), 0)]) {
    assert.equal(found.lamps.length, 0);
    assert.ok(lightOfLamps(found).every((value) => value === 0));
  }
});
