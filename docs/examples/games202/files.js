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

  /** Places of an .obj's face corners, three numbers each, in the order of its faces; polygons are no triangles. */
  corners(text) {
    const vertices = [], corners = [];
    for (const line of text.split("\n")) {
      const words = line.trim().split(/\s+/);
      if (words[0] === "v") vertices.push(words.slice(1, 4).map(Number));
      if (words[0] !== "f") continue;
      if (words.length !== 4) throw new Error("The mesh has faces that are no triangles: triangulate it, bake and export again.");
      for (const word of words.slice(1)) {
        const index = parseInt(word, 10);
        corners.push(...vertices[index < 0 ? vertices.length + index : index - 1]);
      }
    }
    if (!corners.length) throw new Error("The mesh has no faces: choose an .obj that has.");
    return new Float32Array(corners);
  },

  _rows(text, columns, name) {
    const rows = text.split("\n").filter((line) => line.trim()).map((line) => line.trim().split(/[\s,]+/).map(Number));
    const broken = rows.findIndex((row) => row.length !== columns || !row.every(Number.isFinite));
    if (broken >= 0) throw new Error(`${name}: row ${broken + 1} does not hold ${columns} numbers; is the file cut off?`);
    return rows;
  },
};
