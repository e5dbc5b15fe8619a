// SPDX-License-Identifier: MIT
// How suns of the sky light a surface: by its cosine, behind the soft edges of shadows.

/** How many suns light at once. */
export const MOST_SUNS = 8;

/**
 * Soft shadows after Fernando 2005, "Percentage-Closer Soft Shadows": the disc of a sun, as wide as it looks from here through what is
 * in the way, is asked in places of a spiral (Vogel 1979), which each pixel turns on. In movements on slow machines they are hard.
 */
export const GLSL_SUNS = `
uniform int sunCount;
uniform vec3 sunDirections[${MOST_SUNS}], sunIrradiances[${MOST_SUNS}];
uniform float sunRadii[${MOST_SUNS}], sunReach;
uniform mat4 sunPlaces[${MOST_SUNS}];
uniform highp sampler2DArray sunMaps;

#ifdef SUNNY_COARSELY
float sunSeen(vec3 at, vec2 slope, int sun) {
  return step(at.z, texture(sunMaps, vec3(at.xy, float(sun))).r);
}
#else
const int SEARCHES = 12, LOOKS = 24;

vec2 spiral(int k, int count, float turn) {
  float angle = 2.399963230 * float(k) + turn;
  return sqrt((float(k) + 0.5) / float(count)) * vec2(cos(angle), sin(angle));
}

/** Share of a sun's disc that is seen from a place in its map, on a surface whose depth goes on by the slope. */
float sunSeen(vec3 at, vec2 slope, int sun) {
  float turn = 6.283185307 * fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))); // Jimenez 2014
  float far = 0.0, found = 0.0, seen = 0.0, texel = 1.0 / float(textureSize(sunMaps, 0).x);
  for (int k = 0; k < SEARCHES; k++) {
    vec2 aside = max(sunRadii[sun] * at.z, texel) * spiral(k, SEARCHES, turn);
    float nearer = at.z + dot(slope, aside) - texture(sunMaps, vec3(at.xy + aside, float(sun))).r;
    if (nearer > 0.0) {
      far += nearer;
      found += 1.0;
    }
  }
  if (found == 0.0) return 1.0;
  float width = max(sunRadii[sun] * far / found, texel);
  for (int k = 0; k < LOOKS; k++) {
    vec2 aside = width * spiral(k, LOOKS, turn);
    seen += step(at.z + dot(slope, aside), texture(sunMaps, vec3(at.xy + aside, float(sun))).r);
  }
  return seen / float(LOOKS);
}
#endif

/** Radiance of a white surface at a place, with a unit normal that looks to the eye, and the same as a picture bends it. */
vec3 sunLight(vec3 place, vec3 n, vec3 bent) {
  vec3 sum = vec3(0.0);
  float texel = 2.0 * sunReach / float(textureSize(sunMaps, 0).x);
  for (int k = 0; k < sunCount; k++) {
    float cosine = dot(bent, sunDirections[k]);
    if (min(cosine, dot(n, sunDirections[k])) <= 0.0) continue;
    vec3 clear = place + texel * (1.5 * n + sunDirections[k]); // off the surface, which the map knows by its texels alone
    vec3 at = 0.5 + 0.5 * (sunPlaces[k] * vec4(clear, 1.0)).xyz, across = mat3(sunPlaces[k]) * n;
    vec2 slope = clamp(across.xy / max(-across.z, 1e-4), -4.0, 4.0);
    sum += sunIrradiances[k] * (cosine / 3.141592654 * sunSeen(at, slope, k));
  }
  return sum;
}`;
