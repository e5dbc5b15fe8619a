// SPDX-License-Identifier: MIT
// Normals that pictures bend, and the soft light that they get by it.

import { K_1, K_XY, K_ZZ } from "@prt-relight/core";

/** A normal as the surface's picture has it, by the frame that derivatives of place and coordinates give (Schueler 2013, "Normal Mapping Without Precomputed Tangents"). */
export const GLSL_NORMALS = `
uniform sampler2D normalTexture;
uniform vec4 normalPlacing;
uniform int normalCoordinates;
uniform float normalScale;

vec3 detailed(vec3 n) {
#ifdef NORMAL_PICTURE
  vec2 at = placed(normalPlacing, normalCoordinates);
  vec3 detail = 2.0 * texture(normalTexture, at).rgb - 1.0;
  if (!gl_FrontFacing) detail.xy = -detail.xy; // EEVEE's bent normals of backs are those of fronts, turned round
  vec3 across = cross(dFdy(spot), n), along = cross(n, dFdx(spot));
  vec2 right = dFdx(at), down = dFdy(at);
  vec3 tangent = across * right.x + along * down.x, bitangent = across * right.y + along * down.y;
  float scale = inversesqrt(max(max(dot(tangent, tangent), dot(bitangent, bitangent)), 1e-30));
  n = normalize(normalScale * scale * (detail.x * tangent - detail.y * bitangent) + detail.z * n);
#endif
  return n;
}`;

/**
 * What a bent normal adds to the soft light, as in EEVEE: the gradient, along the surface's own normal, of what the open sky lights a white
 * surface with, `sum A_l / pi L_lm Y_lm(n)` (Ramamoorthi and Hanrahan 2001), by the share of sky that is seen.
 */
export const GLSL_DETAIL = `
centroid in vec2 openSky;
uniform vec3 soft[9]; // the sky without its suns, in the world's axes

vec3 moreLight(vec3 n, vec3 bent) {
  vec3 by = bent - n;
  vec3 straight = soft[3] * by.x + soft[1] * by.y + soft[2] * by.z;
  vec3 curved = (soft[4] * n.y + soft[7] * n.z + soft[8] * n.x) * by.x
    + (soft[4] * n.x + soft[5] * n.z - soft[8] * n.y) * by.y
    + (soft[5] * n.y + soft[7] * n.x + ${((6 * K_ZZ) / K_XY).toFixed(9)} * soft[6] * n.z) * by.z;
  return (gl_FrontFacing ? openSky.x : openSky.y) * (${((2 * K_1) / 3).toFixed(9)} * straight + ${(K_XY / 4).toFixed(9)} * curved);
}`;
