// SPDX-License-Identifier: MIT
// Coarser meshes for movements on slow machines: vertices of a cell that face alike become one of them (Rossignac and Borrel, 1993).

import type { Mesh, Model } from "./model.js";
import { withVertices } from "./rows.js";

/**
 * Vertices of a whole model: about one for fourteen pixels of the coarsest picture of a screen of 1280 x 720. Smaller triangles take a
 * machine without a graphics card as long as their pixels: half as many vertices take a quarter to a third off a frame.
 */
export const ENOUGH = 6_500;

const LEAST = 500; // of a mesh: small ones keep their shape
const STEPS = 12; // of the bisection by which the size of cells is found
const MOST_CELLS = 1024; // along each axis

/** Each mesh of a model with its share of `ENOUGH` vertices; the same meshes where there are no more. */
export function coarsened({ instances }: Model): Map<Mesh, Mesh> {
  const total = instances.reduce((sum, { mesh }) => sum + mesh.vertices, 0), meshes = new Set(instances.map(({ mesh }) => mesh));
  return new Map([...meshes].map((mesh) => [mesh, coarser(mesh, Math.max(LEAST, Math.ceil(mesh.vertices * Math.min(1, ENOUGH / total))))]));
}

/** A mesh with at most so many vertices, 8 or more, which are some of its own. */
export function coarser(mesh: Mesh, most: number): Mesh {
  if (mesh.vertices <= most) return mesh;
  const { positions } = mesh, least = [Infinity, Infinity, Infinity], greatest = [-Infinity, -Infinity, -Infinity];
  positions.forEach((value, k) => {
    least[k % 3] = Math.min(least[k % 3]!, value);
    greatest[k % 3] = Math.max(greatest[k % 3]!, value);
  });
  const extent = Math.max(...greatest.map((value, k) => value - least[k]!)) || 1;
  let small = extent / (MOST_CELLS - 1), large = 2 * extent, cells = cellsOf(mesh, least, large);
  for (let step = 0; step < STEPS; step++) {
    const size = Math.sqrt(small * large), found = cellsOf(mesh, least, size);
    if (found.count > most) small = size;
    else [large, cells] = [size, found];
  }
  return joined(mesh, cells);
}

interface Cells {
  /** The cell of each vertex. */
  readonly of: Uint32Array;
  readonly count: number;
}

/** Cells of a size, each for one of the eight ways in which normals look: sheets keep both sides, and edges stay hard. */
function cellsOf({ positions, normals, vertices }: Mesh, least: readonly number[], size: number): Cells {
  const numbers = new Map<number, number>(), of = new Uint32Array(vertices);
  for (let vertex = 0, k = 0; vertex < vertices; vertex++, k += 3) {
    let key = 0;
    for (let axis = 0; axis < 3; axis++) key = key * MOST_CELLS + Math.floor((positions[k + axis]! - least[axis]!) / size);
    key = key * 8 + Number(normals[k]! < 0) + 2 * Number(normals[k + 1]! < 0) + 4 * Number(normals[k + 2]! < 0);
    let number = numbers.get(key);
    if (number === undefined) numbers.set(key, (number = numbers.size));
    of[vertex] = number;
  }
  return { of, count: numbers.size };
}

/** The mesh with one vertex for each cell, the nearest to the mean of its vertices, and the triangles that still are some. */
function joined(mesh: Mesh, { of, count }: Cells): Mesh {
  const kept = middles(mesh, { of, count }), triangles: number[] = [];
  for (let k = 0; k < mesh.triangles.length; k += 3) {
    const [a, b, c] = [of[mesh.triangles[k]!]!, of[mesh.triangles[k + 1]!]!, of[mesh.triangles[k + 2]!]!];
    if (a !== b && b !== c && c !== a) triangles.push(a, b, c);
  }
  return withVertices(mesh, kept, Uint32Array.from(triangles));
}

function middles({ positions, vertices }: Mesh, { of, count }: Cells): Uint32Array {
  const sums = new Float64Array(3 * count), sizes = new Uint32Array(count);
  for (let vertex = 0; vertex < vertices; vertex++) {
    const cell = of[vertex]!;
    sizes[cell]!++;
    for (let axis = 0; axis < 3; axis++) sums[3 * cell + axis]! += positions[3 * vertex + axis]!;
  }
  const kept = new Uint32Array(count), nearest = new Float64Array(count).fill(Infinity);
  for (let vertex = 0; vertex < vertices; vertex++) {
    const cell = of[vertex]!;
    let square = 0;
    for (let axis = 0; axis < 3; axis++) square += (positions[3 * vertex + axis]! - sums[3 * cell + axis]! / sizes[cell]!) ** 2;
    if (square < nearest[cell]!) [nearest[cell], kept[cell]] = [square, vertex];
  }
  return kept;
}
