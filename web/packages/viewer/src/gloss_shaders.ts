// SPDX-License-Identifier: MIT
// What glossy surfaces mirror: the sky, blurred for each roughness beforehand, dimmed to the share of it that is seen.

/** How many roughnesses the sky is blurred for, the first being 0 and the last 1. */
export const ROUGHNESSES = 6;

/** Where in an equirectangular picture a unit vector looks. */
export const GLSL_EQUIRECT = `
vec2 equirect(vec3 w) {
  return vec2(0.5 - atan(w.y, w.x) / 6.283185307, 0.5 - asin(clamp(w.z, -1.0, 1.0)) / 3.141592654);
}`;

/**
 * A Principled BSDF as the relit surfaces of EEVEE have it, as what its base colour is multiplied by, what is added to that, and what it
 * diffuses of light from suns. What stands in the sky's place sends as much light as arrives on average. The gloss' albedo is the fit of Karis 2014, "Physically
 * Based Shading on Mobile", to the split sum of GGX.
 */
export const GLSL_MIRRORS = `
uniform mat3 toPicture;
uniform sampler2D mirroredSky;
uniform vec3 gloss; // metallic, roughness, what a dielectric reflects of what comes straight
uniform float strength;
${GLSL_EQUIRECT}
void mirrors(vec3 n, vec3 view, float metallic, float rough, vec3 light, float seen, out vec3 factor, out vec3 summand,
  out float diffuse) {
  n = normalize(n + max(0.001 - dot(n, view), 0.0) * view); // smooth normals look away along outlines
  vec4 r = rough * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  float grazing = min(r.x * r.x, exp2(-9.28 * abs(dot(n, view)))) * r.x + r.y;
  vec2 fit = vec2(-1.04, 1.04) * grazing + r.zw, metal = metallic * fit / (fit.x + fit.y); // times the base colour, and white
  float dielectric = (1.0 - metallic) * (gloss.z * fit.x + min(50.0 * gloss.z, 1.0) * fit.y);
  vec3 sky = seen * strength * textureLod(mirroredSky, equirect(toPicture * reflect(-view, n)), rough * ${(ROUGHNESSES - 1).toFixed(1)}).rgb;
  vec3 other = (1.0 - seen) * light;
  diffuse = 1.0 - metallic - dielectric;
  factor = light * diffuse + other * metallic + sky * metal.x;
  summand = (other + sky) * dielectric + sky * metal.y;
}`;

/** The same in each pixel, with kinds of gloss from pictures; along a normal that looks out of the side that is seen. */
export const GLSL_GLOSS = `
centroid in vec2 skySeen;
uniform sampler2D glossTexture;
uniform vec4 glossPlacing;
uniform int glossCoordinates;

vec3 glossy(vec3 n, vec3 base, vec3 light, vec3 suns) {
  float metallic = gloss.x, rough = gloss.y;
#ifdef GLOSS_PICTURE
  vec2 kind = texture(glossTexture, placed(glossPlacing, glossCoordinates)).bg;
  metallic *= kind.x;
  rough *= kind.y;
#endif
  vec3 view = normalize(eye.xyz - eye.w * spot), factor, summand;
  float diffuse;
  mirrors(n, view, metallic, rough, light, gl_FrontFacing ? skySeen.x : skySeen.y, factor, summand, diffuse);
  return base * (factor + diffuse * suns) + summand;
}`;

/** An equirectangular sky as a mirror of some roughness shows it, by the samples of GGX; a picture of 0 is only made smaller. */
export const MIRROR_FRAGMENT = `
uniform sampler2D picture;
uniform float roughness;
uniform vec2 size;
uniform float brightest;
out vec4 shown;
${GLSL_EQUIRECT}
const float SAMPLES = 64.0;

vec3 smaller(vec2 at) {
  vec3 sum = vec3(0.0);
  for (int k = 0; k < 16; k++) sum += min(textureLod(picture, at + (vec2(k % 4, k / 4) - 1.5) / 4.0 / size, 0.0).rgb, brightest);
  return sum / 16.0;
}

vec3 blurred(vec3 n) {
  float a = roughness * roughness, spread = a * a - 1.0, weights = 0.0;
  vec2 texels = vec2(textureSize(picture, 0));
  vec3 x = normalize(abs(n.z) < 0.9 ? vec3(n.y, -n.x, 0.0) : vec3(0.0, n.z, -n.y)), y = cross(n, x), sum = vec3(0.0);
  for (uint k = 0u; k < uint(SAMPLES); k++) {
    uint bits = (k << 16) | (k >> 16); // Hammersley's points
    bits = ((bits & 0x00ff00ffu) << 8) | ((bits & 0xff00ff00u) >> 8);
    bits = ((bits & 0x0f0f0f0fu) << 4) | ((bits & 0xf0f0f0f0u) >> 4);
    bits = ((bits & 0x33333333u) << 2) | ((bits & 0xccccccccu) >> 2);
    bits = ((bits & 0x55555555u) << 1) | ((bits & 0xaaaaaaaau) >> 1);
    float angle = 6.283185307 * (float(k) + 0.5) / SAMPLES, height = float(bits) / 4294967296.0;
    float square = (1.0 - height) / (1.0 + spread * height), lit = 2.0 * square - 1.0;
    if (lit <= 0.0) continue;
    vec3 h = sqrt(1.0 - square) * (cos(angle) * x + sin(angle) * y) + sqrt(square) * n;
    float falling = square * spread + 1.0, density = a * a / (12.566370614 * falling * falling);
    float level = 0.5 * log2(texels.x * texels.y / (12.566370614 * SAMPLES * density)) + 0.5;
    sum += lit * textureLod(picture, equirect(2.0 * dot(n, h) * h - n), max(level, 0.0)).rgb;
    weights += lit;
  }
  return sum / weights;
}

void main() {
  vec2 at = gl_FragCoord.xy / size, angles = vec2(6.283185307, 3.141592654) * (0.5 - at);
  shown = vec4(roughness > 0.0 ? blurred(vec3(cos(angles.y) * vec2(cos(angles.x), sin(angles.x)), sin(angles.y))) : smaller(at), 1.0);
}`;
