// SPDX-License-Identifier: MIT
// The surfaces of a model: their materials, and a program for each set of features that these have.

import { bindTexture, compiled, type GL, type Program, texture } from "./gl.js";
import type { Material, Texture } from "./model.js";
import { type Feature, surfaceShaders } from "./shaders.js";

export class Surfaces {
  private readonly programs = new Map<string, Program>();
  private readonly textures = new Map<ImageBitmap, WebGLTexture>();

  constructor(private readonly gl: GL) {}

  /** Makes ready to draw triangles of a material, by the matrix that takes them to what WebGL clips; white ones if so wanted. */
  begin(material: Material, white: boolean, place: Float32Array): void {
    const { gl } = this, program = this.programFor(featuresOf(material, white)), { uniforms } = program;
    gl.useProgram(program.program);
    gl.uniformMatrix4fv(uniforms["place"]!, false, place);
    gl.uniform4fv(uniforms["colour"]!, white ? [1, 1, 1, material.colour[3]!] : (material.colour as number[]));
    gl.uniform3fv(uniforms["emission"]!, white ? [0, 0, 0] : (material.emission as number[]));
    if (material.alpha === "MASK") gl.uniform1f(uniforms["cutoff"]!, material.cutoff);
    this.lay(0, material.texture, program, "colour");
    this.lay(1, material.emissionTexture, program, "emission");
    const clear = material.alpha === "BLEND";
    gl.depthMask(!clear);
    gl[clear ? "enable" : "disable"](gl.BLEND);
    gl[material.doubleSided ? "disable" : "enable"](gl.CULL_FACE);
  }

  private lay(unit: number, picture: Texture | null, program: Program, name: string): void {
    const { gl } = this, { uniforms } = program;
    if (!picture || !uniforms[`${name}Texture`]) return;
    bindTexture(gl, unit, this.pictureOf(picture), program, `${name}Texture`);
    gl.uniform4fv(uniforms[`${name}Placing`]!, picture.placing);
    gl.uniform1i(uniforms[`${name}Coordinates`]!, picture.coordinates);
  }

  private programFor(features: readonly Feature[]): Program {
    const key = features.join(), known = this.programs.get(key);
    if (known) return known;
    const made = compiled(this.gl, ...surfaceShaders(features));
    this.programs.set(key, made);
    return made;
  }

  private pictureOf({ image, repeated, smooth: smoothed }: Texture): WebGLTexture {
    const known = this.textures.get(image);
    if (known) return known;
    const { gl } = this, made = texture(gl, gl.TEXTURE_2D);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, image);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, smoothed ? gl.LINEAR_MIPMAP_LINEAR : gl.NEAREST_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, smoothed ? gl.LINEAR : gl.NEAREST);
    if (repeated[0]) gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.REPEAT);
    if (repeated[1]) gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.REPEAT);
    this.textures.set(image, made);
    return made;
  }
}

/** What a material needs of a program; white surfaces keep their holes. */
function featuresOf({ texture: colour, emission, emissionTexture, alpha }: Material, white: boolean): Feature[] {
  const features: Feature[] = [];
  if (colour && !(white && alpha === "OPAQUE")) features.push("TEXTURED");
  if (!white && Math.max(...emission) > 0) features.push(emissionTexture ? "GLOWING_PICTURE" : "GLOWING");
  if (alpha !== "OPAQUE") features.push(alpha === "MASK" ? "CUT" : "CLEAR");
  if (white) features.push("WHITE");
  return features;
}
