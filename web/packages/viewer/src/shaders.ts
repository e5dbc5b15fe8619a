// SPDX-License-Identifier: MIT
// What runs on the graphics card: meshes under their light, the sky behind them, and the view transform of both.

import { GLSL_VIEW, GLSL_WITHOUT_NEGATIVES, K_0, K_1, K_XX, K_XY, K_ZZ } from "@prt-relight/core";
import { GLSL_EQUIRECT, GLSL_GLOSS, GLSL_MIRRORS } from "./gloss_shaders.js";
import { GLSL_DETAIL, GLSL_NORMALS } from "./normal_shaders.js";
import { GLSL_SUNS } from "./sun_shaders.js";

export const HEAD = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
`;

/** What the program of a surface can do beside being lit; SHADOW keeps its depth alone, as a sun sees it. */
export type Feature =
  | "SHADOW"
  | "TEXTURED" | "GLOWING" | "GLOWING_PICTURE" | "CUT" | "CLEAR" | "WHITE"
  | "SUNNY" | "SUNNY_COARSELY" | "GLOSSY" | "GLOSSY_AT_VERTICES" | "GLOSS_PICTURE" | "NORMAL_PICTURE" | "SKY_SEEN" | "OPEN_SKY" | "TWO_SIDED";

/** The programs of a surface: vertex and fragment. */
export function surfaceShaders(features: readonly Feature[]): [string, string] {
  const defined = features.map((name) => `#define ${name}\n`).join("");
  const [vertex, fragment] = features.includes("SHADOW") ? [SHADOW_VERTEX, SHADOW_FRAGMENT] : [SURFACE_VERTEX, SURFACE_FRAGMENT];
  return [HEAD + defined + SHADED_AT_VERTICES + vertex, HEAD + defined + SHADED_AT_VERTICES + fragment];
}

/** Where nothing differs from pixel to pixel but what vertices know, they know it all: pixels have one colour to interpolate and not three. */
const SHADED_AT_VERTICES = `
#if defined(GLOSSY_AT_VERTICES) && !defined(TEXTURED) && !defined(SUNNY)
#define SHADED_AT_VERTICES
#endif
`;

/** The surface's own colour, with its alpha. */
const GLSL_COLOUR = `
in vec2 place0, place1;
uniform vec4 colour, colourPlacing;
uniform sampler2D colourTexture;
uniform int colourCoordinates;
uniform float cutoff;
vec2 placed(vec4 placing, int index) {
  return (index == 1 ? place1 : place0) * placing.zw + placing.xy;
}
vec4 ownColour() {
#ifdef TEXTURED
  return colour * texture(colourTexture, placed(colourPlacing, colourCoordinates));
#else
  return colour;
#endif
}`;

const SURFACE_VERTEX = `
in vec3 position;
in vec3 light, behind; // on its front and on its back
in vec2 coordinates0;
in vec2 coordinates1;
in vec3 normal, direct0, direct1, direct2, directBehind0, directBehind1, directBehind2;
uniform mat4 place, world;
uniform mat3 normals, toTransport;
uniform vec4 eye;
uniform vec2 directScales; // of front and back
centroid out vec3 radiance, radianceBehind; // within the triangle, also where only a part of a pixel is
out vec2 place0, place1;
centroid out vec3 facing;
out vec3 spot;
centroid out vec2 skySeen; // by front and back
centroid out vec2 openSky; // share of it that lights the surface, by front and back
centroid out vec3 factor, summand; // of the base colour, and to it
centroid out float diffuse; // what light from suns is multiplied by, too

#ifdef GLOSSY_AT_VERTICES
uniform vec4 colour;
${GLSL_WITHOUT_NEGATIVES}
${GLSL_MIRRORS}
#endif

#ifdef SKY_SEEN
// How much sky there is where a mirror looks: the direct transport along the mirrored view, by what it is in the open, as
// the relit surfaces of EEVEE have it. The last band is damped, as it rings.
float share(vec3 n, vec3 view, vec3 d0, vec3 d1, vec3 d2) {
  vec3 w = toTransport * reflect(-view, n);
  float cosine = abs(dot(n, view));
  float seen = ${K_0.toFixed(9)} * d0.x + ${K_1.toFixed(9)} * (w.y * d0.y + w.z * d0.z + w.x * d1.x);
  seen += 0.75 * (${K_XY.toFixed(9)} * (w.x * w.y * d1.y + w.y * w.z * d1.z + w.x * w.z * d2.y)
    + ${K_ZZ.toFixed(9)} * (3.0 * w.z * w.z - 1.0) * d2.x + ${K_XX.toFixed(9)} * (w.x * w.x - w.y * w.y) * d2.z);
  float open = (0.53125 + 2.0 * cosine + 1.40625 * cosine * cosine) / 12.566370614;
  return clamp(seen / open, 0.0, 1.0);
}
#endif

void main() {
  radiance = light;
#ifdef TWO_SIDED
  radianceBehind = behind;
#endif
  place0 = coordinates0;
  place1 = coordinates1;
  gl_Position = place * vec4(position, 1.0);
#if defined(GLOSSY) || defined(GLOSSY_AT_VERTICES) || defined(SUNNY) || defined(NORMAL_PICTURE)
  spot = (world * vec4(position, 1.0)).xyz;
  facing = normalize(normals * normal);
  skySeen = vec2(1.0);
#ifdef SKY_SEEN
  vec3 towards = normalize(eye.xyz - eye.w * spot);
  skySeen = vec2(share(facing, towards, directScales.x * direct0, directScales.x * direct1, directScales.x * direct2));
#ifdef TWO_SIDED
  skySeen.y = share(facing, towards, directScales.y * directBehind0, directScales.y * directBehind1, directScales.y * directBehind2);
#endif
#endif
#endif
#ifdef NORMAL_PICTURE
  openSky = vec2(1.0);
#ifdef OPEN_SKY
  openSky = directScales * vec2(direct0.x, directBehind0.x) / ${K_0.toFixed(9)};
#ifndef TWO_SIDED
  openSky.y = openSky.x;
#endif
#endif
#endif
#ifdef GLOSSY_AT_VERTICES
  vec3 view = normalize(eye.xyz - eye.w * spot), n = dot(facing, view) < 0.0 ? -facing : facing;
  mirrors(n, view, gloss.x, gloss.y, withoutNegatives(light), skySeen.x, factor, summand, diffuse);
#endif
#ifdef SHADED_AT_VERTICES
  radiance = colour.rgb * factor + summand;
#endif
}`;

const SURFACE_FRAGMENT = `
centroid in vec3 radiance, radianceBehind;
centroid in vec3 facing;
in vec3 spot;
uniform vec4 eye, emissionPlacing;
uniform vec3 emission;
uniform sampler2D emissionTexture;
uniform int emissionCoordinates;
out vec4 shown;
${GLSL_COLOUR}
${GLSL_WITHOUT_NEGATIVES}
${GLSL_NORMALS}
#ifdef NORMAL_PICTURE
${GLSL_DETAIL}
#endif
#ifdef GLOSSY
${GLSL_MIRRORS}
${GLSL_GLOSS}
#endif
#if defined(GLOSSY_AT_VERTICES) && !defined(SHADED_AT_VERTICES)
centroid in vec3 factor, summand;
centroid in float diffuse;
#endif
#ifdef SUNNY
${GLSL_SUNS}
#endif

void main() {
  vec4 surface = ownColour();
#if defined(GLOSSY) || defined(SUNNY) || defined(NORMAL_PICTURE)
  vec3 n = normalize(gl_FrontFacing ? facing : -facing), bent = detailed(n);
#endif
#ifdef CUT
  if (surface.a < cutoff) discard;
#endif
  vec3 suns = vec3(0.0);
#ifdef SUNNY
  suns = sunLight(spot, n, bent);
#endif
#if defined(SHADED_AT_VERTICES)
  vec3 light = radiance;
#elif defined(GLOSSY_AT_VERTICES)
  vec3 light = surface.rgb * (factor + diffuse * suns) + summand;
#else
#ifdef TWO_SIDED
  vec3 light = withoutNegatives(gl_FrontFacing ? radiance : radianceBehind);
#else
  vec3 light = withoutNegatives(radiance);
#endif
#ifdef NORMAL_PICTURE
  light = max(light + moreLight(n, bent), 0.0);
#endif
#ifdef GLOSSY
  light = glossy(bent, surface.rgb, light, suns);
#elif defined(WHITE)
  light += suns;
#else
  light = (light + suns) * surface.rgb;
#endif
#endif
#ifdef GLOWING_PICTURE
  light += emission * texture(emissionTexture, placed(emissionPlacing, emissionCoordinates)).rgb;
#endif
#ifdef GLOWING
  light += emission;
#endif
#ifdef CLEAR
  shown = vec4(light, surface.a);
#else
  shown = vec4(light, 1.0);
#endif
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

/** How many cells the sky is cut into across and up, where its picture is looked up at their corners. */
export const SKY_CELLS = [32, 18] as const;

/**
 * The same for movements on slow machines, which angles of each pixel would take long: corners of cells know their places in the picture,
 * on both sides of its seam, and pixels take those that do not jump (Tarini 2012, "Cylindrical and Toroidal Parameterizations Without
 * Vertex Seams").
 */
export const SKY_QUICK_VERTEX = `${HEAD}
uniform vec3 tangents;
uniform mat3 toPicture;
out vec3 place;
${GLSL_EQUIRECT}
const ivec2 CORNERS[6] = ivec2[](ivec2(0, 0), ivec2(1, 0), ivec2(0, 1), ivec2(0, 1), ivec2(1, 0), ivec2(1, 1));
void main() {
  int cell = gl_VertexID / 6, corner = gl_VertexID % 6;
  ivec2 at = ivec2(cell % ${SKY_CELLS[0]}, cell / ${SKY_CELLS[0]}) + CORNERS[corner];
  vec2 spot = 2.0 * vec2(at) / vec2(${SKY_CELLS.join(".0, ")}.0) - 1.0;
  vec2 seen = equirect(normalize(toPicture * vec3((spot - vec2(0.0, tangents.z)) * tangents.xy, -1.0)));
  place = vec3(seen, fract(seen.x + 0.5) - 0.5);
  gl_Position = vec4(spot, 1.0, 1.0);
}`;

export const SKY_QUICK_FRAGMENT = `${HEAD}
in vec3 place;
uniform sampler2D picture;
uniform float strength;
out vec4 shown;
void main() {
  float across = fwidth(place.x) <= fwidth(place.z) ? place.x : place.z;
  shown = vec4(strength * textureLod(picture, vec2(across, place.y), 0.0).rgb, 1.0);
}`;

/** The picture is smoothed by cubic B-splines, as four bilinear looks: it is coarser than the screen. */
export const SKY_FRAGMENT = `${HEAD}
in vec3 direction;
uniform sampler2D picture;
uniform float strength;
out vec4 shown;
${GLSL_EQUIRECT}
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
  vec2 at = equirect(normalize(direction));
  shown = vec4(strength * smoothed(at), 1.0);
}`;

const SHADOW_VERTEX = `
in vec3 position;
in vec2 coordinates0, coordinates1;
uniform mat4 place;
out vec2 place0, place1;
void main() {
  place0 = coordinates0;
  place1 = coordinates1;
  gl_Position = place * vec4(position, 1.0);
}`;

/** What is clear leaves as many texels out as light passes: shadows are looked up in many (Jimenez 2014's gradient noise spreads them). */
const SHADOW_FRAGMENT = `
#if defined(CUT) || defined(CLEAR)
${GLSL_COLOUR}
void main() {
#ifdef CUT
  float least = cutoff;
#else
  float least = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
#endif
  if (ownColour().a < least) discard;
}
#else
void main() {}
#endif`;

/** A triangle that covers the screen. */
export const DISPLAY_VERTEX = `${HEAD}
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}`;

export const DISPLAY_FRAGMENT = `${HEAD}
uniform sampler2D light;
uniform float exposure;
uniform bool asks; // the table, and is not Standard
uniform highp sampler3D table;
out vec4 shown;
${GLSL_VIEW}
void main() {
  vec3 exposed = exposure * texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb;
  shown = vec4(asks ? tableView(table, exposed) : standardView(exposed), 1.0);
}`;
