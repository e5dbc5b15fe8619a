// SPDX-License-Identifier: MIT
// Draws a model under a light, before its sky. Made anew when the browser loses its graphics.

import { COSINE_LOBE, type Light, type Matrix3, multiplied, scaled, turned, type Vector3 } from "@prt-relight/core";
import { GpuMesh } from "./gpu_mesh.js";
import { compiled, type GL, type Program, smooth, texture } from "./gl.js";
import { isMirrored, normalMatrix } from "./matrix4.js";
import type { Instance, Material, Mesh, Model, Texture } from "./model.js";
import type { Orbit } from "./orbit.js";
import { MESH_FRAGMENT, MESH_VERTEX, SKY_FRAGMENT, SKY_VERTEX } from "./shaders.js";
import type { Sky } from "./sky.js";

export type Shading = "baked" | "unshadowed" | "light";

/** What a frame shows, and how. */
export interface Frame {
  readonly sky: Sky;
  /** Along w, the sky shows what its picture holds along `turn` w. */
  readonly turn: Matrix3;
  readonly exposure: number;
  readonly shading: Shading;
  /** A table's bytes, red fastest; null for the view transform Standard. */
  readonly table: Uint8Array | null;
}

const MOST_SKY_WIDTH = 4096;

export class Renderer {
  private readonly mesh: Program;
  private readonly sky: Program;
  private readonly meshes = new Map<Mesh, GpuMesh>();
  private readonly textures = new Map<ImageBitmap, WebGLTexture>();
  private readonly tables = new Map<Uint8Array, WebGLTexture>();
  private readonly white: WebGLTexture;
  private skyTexture: { readonly of: Sky; readonly texture: WebGLTexture } | null = null;

  constructor(private readonly gl: GL, private readonly model: Model) {
    this.mesh = compiled(gl, MESH_VERTEX, MESH_FRAGMENT);
    this.sky = compiled(gl, SKY_VERTEX, SKY_FRAGMENT);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    for (const { mesh } of model.instances) if (!this.meshes.has(mesh)) this.meshes.set(mesh, new GpuMesh(gl, mesh));
    this.white = texture(gl, gl.TEXTURE_2D);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array([255, 255, 255, 255]));
  }

  /** Draws a frame into the canvas, of which a share is covered from below. */
  draw(frame: Frame, orbit: Orbit, covered: number): void {
    const { drawingBufferWidth: width, drawingBufferHeight: height } = this.gl;
    this.drawInto(null, width, height, frame, orbit, frame.table ? 2 : 1, covered);
  }

  /**
   * Linear light of a frame, four floats a pixel, the lowest row first. Alpha is 0 where nothing is; the sky is left out.
   */
  radiance(frame: Frame, orbit: Orbit, width: number, height: number): Float32Array {
    const { gl } = this;
    if (!gl.getExtension("EXT_color_buffer_float")) throw new Error("This browser cannot draw floats.");
    const target = gl.createFramebuffer(), depth = gl.createRenderbuffer(), colour = texture(gl, gl.TEXTURE_2D);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, width, height, 0, gl.RGBA, gl.FLOAT, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, colour, 0);
    gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    this.drawInto(target, width, height, frame, orbit, 0);
    const pixels = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, pixels);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteFramebuffer(target);
    gl.deleteRenderbuffer(depth);
    gl.deleteTexture(colour);
    return pixels;
  }

  private drawInto(target: WebGLFramebuffer | null, width: number, height: number, frame: Frame, orbit: Orbit, view: number, covered = 0): void {
    const { gl } = this, aspect = width / height;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (view) this.drawSky(frame, orbit, aspect, view, covered);
    gl.enable(gl.DEPTH_TEST);
    gl.useProgram(this.mesh.program);
    this.setDisplay(this.mesh, frame, view);
    gl.uniformMatrix4fv(this.mesh.uniforms["clip"]!, false, Float32Array.from(orbit.clip(aspect, covered)));
    gl.uniform1i(this.mesh.uniforms["white"]!, Number(frame.shading === "light"));
    const light = scaled(turned(frame.sky.light, frame.turn), frame.sky.strength);
    for (const instance of this.ordered(orbit.position)) this.drawInstance(instance, light, frame.shading);
    gl.disable(gl.CULL_FACE);
    gl.disable(gl.BLEND);
  }

  /** What can be seen through comes last, the farthest first. */
  private ordered(eye: Vector3): Instance[] {
    const clear = ({ mesh }: Instance) => mesh.material.alpha === "BLEND";
    const depth = ({ centre }: Instance) => Math.hypot(...centre.map((value, k) => value - eye[k]!));
    const { instances } = this.model;
    return [...instances.filter((one) => !clear(one)), ...instances.filter(clear).sort((a, b) => depth(b) - depth(a))];
  }

  private drawInstance({ mesh, world, axes }: Instance, light: Light, shading: Shading): void {
    const { gl } = this, { uniforms } = this.mesh, on = this.meshes.get(mesh)!;
    const baked = mesh.transport !== null && shading !== "unshadowed";
    gl.uniform1i(uniforms["baked"]!, Number(baked));
    if (baked) {
      const { scales, inOwnAxes } = mesh.transport!, seen = inOwnAxes ? turned(light, axes) : light;
      gl.uniform3fv(uniforms["light"]!, Float32Array.from(seen, (value, k) => value * scales[Math.floor(k / 3)]!));
      this.bind(2, gl.TEXTURE_2D, on.transport, this.mesh, "transport");
    }
    gl.uniform3fv(uniforms["lobes"]!, Float32Array.from(light, (value, k) => value * COSINE_LOBE[Math.floor(k / 3)]!));
    gl.uniformMatrix4fv(uniforms["world"]!, false, Float32Array.from(world));
    gl.uniformMatrix3fv(uniforms["normals"]!, false, normalMatrix(world));
    this.setMaterial(mesh.material);
    gl.frontFace(isMirrored(world) ? gl.CW : gl.CCW);
    on.draw();
  }

  private setMaterial(material: Material): void {
    const { gl } = this, { uniforms } = this.mesh, { texture: colour, emissionTexture: glow } = material;
    gl.uniform4fv(uniforms["colour"]!, material.colour as number[]);
    gl.uniform3fv(uniforms["emission"]!, material.emission as number[]);
    gl.uniform1f(uniforms["cutoff"]!, material.alpha === "MASK" ? material.cutoff : 0);
    gl.uniform2i(uniforms["coordinates"]!, colour?.coordinates ?? 0, glow?.coordinates ?? 0);
    gl.uniform4fv(uniforms["colourPlacing"]!, colour?.placing ?? [0, 0, 1, 1]);
    gl.uniform4fv(uniforms["emissionPlacing"]!, glow?.placing ?? [0, 0, 1, 1]);
    this.bind(0, gl.TEXTURE_2D, colour ? this.pictureOf(colour) : this.white, this.mesh, "colourTexture");
    this.bind(1, gl.TEXTURE_2D, glow ? this.pictureOf(glow) : this.white, this.mesh, "emissionTexture");
    const clear = material.alpha === "BLEND";
    gl.depthMask(!clear);
    gl[clear ? "enable" : "disable"](gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl[material.doubleSided ? "disable" : "enable"](gl.CULL_FACE);
  }

  private drawSky(frame: Frame, orbit: Orbit, aspect: number, view: number, covered: number): void {
    const { gl } = this, { uniforms } = this.sky;
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(null);
    gl.useProgram(this.sky.program);
    this.setDisplay(this.sky, frame, view);
    gl.uniform3f(uniforms["tangents"]!, ...orbit.seen(aspect, covered), covered);
    gl.uniformMatrix3fv(uniforms["toPicture"]!, true, Float32Array.from(multiplied(frame.turn, orbit.rotation)));
    gl.uniform1f(uniforms["strength"]!, frame.sky.strength);
    this.bind(0, gl.TEXTURE_2D, this.skyOf(frame.sky), this.sky, "picture");
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  private setDisplay({ uniforms }: Program, { exposure, table }: Frame, view: number): void {
    const { gl } = this;
    gl.uniform1f(uniforms["exposure"]!, 2 ** exposure);
    gl.uniform1i(uniforms["view"]!, view);
    gl.uniform1i(uniforms["table"]!, 3);
    gl.activeTexture(gl.TEXTURE3);
    gl.bindTexture(gl.TEXTURE_3D, table ? this.tableOf(table) : null);
  }

  private bind(unit: number, target: number, bound: WebGLTexture | null, { uniforms }: Program, name: string): void {
    const { gl } = this;
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(target, bound);
    gl.uniform1i(uniforms[name]!, unit);
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

  private skyOf(sky: Sky): WebGLTexture {
    if (this.skyTexture?.of === sky) return this.skyTexture.texture;
    const { gl } = this;
    if (this.skyTexture) gl.deleteTexture(this.skyTexture.texture);
    const { width, height, pixels } = sky.picture, step = Math.ceil(width / Math.min(MOST_SKY_WIDTH, gl.getParameter(gl.MAX_TEXTURE_SIZE) as number));
    const made = texture(gl, gl.TEXTURE_2D);
    const shown = step > 1 ? thinned(pixels, width, height, step) : pixels;
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB16F, Math.floor(width / step), Math.floor(height / step), 0, gl.RGB, gl.FLOAT, shown.map((value) => Math.min(value, 65504)));
    smooth(gl, gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.REPEAT);
    this.skyTexture = { of: sky, texture: made };
    return made;
  }

  private tableOf(table: Uint8Array): WebGLTexture {
    const known = this.tables.get(table);
    if (known) return known;
    const { gl } = this, size = Math.round(Math.cbrt(table.length / 3)), made = texture(gl, gl.TEXTURE_3D);
    gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGB8, size, size, size, 0, gl.RGB, gl.UNSIGNED_BYTE, table);
    smooth(gl, gl.TEXTURE_3D);
    this.tables.set(table, made);
    return made;
  }
}

/** Every so many texels of every so many rows. */
function thinned(pixels: Float32Array, width: number, height: number, step: number): Float32Array {
  const columns = Math.floor(width / step), rows = Math.floor(height / step), out = new Float32Array(3 * columns * rows);
  for (let y = 0, k = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++) for (let c = 0; c < 3; c++) out[k++] = pixels[3 * (y * step * width + x * step) + c]!;
  }
  return out;
}
