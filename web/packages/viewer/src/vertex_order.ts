// SPDX-License-Identifier: MIT
// Triangles and vertices in an order in which graphics cards reckon few vertices twice (Sander, Nehab and Barczak 2007, "Fast Triangle
// Reordering for Vertex Locality and Reduced Overdraw"): triangle after triangle around one vertex, then around one that is still kept.

import type { Mesh } from "./model.js";
import { withVertices } from "./rows.js";

const KEPT = 24; // vertices: cards keep more, but by other rules

/** The same mesh, its vertices numbered as triangles first use them; those that none uses are left out. */
export function ordered(mesh: Mesh): Mesh {
  if (!mesh.triangles.length) return mesh;
  const triangles = fanned(mesh.triangles, mesh.vertices), numbers = new Int32Array(mesh.vertices).fill(-1), before: number[] = [];
  const renumbered = triangles.map((vertex) => {
    if (numbers[vertex]! < 0) numbers[vertex] = before.push(vertex) - 1;
    return numbers[vertex]!;
  });
  return withVertices(mesh, Uint32Array.from(before), renumbered);
}

function fanned(triangles: Uint32Array, vertices: number): Uint32Array {
  const { first, around } = fans(triangles, vertices), left = Uint32Array.from({ length: vertices }, (_, v) => first[v + 1]! - first[v]!);
  const out = new Uint32Array(triangles.length), taken = new Uint8Array(triangles.length / 3), times = new Int32Array(vertices).fill(-KEPT);
  const recent: number[] = [];
  for (let fan = 0, next = 0, time = 0, at = 0; fan >= 0; ) {
    const ring: number[] = [];
    for (let k = first[fan]!; k < first[fan + 1]!; k++) {
      const triangle = around[k]!;
      if (taken[triangle]) continue;
      taken[triangle] = 1;
      for (let corner = 3 * triangle; corner < 3 * triangle + 3; corner++) {
        const vertex = triangles[corner]!;
        out[at++] = vertex;
        ring.push(vertex);
        left[vertex]!--;
        if (time - times[vertex]! >= KEPT) times[vertex] = time++;
      }
    }
    recent.push(...ring);
    fan = best(ring, left, times, time);
    while (fan < 0 && recent.length) if (left[recent.at(-1)!]! > 0) fan = recent.at(-1)!; else recent.pop();
    while (fan < 0 && next < vertices) if (left[next]! > 0) fan = next; else next++;
  }
  return out;
}

/** The triangles around each vertex: those of vertex v from `first[v]` on. */
function fans(triangles: Uint32Array, vertices: number): { first: Uint32Array; around: Uint32Array } {
  const first = new Uint32Array(vertices + 1), around = new Uint32Array(triangles.length);
  for (const vertex of triangles) first[vertex + 1]!++;
  for (let v = 0; v < vertices; v++) first[v + 1]! += first[v]!;
  const filled = first.slice();
  triangles.forEach((vertex, corner) => (around[filled[vertex]!++] = Math.floor(corner / 3)));
  return { first, around };
}

/** Of the vertices just used, the one kept the longest that still will be when its own triangles have been drawn; -1 if all are done. */
function best(ring: readonly number[], left: Uint32Array, times: Int32Array, time: number): number {
  let chosen = -1, most = -1;
  for (const vertex of ring) {
    if (!left[vertex]) continue;
    const age = time - times[vertex]!, worth = age + 2 * left[vertex]! <= KEPT ? age : 0;
    if (worth > most) [chosen, most] = [vertex, worth];
  }
  return chosen;
}
