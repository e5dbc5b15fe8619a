// SPDX-License-Identifier: MIT
// The model: a binary glTF file as our exporter writes it, read into meshes in Blender's axes.

import { fromColumns, type Matrix3, multiplied, transposed, unitColumns, type Vector3 } from "@prt-relight/core";
import { fromLinear, linearPart, type Matrix4, placed, product, transformed } from "./matrix4.js";
import { type Side, unpacked, unpackedBacks } from "./transport.js";
import { ordered } from "./vertex_order.js";

/** Blender's X, Y and Z in glTF's axes, which are Y up. */
const AXES: Matrix3 = fromColumns([1, 0, 0], [0, 0, -1], [0, 1, 0]);

export interface Texture {
  readonly image: ImageBitmap;
  readonly repeated: readonly [boolean, boolean];
  readonly smooth: boolean;
  /** Whether its numbers are of the sRGB curve, and not linear. */
  readonly isColour: boolean;
  /** Which of the mesh's coordinates it is laid out by. */
  readonly coordinates: number;
  /** Offset and scale of the coordinates. */
  readonly placing: readonly [number, number, number, number];
}

export interface Material {
  readonly colour: readonly number[];
  readonly texture: Texture | null;
  readonly emission: readonly number[];
  readonly emissionTexture: Texture | null;
  readonly alpha: "OPAQUE" | "MASK" | "BLEND";
  readonly cutoff: number;
  readonly doubleSided: boolean;
  /** Where the surface is bent, and how much. */
  readonly normalTexture: Texture | null;
  readonly normalScale: number;
  /** Null of what mirrors nothing. */
  readonly gloss: Gloss | null;
}

/** What a surface mirrors, as a Principled BSDF and glTF have it. */
export interface Gloss {
  readonly metallic: number;
  readonly roughness: number;
  /** What a dielectric reflects of what comes straight at it. */
  readonly straight: number;
  /** Roughness in green, metallic in blue. */
  readonly texture: Texture | null;
}

/** What the fronts of a mesh receive, in the scene's axes or in the object's own; of what is glossy, bent by a picture or lit by suns with the direct part. */
export interface Transport extends Side {
  readonly inOwnAxes: boolean;
  /** What the backs receive; null where they show the light of the fronts, or are not seen. */
  readonly backs: Side | null;
}

export interface Mesh {
  readonly name: string;
  readonly vertices: number;
  readonly positions: Float32Array;
  readonly normals: Float32Array;
  readonly coordinates: readonly (Float32Array | null)[];
  readonly triangles: Uint32Array;
  readonly transport: Transport | null;
  readonly material: Material;
}

/** A mesh at a place in the world. */
export interface Instance {
  readonly mesh: Mesh;
  readonly world: Matrix4;
  /** The object's own axes. */
  readonly axes: Matrix3;
  readonly centre: Vector3;
}

export interface Model {
  readonly instances: readonly Instance[];
  readonly least: Vector3;
  readonly most: Vector3;
}

/* eslint-disable-next-line @typescript-eslint/no-explicit-any -- glTF's JSON */
type Json = any;

export async function readModel(bytes: Uint8Array): Promise<Model> {
  const reader = new Reader(bytes);
  const document = reader.document;
  const images = await Promise.all(((document.images ?? []) as Json[]).map((image) => reader.image(image)));
  const materials = ((document.materials ?? []) as Json[]).map((material) => materialOf(document, material, images));
  const meshes = ((document.meshes ?? []) as Json[]).map((mesh) =>
    (mesh.primitives as Json[])
      .filter((primitive) => (primitive.mode ?? 4) === 4)
      .map((primitive) => ordered(reader.mesh(mesh.name ?? "", primitive, materials[primitive.material] ?? PLAIN))),
  );
  const instances: Instance[] = [];
  const visit = (index: number, parent: Matrix4) => {
    const node = document.nodes[index];
    const local = node.matrix
      ? Float64Array.from(node.matrix as number[])
      : placed(node.translation ?? [0, 0, 0], node.rotation ?? [0, 0, 0, 1], node.scale ?? [1, 1, 1]);
    const place = product(parent, local);
    if (node.mesh !== undefined) for (const mesh of meshes[node.mesh]!) instances.push(instanceOf(mesh, place));
    for (const child of node.children ?? []) visit(child, place);
  };
  for (const root of document.scenes[document.scene ?? 0].nodes ?? []) visit(root, fromLinear(transposed(AXES)));
  return { instances, ...boundsOf(instances) };
}

function instanceOf(mesh: Mesh, world: Matrix4): Instance {
  const { least, most } = boundsOf([{ mesh, world }]);
  const centre = [0, 1, 2].map((k) => (least[k]! + most[k]!) / 2) as unknown as Vector3;
  return { mesh, world, axes: unitColumns(multiplied(linearPart(world), AXES)), centre };
}

function boundsOf(instances: readonly Pick<Instance, "mesh" | "world">[]): { least: Vector3; most: Vector3 } {
  const least = [Infinity, Infinity, Infinity], most = [-Infinity, -Infinity, -Infinity];
  for (const { mesh, world } of instances) {
    for (let k = 0; k < mesh.positions.length; k += 3) {
      transformed(world, [mesh.positions[k]!, mesh.positions[k + 1]!, mesh.positions[k + 2]!]).forEach((value, axis) => {
        least[axis] = Math.min(least[axis]!, value);
        most[axis] = Math.max(most[axis]!, value);
      });
    }
  }
  return { least: least as unknown as Vector3, most: most as unknown as Vector3 };
}

const PLAIN: Material = {
  colour: [0.8, 0.8, 0.8, 1], texture: null, emission: [0, 0, 0], emissionTexture: null, alpha: "OPAQUE",
  cutoff: 0.5, doubleSided: true, normalTexture: null, normalScale: 1, gloss: null,
};

function materialOf(document: Json, material: Json, images: readonly ImageBitmap[]): Material {
  const surface = material.pbrMetallicRoughness ?? {};
  const brightness = material.extensions?.KHR_materials_emissive_strength?.emissiveStrength ?? 1;
  return {
    colour: surface.baseColorFactor ?? [1, 1, 1, 1],
    texture: textureOf(document, surface.baseColorTexture, images),
    emission: ((material.emissiveFactor ?? [0, 0, 0]) as number[]).map((value) => value * brightness),
    emissionTexture: textureOf(document, material.emissiveTexture, images),
    alpha: material.alphaMode ?? "OPAQUE",
    cutoff: material.alphaCutoff ?? 0.5,
    doubleSided: material.doubleSided ?? false,
    normalTexture: textureOf(document, material.normalTexture, images, false),
    normalScale: material.normalTexture?.scale ?? 1,
    gloss: material.pbrMetallicRoughness ? glossOf(document, material, images) : null,
  };
}

function glossOf(document: Json, material: Json, images: readonly ImageBitmap[]): Gloss | null {
  const surface = material.pbrMetallicRoughness, { KHR_materials_ior: ior, KHR_materials_specular: specular } = material.extensions ?? {};
  const metallic = surface.metallicFactor ?? 1, index = ior?.ior ?? 1.5;
  const straight = ((index - 1) / (index + 1)) ** 2 * (specular?.specularFactor ?? 1);
  if (metallic === 0 && straight === 0) return null;
  return {
    metallic, straight,
    roughness: surface.roughnessFactor ?? 1,
    texture: textureOf(document, surface.metallicRoughnessTexture, images, false),
  };
}

function textureOf(document: Json, info: Json, images: readonly ImageBitmap[], isColour = true): Texture | null {
  if (!info) return null;
  const texture = document.textures[info.index], sampler = document.samplers?.[texture.sampler] ?? {};
  const image = images[texture.source];
  if (!image) return null;
  const moved = info.extensions?.KHR_texture_transform ?? {};
  const [offset, scale] = [moved.offset ?? [0, 0], moved.scale ?? [1, 1]];
  return {
    image, isColour,
    repeated: [(sampler.wrapS ?? 10497) !== 33071, (sampler.wrapT ?? 10497) !== 33071],
    smooth: sampler.magFilter !== 9728,
    coordinates: moved.texCoord ?? info.texCoord ?? 0,
    placing: [offset[0], offset[1], scale[0], scale[1]],
  };
}

const WIDTHS: Record<string, number> = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };
const MOST: Record<number, number> = { 5120: 127, 5121: 255, 5122: 32767, 5123: 65535 };

class Reader {
  readonly document: Json;
  private readonly view: DataView;
  private readonly start: number;

  constructor(private readonly bytes: Uint8Array) {
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    const length = this.view.getUint32(12, true);
    this.document = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length)));
    this.start = 20 + length + 8;
  }

  mesh(name: string, primitive: Json, material: Material): Mesh {
    const given = (key: string) => (key in primitive.attributes ? this.floats(primitive.attributes[key]) : null);
    const positions = this.floats(primitive.attributes.POSITION), vertices = positions.length / 3;
    const packed = primitive.extras?.prt_relight;
    return {
      name, vertices, positions, material,
      normals: given("NORMAL") ?? new Float32Array(3 * vertices),
      coordinates: [given("TEXCOORD_0"), given("TEXCOORD_1")],
      triangles: primitive.indices === undefined
        ? Uint32Array.from({ length: vertices }, (_, k) => k)
        : Uint32Array.from(this.numbers(primitive.indices)),
      transport: packed
        ? {
          ...unpacked(this.slice(packed.view), vertices, packed.tints, packed.direct),
          scale: packed.scale,
          inOwnAxes: packed.space === "OBJECT",
          backs: packed.backs ? unpackedBacks(this.slice(packed.backs.view), vertices, packed.backs.scale, packed.direct) : null,
        }
        : null,
    };
  }

  image(image: Json): Promise<ImageBitmap> {
    const blob = new Blob([this.slice(image.bufferView) as BlobPart], { type: image.mimeType });
    return createImageBitmap(blob, { premultiplyAlpha: "none", colorSpaceConversion: "none" });
  }

  private slice(index: number): Uint8Array {
    const view = this.document.bufferViews[index], first = this.start + (view.byteOffset ?? 0);
    return this.bytes.subarray(first, first + view.byteLength);
  }

  private numbers(index: number): number[] {
    const accessor = this.document.accessors[index], view = this.document.bufferViews[accessor.bufferView];
    const width = WIDTHS[accessor.type]!, { size, read } = this.component(accessor.componentType);
    const stride = view.byteStride ?? width * size;
    const first = this.start + (view.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
    const out = new Array<number>(accessor.count * width);
    for (let row = 0, k = 0; row < accessor.count; row++) {
      for (let column = 0; column < width; column++, k++) out[k] = read(first + row * stride + column * size);
    }
    return out;
  }

  private floats(index: number): Float32Array {
    const accessor = this.document.accessors[index], most = accessor.normalized ? MOST[accessor.componentType]! : 1;
    return Float32Array.from(this.numbers(index), (value) => value / most);
  }

  private component(type: number): { size: number; read: (at: number) => number } {
    const { view } = this;
    switch (type) {
      case 5120: return { size: 1, read: (at) => view.getInt8(at) };
      case 5121: return { size: 1, read: (at) => view.getUint8(at) };
      case 5122: return { size: 2, read: (at) => view.getInt16(at, true) };
      case 5123: return { size: 2, read: (at) => view.getUint16(at, true) };
      case 5125: return { size: 4, read: (at) => view.getUint32(at, true) };
      default: return { size: 4, read: (at) => view.getFloat32(at, true) };
    }
  }
}
