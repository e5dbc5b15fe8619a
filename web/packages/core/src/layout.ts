// SPDX-License-Identifier: MIT
// What a bake stores on a mesh, as docs/formats.md has it: nine layers of four floats.

/** Coefficients of bands 0 to 2. */
export const COEFFICIENTS = 9;

/** The layers' names in a glTF file. */
export const LAYERS: readonly string[] = Array.from({ length: COEFFICIENTS }, (_, i) => `_PRT_${i}`);

/** Alpha of the first layer, where there is transport. */
export const BAKED_BELOW = -0.5;

/** Alpha of the first layer, where the transport is in the object's own axes. */
export const OWN_AXES_BELOW = -1.5;

/** What a layer's colour and alpha are multiplied by, where a file stores it in 16 bits. */
export type LayerScales = readonly [colour: number, alpha: number];

/** The scales in the extras of a glTF file's primitive; 1 where there are none, as of floats. */
export function layerScales(extras: unknown): readonly LayerScales[] {
  const { scales } = (extras ?? {}) as { scales?: readonly LayerScales[] };
  if (!scales) return LAYERS.map(() => [1, 1]);
  if (scales.length !== COEFFICIENTS || scales.some((pair) => pair.length !== 2 || !pair.every(Number.isFinite))) {
    throw new Error(`A primitive's extras hold ${COEFFICIENTS} pairs of scales, and not these.`);
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
