// SPDX-License-Identifier: MIT
// Packed transport, unpacked.

import assert from "node:assert/strict";
import { test } from "node:test";
import { COEFFICIENTS } from "@prt-relight/core";
import { DIRECT_STRIDE, NUMBERS, unpacked, unpackedBacks } from "../src/transport.js";

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

const BACKS = [
  { numbers: [255, -255, 3, 0, 1, 2, 7, -9, 100], red: 765, green: 0, share: 128 },
  { numbers: [12, 200, -31, 255, -255, 4, 0, 1, -1], red: 255, green: 300, share: 0 },
];

test("numbers of backs have the one colour that comes with them, and the direct part's share, within half a step of sixteen", () => {
  const rows = BACKS.map(({ numbers, red, green, share }) => [...numbers, red, green, share]), scale = 0.01;
  const told = unpackedBacks(packed(rows), 2, scale, true), whole = unpackedBacks(packed(rows.map((row) => row.slice(0, -1))), 2, scale, false);
  assert.deepEqual(whole, { ...told, direct: null });
  BACKS.forEach(({ numbers, red, green, share }, vertex) => numbers.forEach((number, i) => {
    const wanted = [red / 255, green / 255, 3 - (red + green) / 255].map((value) => number * scale * value);
    wanted.forEach((value, c) => assert.ok(Math.abs(told.scale * told.numbers[NUMBERS * vertex + 3 * i + c]! - value) < 0.51 * (scale / 16)));
    const direct = told.scale * told.direct![DIRECT_STRIDE * vertex + 4 * Math.floor(i / 3) + (i % 3)]!;
    assert.ok(Math.abs(direct - (number * scale * share) / 255) < 0.51 * (scale / 16));
  }));
});

test("what is not whole is refused in a sentence", () => {
  assert.throws(() => unpacked(new Uint8Array(53), 1, TINTS, false), /The page is not whole/);
  assert.throws(() => unpacked(new Uint8Array(54), 1, TINTS, true), /The page is not whole/);
  assert.throws(() => unpackedBacks(new Uint8Array(22), 1, 1, true), /The page is not whole/);
});
