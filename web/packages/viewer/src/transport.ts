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

/** What one side of all faces receives. */
export interface Side extends Unpacked {
  /** What the numbers are multiplied by. */
  readonly scale: number;
}

/** By how much finer the numbers of backs are than those that are packed: they are multiplied by colours, and rounded. */
const FINER = 16;

/** What stands for 1 in colours and direct shares of backs. */
const SHARES = 255;

/**
 * Packed are the low bytes of all numbers and then the high ones, number after number, with the sign in the lowest bit; red and blue are
 * less what green foretells, by so many 256ths. Where the direct part is told apart it follows each colour, which is less it.
 */
export function unpacked(planes: Uint8Array, vertices: number, tints: readonly [number, number], toldApart: boolean): Unpacked {
  const channels = toldApart ? 4 : 3, high = channels * COEFFICIENTS * vertices;
  check(planes, 2 * high);
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

/** The same of backs: packed are nine numbers, red and green of the colour that they all have, and, if it is told apart, the direct part's share. */
export function unpackedBacks(planes: Uint8Array, vertices: number, scale: number, toldApart: boolean): Side {
  const columns = COEFFICIENTS + (toldApart ? 3 : 2), high = columns * vertices, rows = new Int16Array(columns * vertices);
  check(planes, 2 * high);
  for (let column = 0; column < columns; column++) decode(planes, column * vertices, high, vertices, rows, column, columns);
  const numbers = new Int16Array(NUMBERS * vertices), direct = toldApart ? new Int16Array(DIRECT_STRIDE * vertices) : null;
  for (let vertex = 0, at = 0; vertex < vertices; vertex++, at += columns) {
    const [red, green, share] = [0, 1, 2].map((k) => (k < columns - COEFFICIENTS ? (FINER / SHARES) * rows[at + COEFFICIENTS + k]! : 0)) as [number, number, number];
    for (let i = 0, k = NUMBERS * vertex; i < COEFFICIENTS; i++, k += 3) {
      const number = rows[at + i]!;
      numbers[k] = Math.round(number * red);
      numbers[k + 1] = Math.round(number * green);
      numbers[k + 2] = Math.round(number * (3 * FINER - red - green));
      if (direct) direct[DIRECT_STRIDE * vertex + placeOf(i)] = Math.round(number * share);
    }
  }
  return { numbers, direct, scale: scale / FINER };
}

function check(planes: Uint8Array, length: number): void {
  if (planes.length !== length) throw new Error("The page is not whole: transport is missing. Export it again.");
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
