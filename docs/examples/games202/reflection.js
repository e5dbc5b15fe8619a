// SPDX-License-Identifier: GPL-3.0-or-later
// Reflection lights a mesh by its transport, and follows rays from its surfaces over the screen: to a mirror's picture, or to
// the light that bounces.
"use strict";

const REFLECTION_SHADERS = [
  `#version 300 es
   in vec2 aCorner;
   void main() { gl_Position = vec4(aCorner, 0.0, 1.0); }`,
  `#version 300 es
   precision highp float;
   precision highp int;
   uniform sampler2D uSurface, uAlbedo, uDirect;
   uniform vec2 uTangents;
   uniform mat3 uToWorld, uLight[3];
   uniform int uMode, uSteps, uSamples;
   uniform float uStep, uBound;
   uniform bool uFloorOnly, uEncoded;
   out vec4 colour;
   const float TAU = 6.28318531;
   const int MIRROR = 1, INDIRECT = 2, HALVINGS = 6;
   ${ENCODED}
   ${CARRIED}

   // Directions and places are those of the view: x to the right, y up, and the camera looks along -z.
   vec2 size() { return vec2(textureSize(uSurface, 0)); }
   float depthAt(vec2 pixel) { return texelFetch(uSurface, ivec2(pixel), 0).w; }
   vec3 placeAt(vec2 pixel) {
     float depth = depthAt(pixel);
     return vec3((2.0 * pixel / size() - 1.0) * uTangents * depth, -depth);
   }
   vec2 pixelOf(vec3 place) { return (place.xy / (-place.z * uTangents) * 0.5 + 0.5) * size(); }

   // How far behind what is seen a place lies; below 0 before it, or where nothing is seen.
   float behind(vec3 place, vec2 pixel) {
     float depth = depthAt(pixel);
     return depth > 0.0 ? -place.z - depth : -1.0;
   }

   // Whether a ray meets what is seen, and in which pixel: it has gone behind it, by less than a thickness that all things are
   // taken to have.
   bool meets(vec3 from, vec3 direction, float first, out vec2 pixel) {
     for (int i = 0; i < uSteps; i++) {
       float reached = (float(i) + first) * uStep;
       vec3 place = from + direction * reached;
       pixel = pixelOf(place);
       if (place.z >= 0.0 || any(lessThan(pixel, vec2(0.0))) || any(greaterThanEqual(pixel, size()))) return false;
       float deep = behind(place, pixel);
       if (deep <= 0.0 || deep > uBound) continue;
       float before = max(reached - uStep, 0.0);
       for (int k = 0; k < HALVINGS; k++) {
         float middle = (before + reached) / 2.0;
         vec3 between = from + direction * middle;
         if (behind(between, pixelOf(between)) > 0.0) reached = middle; else before = middle;
       }
       pixel = pixelOf(from + direction * reached);
       if (dot(texelFetch(uSurface, ivec2(pixel), 0).xyz, direction) < 0.0) return true; // else it is that thing's back
     }
     return false;
   }

   vec3 sky(vec3 direction) { // the SH light
     vec3 w = uToWorld * direction;
     mat3 basis = mat3(
       0.28209479, -0.48860251 * w.y, 0.48860251 * w.z,
       -0.48860251 * w.x, 1.09254843 * w.x * w.y, -1.09254843 * w.y * w.z,
       0.31539157 * (3.0 * w.z * w.z - 1.0), -1.09254843 * w.x * w.z, 0.54627422 * (w.x * w.x - w.y * w.y));
     return max(vec3(carried(basis, uLight[0]), carried(basis, uLight[1]), carried(basis, uLight[2])), 0.0);
   }

   vec3 mirrored(vec3 place, vec3 normal) {
     vec3 direction = reflect(normalize(place), normal);
     vec2 pixel;
     return meets(place, direction, 1.0, pixel) ? texelFetch(uDirect, ivec2(pixel), 0).rgb : sky(direction);
   }

   uint scrambled(uint x) { // PCG (Jarzynski & Olano 2020)
     x = x * 747796405u + 2891336453u;
     x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
     return (x >> 22u) ^ x;
   }
   float random(inout uint state) {
     state = scrambled(state);
     return float(state >> 8u) / 16777216.0;
   }

   // The mean over directions by the cosine: of a matte surface's light from what it meets, the share that is not its albedo.
   vec3 gathered(vec3 place, vec3 normal) {
     uint state = scrambled(uint(gl_FragCoord.x) + 8192u * uint(gl_FragCoord.y));
     vec3 side = normalize(cross(normal, abs(normal.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0)));
     vec3 sum = vec3(0.0);
     for (int i = 0; i < uSamples; i++) {
       float share = (float(i) + random(state)) / float(uSamples), angle = TAU * random(state);
       vec3 disc = sqrt(share) * (cos(angle) * side + sin(angle) * cross(normal, side));
       vec2 pixel;
       if (meets(place, disc + sqrt(1.0 - share) * normal, 0.5 + random(state), pixel)) sum += texelFetch(uDirect, ivec2(pixel), 0).rgb;
     }
     return sum / float(uSamples);
   }

   void main() {
     vec2 here = gl_FragCoord.xy;
     vec4 surface = texelFetch(uSurface, ivec2(here), 0);
     if (surface.w == 0.0) discard;
     vec3 place = placeAt(here), normal = surface.xyz, radiance = texelFetch(uDirect, ivec2(here), 0).rgb;
     bool mirror = uMode == MIRROR && (!uFloorOnly || (uToWorld * normal).y > 0.99);
     if (mirror) radiance = mirrored(place, normal);
     if (uMode == INDIRECT) radiance += texelFetch(uAlbedo, ivec2(here), 0).rgb * gathered(place, normal);
     colour = vec4(uEncoded ? encoded(radiance) : radiance, 1.0);
   }`,
];

class Reflection extends View {
  /** The order in which the page names them, and the shader counts them. */
  static MODES = ["direct", "mirror", "indirect"];

  /** Of a WebGL 2 context. */
  constructor(gl) {
    super(gl);
    this.mode = "direct";
    this.floorOnly = false; // whether only what faces up is a mirror
    this.samples = 8; // rays per pixel, of indirect light
    this.steps = 256; // along a ray, from one end of the scene to the other
    this.bound = 8; // what a ray goes behind and still meets, in steps
    this._gbuffer = new GBuffer(gl);
    this._program = linkedProgram(gl, REFLECTION_SHADERS, { aCorner: 0 });
    this._screen = filledBuffer(gl, WHOLE_PICTURE);
  }

  /** A mesh of `Files`, nine numbers of transport for each of its corners, and the light as nine [r, g, b]. */
  setScene(mesh, transport, light) {
    this.camera.lookAt(mesh.places);
    this.light = light;
    this._gbuffer.setScene(mesh, transport);
  }

  _drawMesh(width, height, encoded) {
    const gl = this.gl, uniform = (name) => gl.getUniformLocation(this._program, name);
    const light = Harmonics.turned(this.light, this.turn), step = 2 * this.camera.radius / this.steps;
    this._gbuffer.draw(this.camera, light, width, height);
    gl.viewport(0, 0, width, height);
    gl.useProgram(this._program);
    this._gbuffer.bind(this._program, ["uSurface", "uAlbedo", "uDirect"]);
    gl.uniform2fv(uniform("uTangents"), Camera.tangents(width / height));
    gl.uniformMatrix3fv(uniform("uToWorld"), false, this.camera.place().axes.flat());
    gl.uniformMatrix3fv(uniform("uLight"), false, Harmonics.byChannel(light));
    gl.uniform1i(uniform("uMode"), Reflection.MODES.indexOf(this.mode));
    gl.uniform1i(uniform("uFloorOnly"), this.floorOnly ? 1 : 0);
    gl.uniform1i(uniform("uSamples"), this.samples);
    gl.uniform1i(uniform("uSteps"), this.steps);
    gl.uniform1f(uniform("uStep"), step);
    gl.uniform1f(uniform("uBound"), this.bound * step);
    gl.uniform1i(uniform("uEncoded"), encoded ? 1 : 0);
    gl.enable(gl.DEPTH_TEST); // so that the sky is drawn behind
    feed(gl, this._screen, 0, 2);
    drawFed(gl, 3, 1);
  }
}
