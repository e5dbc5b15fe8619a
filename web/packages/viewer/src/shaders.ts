// SPDX-License-Identifier: MIT
// What runs on the graphics card: meshes under their light, the sky behind them, and the view transform of both.

import { GLSL_VIEW, GLSL_WITHOUT_NEGATIVES, K_0, K_1, K_XX, K_XY, K_ZZ } from "@prt-relight/core";

const HEAD = `#version 300 es
precision highp float;
precision highp int;
`;

/** View: 0 shows light as it is, for measurements; 1 is Standard; 2 asks the table. */
const DISPLAY = `
uniform float exposure;
uniform int view;
uniform highp sampler3D table;
${GLSL_VIEW}
vec3 displayed(vec3 light) {
  if (view == 0) return light;
  light *= exposure;
  return view == 1 ? standardView(light) : tableView(table, light);
}`;

/** The light, its coefficients scaled as the layer's whole numbers need it; and unshadowed, by the lobe of the cosine. */
export const MESH_VERTEX = `${HEAD}
in vec3 position;
in vec3 normal;
in vec2 coordinates0;
in vec2 coordinates1;
uniform highp isampler2D transport;
uniform mat4 world, clip;
uniform mat3 normals;
uniform vec3 light[9];
uniform vec3 lobes[9];
uniform bool baked;
out vec3 radiance;
out vec2 place0, place1;

vec3 bakedLight() {
  int width = textureSize(transport, 0).x;
  vec3 sum = vec3(0.0);
  for (int i = 0; i < 9; i++) {
    int at = 9 * gl_VertexID + i;
    sum += vec3(texelFetch(transport, ivec2(at % width, at / width), 0).rgb) * light[i];
  }
  return sum;
}

vec3 unshadowedLight(vec3 n) {
  return ${K_0.toFixed(9)} * lobes[0]
    + ${K_1.toFixed(9)} * (n.y * lobes[1] + n.z * lobes[2] + n.x * lobes[3])
    + ${K_XY.toFixed(9)} * (n.x * n.y * lobes[4] + n.y * n.z * lobes[5] + n.x * n.z * lobes[7])
    + ${K_ZZ.toFixed(9)} * (3.0 * n.z * n.z - 1.0) * lobes[6]
    + ${K_XX.toFixed(9)} * (n.x * n.x - n.y * n.y) * lobes[8];
}

void main() {
  radiance = baked ? bakedLight() : unshadowedLight(normalize(normals * normal));
  place0 = coordinates0;
  place1 = coordinates1;
  gl_Position = clip * world * vec4(position, 1.0);
}`;

export const MESH_FRAGMENT = `${HEAD}
in vec3 radiance;
in vec2 place0, place1;
uniform vec4 colour;
uniform vec3 emission;
uniform sampler2D colourTexture, emissionTexture;
uniform vec4 colourPlacing, emissionPlacing;
uniform ivec2 coordinates;
uniform float cutoff;
uniform bool white;
out vec4 shown;
${GLSL_WITHOUT_NEGATIVES}
${DISPLAY}
vec2 placed(vec4 placing, int index) {
  return (index == 1 ? place1 : place0) * placing.zw + placing.xy;
}

void main() {
  vec4 surface = colour * texture(colourTexture, placed(colourPlacing, coordinates.x));
  if (surface.a < cutoff) discard;
  vec3 glow = emission * texture(emissionTexture, placed(emissionPlacing, coordinates.y)).rgb;
  vec3 light = withoutNegatives(radiance);
  shown = vec4(displayed(white ? light : surface.rgb * light + glow), surface.a);
}`;

export const SKY_VERTEX = `${HEAD}
uniform vec3 tangents; // across, up, and how far the middle is lifted
uniform mat3 toPicture;
out vec3 direction;
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  direction = toPicture * vec3((corner - vec2(0.0, tangents.z)) * tangents.xy, -1.0);
  gl_Position = vec4(corner, 1.0, 1.0);
}`;

/** The picture is smoothed by cubic B-splines, as four bilinear looks: it is coarser than the screen. */
export const SKY_FRAGMENT = `${HEAD}
in vec3 direction;
uniform sampler2D picture;
uniform float strength;
out vec4 shown;
${DISPLAY}
vec3 smoothed(vec2 at) {
  vec2 size = vec2(textureSize(picture, 0));
  vec2 texel = at * size - 0.5, part = fract(texel), whole = floor(texel);
  vec2 far = 1.0 - part;
  vec2 w0 = far * far * far / 6.0, w3 = part * part * part / 6.0;
  vec2 w1 = 2.0 / 3.0 - part * part * (2.0 - part) / 2.0, w2 = 1.0 - w0 - w1 - w3;
  vec2 low = w0 + w1, high = w2 + w3;
  vec2 a = (whole - 0.5 + w1 / low) / size, b = (whole + 1.5 + w3 / high) / size;
  return low.y * (low.x * textureLod(picture, a, 0.0).rgb + high.x * textureLod(picture, vec2(b.x, a.y), 0.0).rgb)
    + high.y * (low.x * textureLod(picture, vec2(a.x, b.y), 0.0).rgb + high.x * textureLod(picture, b, 0.0).rgb);
}

void main() {
  vec3 w = normalize(direction);
  vec2 at = vec2(0.5 - atan(w.y, w.x) / 6.283185307, 0.5 - asin(clamp(w.z, -1.0, 1.0)) / 3.141592654);
  shown = vec4(displayed(strength * smoothed(at)), 1.0);
}`;
