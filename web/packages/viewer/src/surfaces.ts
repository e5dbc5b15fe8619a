// SPDX-License-Identifier: MIT
// The surfaces of a model: their materials, and a program for each set of features that these have.

import { IDENTITY, type Light, type Matrix3 } from "@prt-relight/core";
import { bindTexture, compiled, type GL, type Program, texture } from "./gl.js";
import { type Matrix4, normalMatrix } from "./matrix4.js";
import type { Gloss, Instance, Material, Mesh, Texture } from "./model.js";
import { type Feature, surfaceShaders } from "./shaders.js";
import type { Suns } from "./shadows.js";
import type { Sky } from "./sky.js";

export type Shading = "baked" | "unshadowed" | "light";

/** The light of a sky, as it is turned and scaled. */
export interface SeenLight {
  readonly whole: Light;
  /** What its suns show of it, if there are any. */
  readonly lamps: Light | null;
  /** What is left of it without them. */
  readonly soft: Light;
}

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
  /** The sky's, in the world's axes. */
  readonly light: SeenLight;
}

const MAPS = 5; // the unit of the texture of suns' shadows

export class Surfaces {
  private readonly programs = new Map<string, Program>();
  private readonly textures = { colours: new Map<ImageBitmap, WebGLTexture>(), numbers: new Map<ImageBitmap, WebGLTexture>() };

  constructor(private readonly gl: GL) {}

  /** Makes ready to draw the triangles of an instance with a material, by the matrix that takes them to what WebGL clips. */
  begin(instance: Instance, material: Material, place: Matrix4, surroundings: Surroundings): void {
    const { gl } = this, { shading, suns } = surroundings, white = shading === "light";
    const program = this.programFor(featuresOf(instance.mesh, material, surroundings)), { uniforms } = program;
    this.beginColour(material, place, program);
    gl.uniform3fv(uniforms["emission"]!, material.emission as number[]);
    this.lay(1, material.emissionTexture, program, "emission");
    this.lay(3, material.normalTexture, program, "normal");
    gl.uniform1f(uniforms["normalScale"]!, material.normalScale);
    const soft = suns && instance.mesh.transport ? surroundings.light.soft : surroundings.light.whole;
    if (uniforms["soft"]) gl.uniform3fv(uniforms["soft"], Float32Array.from(soft));
    this.beginSpace(instance, program, surroundings);
    if (suns && instance.mesh.transport) this.beginSuns(suns, program);
    if (material.gloss && !white) this.beginGloss(instance, material.gloss, program, surroundings);
    const clear = material.alpha === "BLEND";
    gl.depthMask(!clear);
    gl[clear ? "enable" : "disable"](gl.BLEND);
    gl[material.doubleSided ? "disable" : "enable"](gl.CULL_FACE);
  }

  /** The same for what a sun sees, of which only the depth is kept. */
  beginShadow({ mesh: { material } }: Instance, place: Matrix4): void {
    this.beginColour(material, place, this.programFor(["SHADOW", ...holesOf(material)]));
  }

  private beginColour(material: Material, place: Matrix4, program: Program): void {
    const { gl } = this, { uniforms } = program;
    gl.useProgram(program.program);
    gl.uniformMatrix4fv(uniforms["place"]!, false, Float32Array.from(place));
    gl.uniform4fv(uniforms["colour"]!, material.colour as number[]);
    if (material.alpha === "MASK") gl.uniform1f(uniforms["cutoff"]!, material.cutoff);
    this.lay(0, material.texture, program, "colour");
  }

  /** Where the surface is, where it looks, and where from it is looked at, for programs that ask. */
  private beginSpace({ world, mesh: { transport } }: Instance, { uniforms }: Program, { eye }: Surroundings): void {
    const { gl } = this;
    if (uniforms["world"]) gl.uniformMatrix4fv(uniforms["world"], false, Float32Array.from(world));
    if (uniforms["normals"]) gl.uniformMatrix3fv(uniforms["normals"], true, Float32Array.from(normalMatrix(world)));
    if (uniforms["eye"]) gl.uniform4fv(uniforms["eye"], eye);
    if (transport && uniforms["directScales"]) gl.uniform2f(uniforms["directScales"], transport.scale, transport.backs?.scale ?? 0);
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
    if (transport) gl.uniformMatrix3fv(uniforms["toTransport"]!, false, Float32Array.from(transport.inOwnAxes ? axes : IDENTITY)); // transposed
    this.lay(2, gloss.texture, program, "gloss");
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

/** What of a program a material needs for its holes. */
function holesOf({ texture: colour, alpha }: Material): Feature[] {
  if (alpha === "OPAQUE") return [];
  return [...(colour ? ["TEXTURED" as const] : []), alpha === "MASK" ? "CUT" : "CLEAR"];
}

/** What a mesh needs of a program; white surfaces keep their holes. */
function featuresOf({ transport }: Mesh, material: Material, { shading, coarse, suns }: Surroundings): Feature[] {
  const { texture: colour, emission, emissionTexture, normalTexture, alpha, gloss } = material, features = holesOf(material);
  const isSunny = suns && transport;
  if (transport?.backs) features.push("TWO_SIDED");
  if (isSunny) features.push("SUNNY", ...(coarse ? ["SUNNY_COARSELY" as const] : []));
  if (shading === "light") return [...features, "WHITE"];
  if (colour && alpha === "OPAQUE") features.push("TEXTURED");
  if (Math.max(...emission) > 0) features.push(emissionTexture ? "GLOWING_PICTURE" : "GLOWING");
  if (normalTexture) features.push("NORMAL_PICTURE", ...(transport?.direct && shading === "baked" ? ["OPEN_SKY" as const] : []));
  if (!gloss) return features;
  const isEven = !gloss.texture && !normalTexture && !transport?.backs; // which side is seen, pixels know alone
  features.push(coarse && isEven ? "GLOSSY_AT_VERTICES" : "GLOSSY");
  if (gloss.texture) features.push("GLOSS_PICTURE");
  if (transport?.direct && shading === "baked") features.push("SKY_SEEN");
  return features;
}
