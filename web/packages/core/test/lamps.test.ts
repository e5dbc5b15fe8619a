// SPDX-License-Identifier: MIT
// Lamps of skies, against the engine's by way of the golden numbers.

import assert from "node:assert/strict";
import { test } from "node:test";
import { findLamps, lightOfLamps, MEASURED_ORDER, type Picture, projected, truncation } from "../src/index.js";
import { golden, near } from "./golden.js";

const numbers = golden<{
  height: number; background: number[]; texels: number[][]; most: number; directions: number[][]; irradiances: number[]; radii: number[];
  colour: number[]; light: number[][]; one: number[]; spots: number[]; strengths: number[][]; enough: number; counts: number[]; truncations: number[];
  glow_height: number; glow_background: number; glow_discs: number[][]; glow_directions: number[][]; glow_irradiances: number[]; glow_radii: number[];
}>("lamps");

/** The top row first; spots are as bright as the golden sky's, times these strengths. */
function picture(strengths = [1, 1, 1, 1, 1]): Picture {
  const { height, background, texels, spots } = numbers, width = 2 * height, pixels = new Float32Array(3 * width * height);
  pixels.forEach((_, k) => (pixels[k] = background[k % 3]!));
  texels.forEach(([row, column, ...rgb], k) => {
    const strength = strengths[spots[k]!]!;
    if (strength > 0) pixels.set(rgb.map((value) => value * strength), 3 * (row! * width + column!));
  });
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

test("a sun keeps its sharp shadows in the midst of its glow, which is a wide lamp, as a window is", () => {
  const { glow_height: height, glow_background: background, glow_discs: discs } = numbers, width = 2 * height;
  const pixels = new Float32Array(3 * width * height).fill(background);
  for (const [a, b, c, radius, radiance] of discs) {
    for (let k = 0; k < width * height; k++) {
      const elevation = Math.PI * (0.5 - (Math.floor(k / width) + 0.5) / height), azimuth = 2 * Math.PI * (0.5 - ((k % width) + 0.5) / width);
      const ring = Math.cos(elevation), x = ring * Math.cos(azimuth), y = ring * Math.sin(azimuth), z = Math.sin(elevation);
      if (a! * x + b! * y + c! * z > Math.cos((radius! * Math.PI) / 180)) for (let i = 0; i < 3; i++) pixels[3 * k + i]! += radiance!;
    }
  }
  const { lamps } = findLamps({ width, height, pixels }, 4, numbers.enough);
  assert.equal(lamps.length, 3);
  near(lamps.flatMap(({ direction }) => direction), numbers.glow_directions.flat(), 1e-6);
  near(lamps.map(({ irradiance }) => irradiance), numbers.glow_irradiances, 1e-5);
  near(lamps.map(({ radius }) => radius), numbers.glow_radii, 1e-5);
});

test("one alone is where the most light is", () => near(findLamps(picture(), 1).lamps[0]!.direction, numbers.one, 1e-6));

test("a sky without spots has none, and none are found that are not wanted", () => {
  const even = { width: 8, height: 4, pixels: new Float32Array(96).fill(2) };
  for (const found of [findLamps(even, 4), findLamps(picture(), 0)]) {
    assert.equal(found.lamps.length, 0);
    assert.ok(lightOfLamps(found).every((value) => value === 0));
  }
});

test("what skies lose beyond order 2, and the fewest lamps that bring it down: as many as Blender takes", () => {
  const skies = numbers.strengths.map(picture);
  near(skies.map((sky) => truncation(projected(sky, MEASURED_ORDER, false))), numbers.truncations, 1e-6);
  assert.deepEqual(skies.map((sky) => findLamps(sky, numbers.most, numbers.enough).lamps.length), numbers.counts);
});
