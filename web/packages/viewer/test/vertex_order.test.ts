// SPDX-License-Identifier: MIT
// The order of triangles and vertices.

import assert from "node:assert/strict";
import { test } from "node:test";
import type { Mesh } from "../src/model.js";
import { DIRECT_STRIDE, NUMBERS } from "../src/transport.js";
import { ordered } from "../src/vertex_order.js";

const SIDE = 80;

/** A square sheet, row by row, and a vertex that no triangle uses. */
function sheet(): Mesh {
  const triangles: number[] = [], vertices = SIDE * SIDE + 1;
  for (let y = 0; y + 1 < SIDE; y++) {
    for (let x = 0; x + 1 < SIDE; x++) {
      const [a, b, c, d] = [y * SIDE + x, y * SIDE + x + 1, (y + 1) * SIDE + x + 1, (y + 1) * SIDE + x];
      triangles.push(a, b, c, a, c, d);
    }
  }
  const numbered = (width: number) => Array.from({ length: width * vertices }, (_, k) => k);
  return {
    name: "Sheet", vertices, positions: Float32Array.from(numbered(3)), normals: Float32Array.from(numbered(3)),
    coordinates: [Float32Array.from(numbered(2)), null], triangles: Uint32Array.from(triangles), material: {} as Mesh["material"],
    transport: {
      numbers: Int16Array.from(numbered(NUMBERS), (k) => k % 500), scale: 1, inOwnAxes: false,
      direct: Int16Array.from(numbered(DIRECT_STRIDE), (k) => k % 60),
      backs: { numbers: Int16Array.from(numbered(NUMBERS), (k) => k % 499), scale: 2, direct: Int16Array.from(numbered(DIRECT_STRIDE), (k) => k % 59) },
    },
  };
}

/** Which vertices of the sheet a mesh's triangles are of; each begins with the least, as they may be turned but not mirrored. */
function corners({ positions, triangles }: Mesh): string[] {
  const found: string[] = [];
  for (let k = 0; k < triangles.length; k += 3) {
    const three = [0, 1, 2].map((corner) => positions[3 * triangles[k + corner]!]! / 3), least = three.indexOf(Math.min(...three));
    found.push([0, 1, 2].map((corner) => three[(least + corner) % 3]).join());
  }
  return found.sort();
}

/** How many vertices a card reckons that keeps so many, each in the place that its number says. */
function reckoned(triangles: Uint32Array, kept: number): number {
  const places = new Int32Array(kept).fill(-1);
  return triangles.reduce((count, vertex) => {
    const isKept = places[vertex % kept] === vertex;
    places[vertex % kept] = vertex;
    return count + Number(!isKept);
  }, 0);
}

test("the same triangles, each vertex with all that is its own, and none that is not used", () => {
  const before = sheet(), after = ordered(before);
  assert.equal(after.vertices, SIDE * SIDE);
  assert.deepEqual(corners(after), corners(before));
  const kept = Array.from({ length: after.vertices }, (_, vertex) => after.positions[3 * vertex]! / 3);
  const rows = (values: ArrayLike<number>, width: number) => kept.map((row) => Array.from({ length: width }, (_, k) => values[width * row + k]));
  assert.deepEqual([...after.coordinates[0]!], rows(before.coordinates[0]!, 2).flat());
  assert.deepEqual([...after.transport!.numbers], rows(before.transport!.numbers, NUMBERS).flat());
  assert.deepEqual([...after.transport!.direct!], rows(before.transport!.direct!, DIRECT_STRIDE).flat());
  const [found, wanted] = [after.transport!.backs!, before.transport!.backs!];
  assert.deepEqual([...found.numbers], rows(wanted.numbers, NUMBERS).flat());
  assert.deepEqual([...found.direct!], rows(wanted.direct!, DIRECT_STRIDE).flat());
  assert.equal(found.scale, 2);
});

test("few vertices are reckoned twice", () => {
  const before = sheet(), after = ordered(before);
  assert.ok(reckoned(before.triangles, 64) > 1.5 * before.vertices);
  assert.ok(reckoned(after.triangles, 64) < 1.35 * after.vertices);
  assert.ok(reckoned(after.triangles, 32) < 1.5 * after.vertices);
});

test("a mesh of no triangles keeps its place", () => {
  const points = { ...sheet(), triangles: new Uint32Array(0) };
  assert.equal(ordered(points), points);
});
