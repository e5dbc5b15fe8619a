// SPDX-License-Identifier: MIT
// Coarser meshes.

import assert from "node:assert/strict";
import { test } from "node:test";
import { coarsened, coarser, ENOUGH } from "../src/coarse.js";
import type { Mesh, Model } from "../src/model.js";
import { DIRECT_STRIDE, NUMBERS } from "../src/transport.js";

/** A square sheet of so many vertices a side, seen from both, as two meshes' worth of vertices in one place. */
function sheet(side: number): Mesh {
  const positions: number[] = [], normals: number[] = [], triangles: number[] = [];
  for (const up of [1, -1]) {
    const first = positions.length / 3;
    for (let y = 0; y < side; y++) for (let x = 0; x < side; x++) {
      positions.push(x / (side - 1), y / (side - 1), 0);
      normals.push(0, 0, up);
    }
    for (let y = 0; y + 1 < side; y++) {
      for (let x = 0; x + 1 < side; x++) {
        const [a, b, c, d] = [first + y * side + x, first + y * side + x + 1, first + (y + 1) * side + x + 1, first + (y + 1) * side + x];
        triangles.push(...(up > 0 ? [a, b, c, a, c, d] : [a, c, b, a, d, c]));
      }
    }
  }
  const vertices = positions.length / 3;
  return {
    name: "Sheet", vertices, positions: Float32Array.from(positions), normals: Float32Array.from(normals), coordinates: [null, null],
    triangles: Uint32Array.from(triangles), material: {} as Mesh["material"],
    transport: {
      numbers: Int16Array.from({ length: NUMBERS * vertices }, (_, k) => k % 500), scale: 1, inOwnAxes: false,
      direct: Int16Array.from({ length: DIRECT_STRIDE * vertices }, (_, k) => k % 60),
      backs: { numbers: Int16Array.from({ length: NUMBERS * vertices }, (_, k) => k % 499), scale: 2, direct: null },
    },
  };
}

/** Signed area of the triangles that look up and of those that look down. */
function areas({ positions: p, triangles: t }: Mesh): [number, number] {
  const found: [number, number] = [0, 0];
  for (let k = 0; k < t.length; k += 3) {
    const [a, b, c] = [3 * t[k]!, 3 * t[k + 1]!, 3 * t[k + 2]!];
    const area = ((p[b]! - p[a]!) * (p[c + 1]! - p[a + 1]!) - (p[c]! - p[a]!) * (p[b + 1]! - p[a + 1]!)) / 2;
    found[area > 0 ? 0 : 1] += Math.abs(area);
  }
  return found;
}

test("fewer vertices, each with all that was its own, and both sides of a sheet nearly whole", () => {
  const fine = sheet(60), coarse = coarser(fine, 800);
  assert.ok(coarse.vertices <= 800 && coarse.vertices > 500, `${coarse.vertices}`);
  assert.ok(coarse.triangles.length < fine.triangles.length / 5 && Math.max(...coarse.triangles) < coarse.vertices);
  for (const area of areas(coarse)) assert.ok(area > 0.85 && area <= 1, `${area}`);
  for (const vertex of [0, 17, coarse.vertices - 1]) {
    const row = (values: ArrayLike<number>, width: number, at: number) => Array.from({ length: width }, (_, k) => values[width * at + k]);
    const places = Array.from({ length: fine.vertices }, (_, k) => k).filter((k) =>
      [...row(fine.positions, 3, k), ...row(fine.normals, 3, k)].join() === [...row(coarse.positions, 3, vertex), ...row(coarse.normals, 3, vertex)].join());
    assert.equal(places.length, 1);
    assert.deepEqual(row(coarse.transport!.numbers, NUMBERS, vertex), row(fine.transport!.numbers, NUMBERS, places[0]!));
    assert.deepEqual(row(coarse.transport!.backs!.numbers, NUMBERS, vertex), row(fine.transport!.backs!.numbers, NUMBERS, places[0]!));
    assert.deepEqual(row(coarse.transport!.direct!, DIRECT_STRIDE, vertex), row(fine.transport!.direct!, DIRECT_STRIDE, places[0]!));
  }
});

test("small meshes, and those of small models, are the same", () => {
  const small = sheet(10);
  assert.equal(coarser(small, 200), small);
  assert.equal(coarsened({ instances: [{ mesh: small }, { mesh: small }] } as unknown as Model).get(small), small);
});

test("all meshes of a large model together have about what is enough", () => {
  const meshes = [sheet(120), sheet(60)], model = { instances: [...meshes, meshes[0]!].map((mesh) => ({ mesh })) } as unknown as Model;
  const found = coarsened(model), total = 2 * found.get(meshes[0]!)!.vertices + found.get(meshes[1]!)!.vertices;
  assert.ok(total <= ENOUGH + 3 && total > 0.6 * ENOUGH, `${total}`);
});

test("a mesh without extent, or of one vertex, stays drawable", () => {
  const point = { ...sheet(4), positions: new Float32Array(3 * 32) };
  const found = coarser(point, 8);
  assert.ok(found.vertices <= 8 && found.triangles.length === 0);
});
