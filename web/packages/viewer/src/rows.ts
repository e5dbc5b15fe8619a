// SPDX-License-Identifier: MIT
// Some vertices of a mesh, with all that is theirs.

import type { Mesh } from "./model.js";
import { DIRECT_STRIDE, NUMBERS, type Side } from "./transport.js";

/** The mesh with these vertices in this order, and with triangles of them. */
export function withVertices(mesh: Mesh, kept: Uint32Array, triangles: Uint32Array): Mesh {
  const { positions, normals, coordinates, transport } = mesh;
  return {
    ...mesh,
    vertices: kept.length,
    positions: rows(positions, kept, 3),
    normals: rows(normals, kept, 3),
    coordinates: coordinates.map((pairs) => pairs && rows(pairs, kept, 2)),
    triangles,
    transport: transport && { ...transport, ...ofSide(transport, kept), backs: transport.backs && ofSide(transport.backs, kept) },
  };
}

function ofSide({ numbers, direct, scale }: Side, kept: Uint32Array): Side {
  return { numbers: rows(numbers, kept, NUMBERS), direct: direct && rows(direct, kept, DIRECT_STRIDE), scale };
}

/** Rows of an array, of so many numbers each. */
function rows<Numbers extends Float32Array | Int16Array>(from: Numbers, which: Uint32Array, width: number): Numbers {
  const out = new (from.constructor as new (length: number) => Numbers)(width * which.length);
  which.forEach((row, k) => {
    for (let column = 0; column < width; column++) out[width * k + column] = from[width * row + column]!;
  });
  return out;
}
