// SPDX-License-Identifier: MIT
// Packed transport, unpacked.

import assert from "node:assert/strict";
import { test } from "node:test";
import { COEFFICIENTS } from "@prt-relight/core";
import { DIRECT_STRIDE, NUMBERS, unpacked } from "../src/transport.js";

/** Packs rows of numbers as the exporter does, each the difference to the one of the vertex before. */
function packed(rows: number[][]): Uint8Array {
  const codes = rows[0]!.flatMap((_, number) => rows.map((row, vertex) => {
    const step = row[number]! - (vertex ? rows[vertex - 1]![number]! : 0);
    return step < 0 ? -2 * step - 1 : 2 * step;
  }));
  return Uint8Array.from([...codes.map((code) => code & 255), ...codes.map((code) => code >> 8)]);
}

const MIXED = [0, 1, 2, 3].map((vertex) => Array.from({ length: NUMBERS }, (_, k) => [511, -511, (37 * k) % 512, 9 - k][(vertex + k) % 4]!));

const TINTS = [256, -77] as const; // of red and blue, which are less what green foretells
const coded = (rgb: number[]) => [0, 1, 2].map((c) => rgb[c]! - (c === 1 ? 0 : Math.floor((rgb[1]! * TINTS[c / 2]!) / 256 + 0.5)));
const colours = (row: number[]) => Array.from({ length: COEFFICIENTS }, (_, i) => row.slice(3 * i, 3 * i + 3));

test("every number comes back, the farthest apart too", () => {
  const { numbers, direct } = unpacked(packed(MIXED.map((row) => colours(row).flatMap(coded))), 4, TINTS, false);
  assert.deepEqual([...numbers], MIXED.flat());
  assert.equal(direct, null);
});

test("so do parts that are told apart, as their sum and as the direct one at its places", () => {
  const parts = MIXED.map((row, vertex) => colours(row).map((rgb, i) => ({ rgb, direct: 63 * (i % 2 ? -vertex : i) })));
  const { numbers, direct } = unpacked(packed(parts.map((row) => row.flatMap(({ rgb, direct }) => [...coded(rgb), direct]))), 4, TINTS, true);
  assert.deepEqual([...numbers], parts.flat().flatMap(({ rgb, direct }) => rgb.map((value) => value + direct)));
  const places = [0, 1, 2, 4, 5, 6, 8, 9, 10];
  parts.forEach((row, vertex) => assert.deepEqual(places.map((place) => direct![DIRECT_STRIDE * vertex + place]! + 0), row.map((part) => part.direct + 0)));
});

test("what is not whole is refused in a sentence", () => {
  assert.throws(() => unpacked(new Uint8Array(53), 1, TINTS, false), /The page is not whole/);
  assert.throws(() => unpacked(new Uint8Array(54), 1, TINTS, true), /The page is not whole/);
});
