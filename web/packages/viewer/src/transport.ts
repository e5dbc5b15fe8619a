// SPDX-License-Identifier: MIT
// Transport as the exporter packs it: whole numbers, each the difference to the vertex before, in byte planes.

import { COEFFICIENTS } from "@prt-relight/core";

export const NUMBERS = 3 * COEFFICIENTS;

/** Numbers of a vertex' direct part: three and one that pads, three times. */
export const DIRECT_STRIDE = 12;

/** Whole numbers, which are transport times one scale. */
export interface Unpacked {
  /** 27 a vertex. */
  readonly numbers: Int16Array;
  /** Nine of the direct part a vertex, at places of twelve, if it is told apart. */
  readonly direct: Int16Array | null;
}

/**
 * Packed are the low bytes of all numbers and then the high ones, number after number, with the sign in the lowest bit; red and blue are
 * less what green foretells, by so many 256ths. Where the direct part is told apart it follows each colour, which is less it.
 */
export function unpacked(planes: Uint8Array, vertices: number, tints: readonly [number, number], toldApart: boolean): Unpacked {
  const channels = toldApart ? 4 : 3, high = channels * COEFFICIENTS * vertices;
  if (planes.length !== 2 * high) throw new Error("The page is not whole: transport is missing. Export it again.");
  const numbers = new Int16Array(NUMBERS * vertices), direct = toldApart ? new Int16Array(DIRECT_STRIDE * vertices) : null;
  for (let i = 0, at = 0; i < COEFFICIENTS; i++) {
    for (let channel = 0; channel < channels; channel++, at += vertices) {
      if (channel < 3) decode(planes, at, high, vertices, numbers, 3 * i + channel, NUMBERS);
      else decode(planes, at, high, vertices, direct!, placeOf(i), DIRECT_STRIDE);
    }
  }
  for (let i = 0; i < COEFFICIENTS; i++) putTogether(numbers, direct, i, tints);
  return { numbers, direct };
}

/** Writes one number of each vertex, which are packed as differences to the vertex before, at a place of each row. */
function decode(planes: Uint8Array, low: number, high: number, vertices: number, out: Int16Array, place: number, stride: number): void {
  for (let vertex = 0, at = low, value = 0; vertex < vertices; vertex++, at++) {
    const code = planes[at]! | (planes[high + at]! << 8);
    value += (code >> 1) ^ -(code & 1);
    out[stride * vertex + place] = value;
  }
}

/** Makes a coefficient's colours of what they were packed as. */
function putTogether(numbers: Int16Array, direct: Int16Array | null, i: number, [red, blue]: readonly [number, number]): void {
  for (let k = 3 * i, at = placeOf(i); k < numbers.length; k += NUMBERS, at += DIRECT_STRIDE) {
    const green = numbers[k + 1]!, less = direct ? direct[at]! : 0;
    numbers[k]! += ((green * red + 128) >> 8) + less;
    numbers[k + 1] = green + less;
    numbers[k + 2]! += ((green * blue + 128) >> 8) + less;
  }
}

function placeOf(coefficient: number): number {
  return 4 * Math.floor(coefficient / 3) + (coefficient % 3);
}
