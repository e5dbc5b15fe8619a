// SPDX-License-Identifier: MIT
// What a bake stores on a mesh, as docs/formats.md has it: nine layers of four floats, and three more of backs.

/** Coefficients of bands 0 to 2. */
export const COEFFICIENTS = 9;

/** The layers' names in a glTF file. */
export const LAYERS: readonly string[] = Array.from({ length: COEFFICIENTS }, (_, i) => `_PRT_${i}`);

/** Names of the layers of backs: nine numbers less 1 in the first, and as alphas the direct share, red and green of what they are times. */
export const BACKS: readonly string[] = Array.from({ length: COEFFICIENTS / 3 }, (_, k) => `_PRT_B${k}`);

/** Alpha of the first layer, where there is transport; red of the first of backs, where these have some. */
export const BAKED_BELOW = -0.5;

/** Alpha of the first layer, where the transport is in the object's own axes. */
export const OWN_AXES_BELOW = -1.5;

/** What a layer's colour and alpha are multiplied by, where a file stores it in 16 bits. */
export type LayerScales = readonly [colour: number, alpha: number];

/** The scales in the extras of a glTF file's primitive, of its layers or of those of its backs; 1 where there are none, as of floats. */
export function layerScales(extras: unknown, of: "scales" | "backs" = "scales"): readonly LayerScales[] {
  const scales = ((extras ?? {}) as Record<string, readonly LayerScales[] | undefined>)[of], { length } = of === "backs" ? BACKS : LAYERS;
  if (!scales) return Array.from({ length }, () => [1, 1]);
  if (scales.length !== length || scales.some((pair) => pair.length !== 2 || !pair.every(Number.isFinite))) {
    throw new Error(`A primitive's extras hold ${length} pairs of scales, and not these.`);
  }
  return scales;
}

/** RGB coefficients of a sky, one after the other, linear radiance: nine, which are 27 numbers, but where an order is told. */
export type Light = Float64Array;

export function lightOf(coefficients: readonly (readonly number[])[]): Light {
  if (coefficients.length !== COEFFICIENTS || coefficients.some((rgb) => rgb.length !== 3)) {
    throw new Error(`A light has ${COEFFICIENTS} RGB coefficients, and not these ${coefficients.length}.`);
  }
  return Float64Array.from(coefficients.flat());
}
