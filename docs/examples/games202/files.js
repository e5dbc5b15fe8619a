// SPDX-License-Identifier: GPL-3.0-or-later
// Files reads the course's text files and the mesh they belong to; what is wrong with one is said in a sentence.
"use strict";

const Files = {
  FACES: ["posx", "negx", "posy", "negy", "posz", "negz"],

  /** light.txt: nine [r, g, b], in the course's signs and axes. */
  light(text) {
    const rows = Files._rows(text, 3, "light.txt");
    if (rows.length !== 9) throw new Error(`light.txt has ${rows.length} rows, but a light has 9: export it again.`);
    return rows;
  },

  /** transport.txt: nine numbers per face corner, one after the other, after the line with the number of vertices. */
  transport(text, corners) {
    const rows = Files._rows(text.slice(text.indexOf("\n") + 1), 9, "transport.txt");
    if (rows.length !== corners)
      throw new Error(`transport.txt has ${rows.length} rows, but the mesh has ${corners} face corners: choose the mesh it was made from.`);
    return new Float32Array(rows.flat());
  },

  /** An .obj's face corners in the order of its faces, three numbers each: places, unit normals, and albedos, which are 1
      but where vertices have colours. */
  mesh(text) {
    const vertices = [], normals = [], mesh = { places: [], normals: [], albedos: [] };
    for (const line of text.split("\n")) {
      const [kind, ...words] = line.trim().split(/\s+/);
      if (kind === "v") vertices.push(words.map(Number));
      if (kind === "vn") normals.push(words.map(Number));
      if (kind !== "f") continue;
      if (words.length !== 3) throw new Error("The mesh has faces that are no triangles: triangulate it, bake and export again.");
      const indices = words.map((word) => word.split("/"));
      const corners = indices.map(([vertex]) => Files._named(vertices, vertex));
      const flat = Files._flatNormal(corners);
      corners.forEach((corner, i) => {
        mesh.places.push(...corner.slice(0, 3));
        mesh.normals.push(...(indices[i][2] ? Files._named(normals, indices[i][2]) : flat));
        mesh.albedos.push(...(corner.length === 6 ? corner.slice(3).map(Files._linear) : [1, 1, 1]));
      });
    }
    if (!mesh.places.length) throw new Error("The mesh has no faces: choose an .obj that has.");
    return Object.fromEntries(Object.entries(mesh).map(([name, values]) => [name, new Float32Array(values)]));
  },

  /** Of a list, what an .obj calls by 1, 2, ... or, from its end, by -1, -2, ... */
  _named(list, word) {
    const index = parseInt(word, 10);
    return list[index < 0 ? list.length + index : index - 1];
  },

  _flatNormal([a, b, c]) {
    const [u, v] = [b, c].map((corner) => [0, 1, 2].map((k) => corner[k] - a[k]));
    const across = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const length = Math.hypot(...across) || 1;
    return across.map((value) => value / length);
  },

  /** Colours of vertices are encoded by the sRGB curve, as Blender writes them. */
  _linear(value) {
    return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  },

  _rows(text, columns, name) {
    const rows = text.split("\n").filter((line) => line.trim()).map((line) => line.trim().split(/[\s,]+/).map(Number));
    const broken = rows.findIndex((row) => row.length !== columns || !row.every(Number.isFinite));
    if (broken >= 0) throw new Error(`${name}: row ${broken + 1} does not hold ${columns} numbers; is the file cut off?`);
    return rows;
  },
};
