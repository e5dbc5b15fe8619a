// SPDX-License-Identifier: MIT
// From linear light to what a screen is sent: Blender's view transform Standard, and tables of any other.

/** The sRGB transfer function of IEC 61966-2-1, of a value that is first clamped to 0..1. */
export function standard(linear: number): number {
  const value = Math.min(Math.max(linear, 0), 1);
  return value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055;
}

/** Linear light where a table begins to be logarithmic, and where it ends: stops about middle grey, which is 0.18. */
export const TABLE_TOE = 0.18 * 2 ** -6;
export const TABLE_TOP = 0.18 * 2 ** 8;

/** Where in a table, in 0..1, the row of a linear value lies; a table is asked once per channel. */
export function tableCoordinate(linear: number): number {
  const value = Math.min(Math.max(linear, 0), TABLE_TOP);
  return Math.log2(value / TABLE_TOE + 1) / Math.log2(TABLE_TOP / TABLE_TOE + 1);
}

/** Both in GLSL. `table` has as many texels along each side as `size` says. */
export const GLSL_VIEW = `
vec3 standardView(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}
vec3 tableView(highp sampler3D table, vec3 c) {
  float size = float(textureSize(table, 0).x);
  vec3 at = log2(clamp(c, 0.0, ${TABLE_TOP.toFixed(6)}) / ${TABLE_TOE.toFixed(9)} + 1.0) / ${Math.log2(TABLE_TOP / TABLE_TOE + 1).toFixed(9)};
  return texture(table, (at * (size - 1.0) + 0.5) / size).rgb;
}`;
