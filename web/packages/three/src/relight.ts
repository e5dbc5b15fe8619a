// SPDX-License-Identifier: MIT
// A loaded scene under its sky: turned, scaled, or lit by another.

import {
  aboutZ, fromColumns, IDENTITY, type Light, lightOf, type Matrix3, multiplied, projected, scaled, transposed, turned, unitColumns,
  type Vector3,
} from "@prt-relight/core";
import { type BufferGeometry, type DataTexture, DataUtils, FloatType, HalfFloatType, Matrix4, type Mesh, type Object3D, type Scene } from "three";
import { BakedMaterial, isBaked, TransportTexture } from "./material.js";

/** Blender's X, Y and Z in three's axes, which are Y up, unless a file says otherwise. */
const Y_UP: readonly [Vector3, Vector3, Vector3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]];

interface Extras {
  readonly axes?: readonly [Vector3, Vector3, Vector3];
  readonly light?: readonly (readonly number[])[];
  readonly turn?: readonly Vector3[];
  readonly strength?: number;
}

/** All baked meshes of a loaded scene, and the sky that lights them. */
export class PRTRelight {
  private readonly meshes: { mesh: Mesh; material: BakedMaterial }[] = [];
  private readonly textures = new Map<BufferGeometry, TransportTexture>();
  private readonly axes: Matrix3;
  private light: Light = new Float64Array(27);
  private turn: Matrix3 = IDENTITY;
  private angle = 0;
  private scale = 1;
  private background: Scene | null = null;

  /** Takes over what is baked below an object; extras are what the file says of its light, `scene.userData.prt_relight`. */
  constructor(root: Object3D, extras?: unknown) {
    const { axes, light, turn, strength } = (extras ?? {}) as Extras;
    this.axes = fromColumns(...(axes ?? Y_UP));
    if (light && turn && strength !== undefined) {
      this.light = lightOf(light);
      this.turn = fromColumns(...(turn as [Vector3, Vector3, Vector3]));
      this.scale = strength;
    }
    root.updateMatrixWorld(true);
    root.traverse((object) => {
      const mesh = object as Mesh;
      if (mesh.isMesh && (this.textures.has(mesh.geometry) || isBaked(mesh))) this.add(mesh);
    });
    this.update();
  }

  /** How many meshes are relit. */
  get count(): number { return this.meshes.length; }

  /** How far the sky is turned about the upward axis, in radians. */
  get rotation(): number { return this.angle; }
  set rotation(angle: number) { this.angle = angle; this.update(); }

  /** By what the sky is scaled. */
  get strength(): number { return this.scale; }
  set strength(strength: number) { this.scale = strength; this.update(); }

  /**
   * Lights with another sky: an equirectangular texture as HDRLoader or EXRLoader gives it, which is projected, or nine RGB
   * coefficients in Blender's axes. It begins unturned.
   */
  setSky(sky: DataTexture | readonly (readonly number[])[]): void {
    this.light = Array.isArray(sky) ? lightOf(sky) : projected(pictureOf(sky as DataTexture));
    this.turn = IDENTITY;
    this.update();
  }

  /** Keeps the background of a scene turned and scaled as the light is; null lets go of it. */
  showIn(scene: Scene | null): void {
    this.background = scene;
    this.update();
  }

  /** Frees the graphics card's memory. */
  dispose(): void {
    for (const { texture } of this.textures.values()) texture.dispose();
  }

  private add(mesh: Mesh): void {
    const transport = this.textures.get(mesh.geometry) ?? new TransportTexture(mesh);
    this.textures.set(mesh.geometry, transport);
    const material = new BakedMaterial(mesh, transport);
    this.meshes.push({ mesh, material });
    if (transport.inOwnAxes) mesh.onBeforeRender = () => this.show(mesh, material, this.shown());
  }

  private shown(): Light {
    return scaled(turned(this.light, this.turned()), this.scale);
  }

  private turned(): Matrix3 {
    return multiplied(this.turn, aboutZ(-this.angle));
  }

  private update(): void {
    const light = this.shown();
    for (const { mesh, material } of this.meshes) this.show(mesh, material, light);
    if (!this.background) return;
    const m = transposed(multiplied(multiplied(this.axes, this.turned()), transposed(this.axes)));
    const turn = new Matrix4().set(m[0], m[1], m[2], 0, m[3], m[4], m[5], 0, m[6], m[7], m[8], 0, 0, 0, 0, 1);
    this.background.backgroundRotation.setFromRotationMatrix(turn);
    this.background.environmentRotation.copy(this.background.backgroundRotation);
    this.background.backgroundIntensity = this.background.environmentIntensity = this.scale;
  }

  private show(mesh: Mesh, material: BakedMaterial, light: Light): void {
    if (!material.inOwnAxes) return material.show(light);
    const e = mesh.matrixWorld.elements;
    const world: Matrix3 = [e[0]!, e[4]!, e[8]!, e[1]!, e[5]!, e[9]!, e[2]!, e[6]!, e[10]!];
    material.show(turned(light, unitColumns(multiplied(multiplied(transposed(this.axes), world), this.axes))));
  }
}

function pictureOf(texture: DataTexture) {
  const { data, width, height } = texture.image as { data: ArrayLike<number>; width: number; height: number };
  if (texture.type !== FloatType && texture.type !== HalfFloatType) throw new Error("A sky is a texture of floats or half floats.");
  const read = texture.type === HalfFloatType ? DataUtils.fromHalfFloat : (value: number) => value;
  const channels = data.length / (width * height), pixels = new Float32Array(3 * width * height);
  for (let y = 0, k = 0; y < height; y++) {
    const row = texture.flipY ? y : height - 1 - y; // the top row comes first
    for (let x = 0; x < width; x++) for (let c = 0; c < 3; c++) pixels[k++] = read(data[channels * (row * width + x) + c]!);
  }
  return { width, height, pixels };
}
