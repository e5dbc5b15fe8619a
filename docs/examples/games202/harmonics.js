// SPDX-License-Identifier: GPL-3.0-or-later
// Harmonics turns light, as the homework does: band by band, M = S A^-1 from 2l + 1 directions.
"use strict";

const Harmonics = {
  /** The nine harmonics at a unit direction, in the course's signs (Condon-Shortley), the pole along z. */
  basis([x, y, z]) {
    return [
      0.28209479,
      -0.48860251 * y, 0.48860251 * z, -0.48860251 * x,
      1.09254843 * x * y, -1.09254843 * y * z, 0.31539157 * (3 * z * z - 1), -1.09254843 * x * z, 0.54627422 * (x * x - y * y),
    ];
  },

  /** Light (nine [r, g, b]) of the sky turned by R, three rows: what was along w is along R w. */
  turned(light, R) {
    const found = [light[0]];
    for (const band of [1, 2]) {
      const own = light.slice(band * band, (band + 1) ** 2);
      for (const row of Harmonics._bandMatrix(band, R))
        found.push([0, 1, 2].map((channel) => row.reduce((sum, m, i) => sum + m * own[i][channel], 0)));
    }
    return found;
  },

  /** Light as three `mat3`, one per channel. */
  byChannel(light) {
    return [0, 1, 2].flatMap((channel) => light.map((rgb) => rgb[channel]));
  },

  /** M with Y(R d) = M Y(d), of which the columns of S and A are such at some directions: M A = S, so A^T M^T = S^T. */
  _bandMatrix(band, R) {
    const at = (d) => Harmonics.basis(d).slice(band * band, (band + 1) ** 2);
    const directions = Harmonics._DIRECTIONS[band];
    const before = directions.map(at);
    const after = directions.map((d) => at(R.map((row) => row[0] * d[0] + row[1] * d[1] + row[2] * d[2])));
    const transposed = Harmonics._solved(before, after);
    return transposed.map((_, i) => transposed.map((row) => row[i]));
  },

  /** X of A X = B, by elimination with pivots. */
  _solved(A, B) {
    const rows = A.map((row, i) => [...row, ...B[i]]), size = rows.length;
    for (let k = 0; k < size; k++) {
      let pivot = k;
      for (let i = k + 1; i < size; i++) if (Math.abs(rows[i][k]) > Math.abs(rows[pivot][k])) pivot = i;
      [rows[k], rows[pivot]] = [rows[pivot], rows[k]];
      rows[k] = rows[k].map((value) => value / rows[k][k]);
      for (let i = 0; i < size; i++)
        if (i !== k) rows[i] = rows[i].map((value, j) => value - rows[i][k] * rows[k][j]);
    }
    return rows.map((row) => row.slice(size));
  },

  /** Spread so that A is far from singular. */
  _DIRECTIONS: {
    1: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    2: [[1, 0, 0], [0, 0, 1], [Math.SQRT1_2, Math.SQRT1_2, 0], [Math.SQRT1_2, 0, Math.SQRT1_2], [0, Math.SQRT1_2, Math.SQRT1_2]],
  },
};
