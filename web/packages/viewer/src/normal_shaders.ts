// SPDX-License-Identifier: MIT
// Normals that pictures bend.

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
  vec3 across = cross(dFdy(spot), n), along = cross(n, dFdx(spot));
  vec2 right = dFdx(at), down = dFdy(at);
  vec3 tangent = across * right.x + along * down.x, bitangent = across * right.y + along * down.y;
  float scale = inversesqrt(max(max(dot(tangent, tangent), dot(bitangent, bitangent)), 1e-30));
  n = normalize(normalScale * scale * (detail.x * tangent - detail.y * bitangent) + detail.z * n);
#endif
  return n;
}`;
