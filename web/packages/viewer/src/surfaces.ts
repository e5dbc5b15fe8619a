// SPDX-License-Identifier: MIT
// The surfaces of a model: their materials, and a program for each set of features that these have.

import { IDENTITY, type Matrix3 } from "@prt-relight/core";
import { bindTexture, compiled, type GL, type Program, texture } from "./gl.js";
import { type Matrix4, normalMatrix } from "./matrix4.js";
import type { Gloss, Instance, Mesh, Texture } from "./model.js";
import { type Feature, surfaceShaders } from "./shaders.js";
import type { Suns } from "./shadows.js";
import type { Sky } from "./sky.js";

export type Shading = "baked" | "unshadowed" | "light";

/** What surfaces are seen in. */
export interface Surroundings {
  readonly shading: Shading;
  /** Whether gloss is reckoned at vertices, as far as no pictures are in it. */
  readonly coarse: boolean;
  /** Where the camera is, and 1; or, if it looks everywhere the same way, the way to it, and 0. */
  readonly eye: readonly [number, number, number, number];
  readonly sky: Sky;
  /** Along w, the sky shows what its picture holds along `turn` w. */
  readonly turn: Matrix3;
  /** What lights baked surfaces in place of spots of the sky, if anything does. */
  readonly suns: Suns | null;
  /** The sky as mirrors show it, if there are any. */
  readonly mirrored: WebGLTexture | null;
}

const MAPS = 5; // the unit of the texture of suns' shadows

export class Surfaces {
  private readonly programs = new Map<string, Program>();
  private readonly textures = { colours: new Map<ImageBitmap, WebGLTexture>(), numbers: new Map<ImageBitmap, WebGLTexture>() };

  constructor(private readonly gl: GL) {}

  /** Makes ready to draw the triangles of an instance, by the matrix that takes them to what WebGL clips. */
  begin(instance: Instance, place: Matrix4, surroundings: Surroundings): void {
    const { gl } = this, { material } = instance.mesh, { shading, suns } = surroundings, white = shading === "light";
    const program = this.programFor(featuresOf(instance.mesh, surroundings)), { uniforms } = program;
    gl.useProgram(program.program);
    gl.uniformMatrix4fv(uniforms["place"]!, false, Float32Array.from(place));
    gl.uniform4fv(uniforms["colour"]!, material.colour as number[]);
    gl.uniform3fv(uniforms["emission"]!, material.emission as number[]);
    if (material.alpha === "MASK") gl.uniform1f(uniforms["cutoff"]!, material.cutoff);
    this.lay(0, material.texture, program, "colour");
    this.lay(1, material.emissionTexture, program, "emission");
    this.beginSpace(instance, program, surroundings);
    if (suns && instance.mesh.transport) this.beginSuns(suns, program);
    if (material.gloss && !white) this.beginGloss(instance, material.gloss, program, surroundings);
    const clear = material.alpha === "BLEND";
    gl.depthMask(!clear);
    gl[clear ? "enable" : "disable"](gl.BLEND);
    gl[material.doubleSided ? "disable" : "enable"](gl.CULL_FACE);
  }

  /** Where the surface is, where it looks, and where from it is looked at, for programs that ask. */
  private beginSpace({ world }: Instance, { uniforms }: Program, { eye }: Surroundings): void {
    const { gl } = this;
    if (uniforms["world"]) gl.uniformMatrix4fv(uniforms["world"], false, Float32Array.from(world));
    if (uniforms["normals"]) gl.uniformMatrix3fv(uniforms["normals"], true, Float32Array.from(normalMatrix(world)));
    if (uniforms["eye"]) gl.uniform4fv(uniforms["eye"], eye);
  }

  private beginSuns({ count, directions, irradiances, radii, places, reach, maps }: Suns, { uniforms }: Program): void {
    const { gl } = this;
    gl.uniform1i(uniforms["sunCount"]!, count);
    gl.uniform3fv(uniforms["sunDirections"]!, directions);
    gl.uniform3fv(uniforms["sunIrradiances"]!, irradiances);
    gl.uniform1fv(uniforms["sunRadii"]!, radii);
    gl.uniform1f(uniforms["sunReach"]!, reach);
    gl.uniformMatrix4fv(uniforms["sunPlaces"]!, false, places);
    gl.activeTexture(gl.TEXTURE0 + MAPS);
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, maps);
    gl.uniform1i(uniforms["sunMaps"]!, MAPS);
  }

  private beginGloss({ mesh, axes }: Instance, gloss: Gloss, program: Program, { sky, turn, mirrored }: Surroundings): void {
    const { gl } = this, { uniforms } = program, { transport } = mesh;
    gl.uniformMatrix3fv(uniforms["toPicture"]!, true, Float32Array.from(turn));
    gl.uniform1f(uniforms["strength"]!, sky.strength);
    gl.uniform3f(uniforms["gloss"]!, gloss.metallic, gloss.roughness, gloss.straight);
    if (transport) {
      gl.uniformMatrix3fv(uniforms["toTransport"]!, false, Float32Array.from(transport.inOwnAxes ? axes : IDENTITY)); // transposed
      gl.uniform1f(uniforms["directScale"]!, transport.directScale);
    }
    this.lay(2, gloss.texture, program, "gloss");
    this.lay(3, gloss.normalTexture, program, "normal");
    gl.uniform1f(uniforms["normalScale"]!, gloss.normalScale);
    bindTexture(gl, 4, mirrored, program, "mirroredSky");
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

  private pictureOf({ image, repeated, smooth: smoothed, isColour }: Texture): WebGLTexture {
    const textures = this.textures[isColour ? "colours" : "numbers"], known = textures.get(image);
    if (known) return known;
    const { gl } = this, made = texture(gl, gl.TEXTURE_2D);
    gl.texImage2D(gl.TEXTURE_2D, 0, isColour ? gl.SRGB8_ALPHA8 : gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, image);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, smoothed ? gl.LINEAR_MIPMAP_LINEAR : gl.NEAREST_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, smoothed ? gl.LINEAR : gl.NEAREST);
    if (repeated[0]) gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.REPEAT);
    if (repeated[1]) gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.REPEAT);
    textures.set(image, made);
    return made;
  }
}

/** What a mesh needs of a program; white surfaces keep their holes. */
function featuresOf({ material, transport }: Mesh, { shading, coarse, suns }: Surroundings): Feature[] {
  const { texture: colour, emission, emissionTexture, alpha, gloss } = material, features: Feature[] = [], white = shading === "light";
  if (colour && !(white && alpha === "OPAQUE")) features.push("TEXTURED");
  if (alpha !== "OPAQUE") features.push(alpha === "MASK" ? "CUT" : "CLEAR");
  if (suns && transport) features.push("SUNNY", ...(coarse ? ["SUNNY_COARSELY" as const] : []));
  if (white) return [...features, "WHITE"];
  if (Math.max(...emission) > 0) features.push(emissionTexture ? "GLOWING_PICTURE" : "GLOWING");
  if (!gloss) return features;
  features.push(coarse && !gloss.texture && !gloss.normalTexture ? "GLOSSY_AT_VERTICES" : "GLOSSY");
  if (gloss.texture) features.push("GLOSS_PICTURE");
  if (gloss.normalTexture) features.push("NORMAL_PICTURE");
  if (transport?.direct && shading === "baked") features.push("SKY_SEEN");
  return features;
}
