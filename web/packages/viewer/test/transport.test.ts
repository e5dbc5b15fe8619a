// SPDX-License-Identifier: MIT
// Packed transport, unpacked.

import assert from "node:assert/strict";
import { test } from "node:test";
import { DIRECT_STRIDE, NUMBERS, unpacked, unpackedDirect } from "../src/transport.js";

/** Packs as the exporter does, number by number. */
function packed(numbers: number[][]): Uint8Array {
  const codes: number[] = [];
  for (let number = 0; number < NUMBERS; number++) {
    let before = 0;
    for (const vertex of numbers) {
      const green = number - (number % 3) + 1, value = vertex[number]! - (number === green ? 0 : vertex[green]!);
      const step = value - before;
      codes.push(step < 0 ? -2 * step - 1 : 2 * step);
      before = value;
    }
  }
  return Uint8Array.from([...codes.map((code) => code & 255), ...codes.map((code) => code >> 8)]);
}

test("every number comes back, the farthest apart too", () => {
  const numbers = [0, 1, 2, 3].map((vertex) =>
    Array.from({ length: NUMBERS }, (_, k) => [511, -511, (37 * k) % 512, 9 - k][(vertex + k) % 4]!),
  );
  assert.deepEqual([...unpacked(packed(numbers), 4)], numbers.flat());
});

test("what is not whole is refused in a sentence", () => {
  assert.throws(() => unpacked(new Uint8Array(53), 1), /The page is not whole/);
});

test("the direct part comes back, at its places", () => {
  const first = [0, 63, -63, 5, -5, 1, 2, 3, 4], second = first.map((value) => -value);
  const bytes = Uint8Array.from(first.flatMap((value, k) => [value & 255, (second[k]! - value) & 255]));
  const out = unpackedDirect(bytes, 2), places = [0, 1, 2, 4, 5, 6, 8, 9, 10];
  assert.deepEqual(places.map((place) => out[place]), first);
  assert.deepEqual(places.map((place) => out[DIRECT_STRIDE + place]! + 0), second.map((value) => value + 0));
});
