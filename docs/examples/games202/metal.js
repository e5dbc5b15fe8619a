// SPDX-License-Identifier: GPL-3.0-or-later
// Metal draws two rows of ten GGX spheres under a lamp, without and with Kulla & Conty's lobe, from the tables of E and E_avg.
"use strict";

const METAL_SHADERS = [
  `attribute vec2 aCorner;
   varying vec2 vPlace;
   void main() {
     gl_Position = vec4(aCorner, 0.0, 1.0);
     vPlace = vec2(5.0 * aCorner.x + 5.0, aCorner.y + 1.0);
   }`,
  `precision highp float;
   varying vec2 vPlace;
   uniform sampler2D uAlbedo, uAverage;
   uniform float uSteps;
   uniform vec3 uLamp, uMetal;
   uniform bool uCourse, uEncoded;
   const float PI = 3.14159265;

   float read(sampler2D table, float mu, float roughness) {
     return texture2D(table, (vec2(mu, roughness) * (uSteps - 1.0) + 0.5) / uSteps).r;
   }
   float hidden(float cosine, float alpha) {
     return (sqrt(1.0 + alpha * alpha * (1.0 / (cosine * cosine) - 1.0)) - 1.0) / 2.0;
   }
   float oneBounce(float muOut, float muIn, float muHalf, float alpha) {
     float a2 = alpha * alpha, spread = muHalf * muHalf * (a2 - 1.0) + 1.0;
     float seen = 1.0 / (1.0 + hidden(muOut, alpha) + hidden(muIn, alpha));
     return a2 / (PI * spread * spread) * seen / (4.0 * muOut * muIn);
   }
   vec3 furtherBounces(float muOut, float muIn, float roughness) {
     float average = read(uAverage, 0.5, roughness);
     float lost = (1.0 - read(uAlbedo, muOut, roughness)) * (1.0 - read(uAlbedo, muIn, roughness));
     vec3 colour = uMetal * average / (1.0 - uMetal * (1.0 - average));
     return (uCourse ? colour : colour * uMetal) * lost / (PI * max(1.0 - average, 0.001));
   }
   void main() {
     vec2 cell = floor(vPlace), place = 2.0 * fract(vPlace) - 1.0;
     float roughness = (cell.x + 1.0) / 10.0, away = dot(place, place);
     gl_FragColor = vec4(0.0, 0.0, 0.0, 1.0);
     if (away > 0.99) return;
     vec3 normal = vec3(place, sqrt(1.0 - away));
     float muOut = normal.z, muIn = dot(normal, uLamp);
     if (muIn <= 0.0) return;
     float muHalf = dot(normal, normalize(uLamp + vec3(0.0, 0.0, 1.0)));
     vec3 brdf = uMetal * oneBounce(muOut, muIn, muHalf, roughness * roughness);
     if (cell.y < 1.0) brdf += furtherBounces(muOut, muIn, roughness);
     vec3 radiance = PI * brdf * muIn; // a white matte surface that faces the lamp would show 1
     gl_FragColor.rgb = uEncoded ? pow(min(radiance, 1.0), vec3(1.0 / 2.2)) : radiance;
   }`,
];

class Metal {
  /** Pictures of both tables, square and of one size. */
  constructor(gl, albedo, average) {
    this.gl = gl;
    this.lamp = [0, 0, 1]; // towards it, a unit vector; the view is along -z
    this.metal = [0.95, 0.64, 0.54]; // F, linear
    this.course = false;
    this._program = linkedProgram(gl, METAL_SHADERS, { aCorner: 0 });
    this._steps = albedo.width;
    this._tables = [albedo, average].map((picture) => this._texture(picture));
    this._screen = filledBuffer(gl, WHOLE_PICTURE);
  }

  /** Draw into what is bound, five times as wide as high; encoded as screens want it, or linear. */
  draw(width, height, encoded = true) {
    const gl = this.gl, uniform = (name) => gl.getUniformLocation(this._program, name);
    gl.viewport(0, 0, width, height);
    gl.useProgram(this._program);
    this._tables.forEach((table, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, table);
      gl.uniform1i(uniform(["uAlbedo", "uAverage"][unit]), unit);
    });
    gl.uniform1f(uniform("uSteps"), this._steps);
    gl.uniform3fv(uniform("uLamp"), this.lamp);
    gl.uniform3fv(uniform("uMetal"), this.metal);
    gl.uniform1i(uniform("uCourse"), this.course ? 1 : 0);
    gl.uniform1i(uniform("uEncoded"), encoded ? 1 : 0);
    feed(gl, this._screen, 0, 2);
    drawFed(gl, 3, 1);
  }

  _texture(picture) {
    const gl = this.gl, texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, gl.RGB, gl.UNSIGNED_BYTE, picture);
    for (const [name, value] of [["MIN_FILTER", "LINEAR"], ["MAG_FILTER", "LINEAR"], ["WRAP_S", "CLAMP_TO_EDGE"], ["WRAP_T", "CLAMP_TO_EDGE"]])
      gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}`], gl[value]);
    return texture;
  }

  /** A table from the server. */
  static async table(name) {
    const answer = await fetch(name);
    if (!answer.ok) throw new Error(`${name} is not there: ${answer.status}. Serve the folder that 'make course' makes.`);
    return createImageBitmap(await answer.blob(), { colorSpaceConversion: "none" });
  }
}
