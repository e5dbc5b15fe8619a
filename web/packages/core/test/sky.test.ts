// SPDX-License-Identifier: MIT
// Pictures of the sky: read from .hdr files and projected, against the golden numbers.

import assert from "node:assert/strict";
import { test } from "node:test";
import { projected, readRadiance } from "../src/index.js";
import { golden, near } from "./golden.js";

const files = golden<{ flat: string; packed: string; pixels: number[][][] }>("radiance");
const bytesOf = (text: string) => new Uint8Array(Buffer.from(text, "base64"));

test("the projection of a picture", () => {
  const { picture, light } = golden<{ picture: number[][][]; light: number[][] }>("sky");
  const pixels = Float32Array.from(picture.flat(2));
  near(projected({ width: picture[0]!.length, height: picture.length, pixels }), light.flat(), 1e-10);
});

test("a constant sky has its mean alone, at any size", () => {
  for (const height of [4, 64]) {
    const light = projected({ width: 2 * height, height, pixels: new Float32Array(6 * height * height).fill(2) });
    near(light, [...Array<number>(3).fill(2 * Math.sqrt(4 * Math.PI)), ...Array<number>(24).fill(0)], 1e-11);
  }
});

for (const form of ["flat", "packed"] as const) {
  test(`a .hdr file, ${form}`, () => {
    const { width, height, pixels } = readRadiance(bytesOf(files[form]));
    assert.deepEqual([width, height], [12, 3]);
    near(pixels, files.pixels.flat(2), 0);
  });

  test(`a .hdr file, ${form} and cut off anywhere, is refused in a sentence`, () => {
    const bytes = bytesOf(files[form]);
    for (let length = 0; length < bytes.length; length++) {
      assert.throws(() => readRadiance(bytes.subarray(0, length)), /^Error: .*\.$/);
    }
  });
}

test("other files are refused in sentences", () => {
  const text = (header: string) => () => readRadiance(new TextEncoder().encode(header));
  assert.throws(text("\x89PNG\r\n\x1a\n........"), /no Radiance picture/);
  assert.throws(text("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 3 +X 12\n"), /only 32-bit_rle_rgbe/);
  assert.throws(text("#?RADIANCE\n\n+Y 3 +X 12\n"), /cannot be read/);
  assert.throws(text("#?RADIANCE\n\n-Y 0 +X 12\n"), /impossible size/);
  assert.throws(text("#?RADIANCE\n\n-Y 999999 +X 999999\n"), /impossible size/);
});
