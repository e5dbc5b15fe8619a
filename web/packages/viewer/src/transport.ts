// SPDX-License-Identifier: MIT
// Transport as the exporter packs it: whole numbers, green first, each the difference to the vertex before, in byte planes.

import { COEFFICIENTS } from "@prt-relight/core";

export const NUMBERS = 3 * COEFFICIENTS;

/** Bytes of a vertex' direct part: three and one that pads, three times. */
export const DIRECT_STRIDE = 12;

/**
 * Unpacks 27 numbers for each vertex: times the layer's scale they are transport. Packed are the low bytes of all numbers
 * and then the high ones, number after number; red and blue are less green, and the sign is in the lowest bit.
 */
export function unpacked(planes: Uint8Array, vertices: number): Int16Array {
  if (planes.length !== 2 * NUMBERS * vertices) throw new Error("The page is not whole: transport is missing. Export it again.");
  const out = new Int16Array(NUMBERS * vertices), high = NUMBERS * vertices;
  for (let number = 0, at = 0; number < NUMBERS; number++) {
    for (let vertex = 0, value = 0; vertex < vertices; vertex++, at++) {
      const code = planes[at]! | (planes[high + at]! << 8);
      value += (code >> 1) ^ -(code & 1);
      out[NUMBERS * vertex + number] = value;
    }
  }
  for (let k = 0; k < out.length; k += 3) {
    out[k]! += out[k + 1]!;
    out[k + 2]! += out[k + 1]!;
  }
  return out;
}

/** Unpacks nine numbers for each vertex, a byte each: coefficient by coefficient, as differences to the vertex before. Each has a place of twelve. */
export function unpackedDirect(bytes: Uint8Array, vertices: number): Int8Array {
  if (bytes.length !== COEFFICIENTS * vertices) throw new Error("The page is not whole: transport is missing. Export it again.");
  const out = new Int8Array(DIRECT_STRIDE * vertices);
  for (let number = 0, at = 0; number < COEFFICIENTS; number++) {
    const place = 4 * Math.floor(number / 3) + (number % 3);
    for (let vertex = 0, value = 0; vertex < vertices; vertex++, at++) {
      value += bytes[at]!;
      out[DIRECT_STRIDE * vertex + place] = value;
    }
  }
  return out;
}
