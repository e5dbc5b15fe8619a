// SPDX-License-Identifier: MIT
// Real spherical harmonics of any order, for what nine coefficients leave out: by the same index, sign and axes as the nine.

import type { Vector3 } from "./matrix.js";

/** How many coefficients all bands up to an order have. */
export function coefficientCount(order: number): number {
  return (order + 1) ** 2;
}

/**
 * Normalised associated Legendre functions of z by the sine to the power of m, at index l (l + 1) + m for m of 0 and more: polynomials
 * without trouble at the poles (Sloan 2013, "Efficient Spherical Harmonic Evaluation", section 2).
 */
export function legendre(z: number, order: number): Float64Array {
  const out = new Float64Array(coefficientCount(order)), at = (band: number, m: number) => band * (band + 1) + m;
  for (let m = 0, first = 1; m <= order; first *= 2 * ++m - 1) {
    out[at(m, m)] = first;
    if (m < order) out[at(m + 1, m)] = (2 * m + 1) * z * first;
    for (let band = m + 2; band <= order; band++) {
      out[at(band, m)] = ((2 * band - 1) * z * out[at(band - 1, m)]! - (band + m - 1) * out[at(band - 2, m)]!) / (band - m);
    }
  }
  const norms = normsOf(order);
  return out.map((value, i) => value * norms[i]!);
}

const known = new Map<number, Float64Array>();

/** What makes them orthonormal, once for each order. */
function normsOf(order: number): Float64Array {
  const norms = known.get(order) ?? new Float64Array(coefficientCount(order));
  if (known.has(order)) return norms;
  for (let band = 0; band <= order; band++) for (let m = 0; m <= band; m++) norms[band * (band + 1) + m] = norm(band, m);
  known.set(order, norms);
  return norms;
}

function norm(band: number, m: number): number {
  let square = ((m ? 2 : 1) * (2 * band + 1)) / (4 * Math.PI);
  for (let k = band - m + 1; k <= band + m; k++) square /= k;
  return Math.sqrt(square);
}

/** The harmonics along a unit vector, up to an order. */
export function harmonics([x, y, z]: Vector3, order: number): Float64Array {
  const polar = legendre(z, order), out = new Float64Array(polar.length);
  for (let m = 0, cos = 1, sin = 0; m <= order; m++, [cos, sin] = [cos * x - sin * y, cos * y + sin * x]) {
    for (let band = m; band <= order; band++) {
      const centre = band * (band + 1);
      out[centre - m] = polar[centre + m]! * sin;
      out[centre + m] = polar[centre + m]! * cos;
    }
  }
  return out;
}
