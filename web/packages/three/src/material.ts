// SPDX-License-Identifier: MIT
// A mesh whose material takes its diffuse sky light from transport. Lamps, shadow maps and reflections stay three's own.

import { GLSL_WITHOUT_NEGATIVES, LAYERS, layerScales, type Light, OWN_AXES_BELOW } from "@prt-relight/core";
import { type BufferAttribute, DataTexture, FloatType, type Mesh, type MeshStandardMaterial, NearestFilter, RGBAFormat } from "three";

const WIDTH = 4095; // of the texture: a multiple of the nine layers

const NAMES = LAYERS.map((name) => name.toLowerCase()); // as GLTFLoader writes them

export function isBaked(mesh: Mesh): boolean {
  return NAMES.every((name) => name in mesh.geometry.attributes);
}

/** A baked mesh on the graphics card. */
export class BakedMaterial {
  readonly inOwnAxes: boolean;
  private readonly light = { value: new Float32Array(27) };
  private readonly transport: { value: DataTexture };

  constructor(mesh: Mesh, transport: TransportTexture) {
    this.inOwnAxes = transport.inOwnAxes;
    this.transport = { value: transport.texture };
    const material = (mesh.material as MeshStandardMaterial).clone();
    material.onBeforeCompile = (shader) => {
      shader.uniforms["prtTransport"] = this.transport;
      shader.uniforms["prtLight"] = this.light;
      shader.vertexShader = DECLARED + shader.vertexShader.replace("#include <begin_vertex>", `#include <begin_vertex>\n${SUMMED}`);
      shader.fragmentShader = `varying vec3 vPrtRadiance;\n${GLSL_WITHOUT_NEGATIVES}\n` + shader.fragmentShader.replace(
        "#include <lights_fragment_end>",
        "#include <lights_fragment_end>\n  reflectedLight.indirectDiffuse = withoutNegatives(vPrtRadiance) * diffuseColor.rgb;",
      );
    };
    material.customProgramCacheKey = () => "prt-relight";
    mesh.material = material;
  }

  /** Light in the transport's axes. */
  show(light: Light): void {
    this.light.value.set(light);
  }
}

const DECLARED = `
uniform highp sampler2D prtTransport;
uniform vec3 prtLight[9];
varying vec3 vPrtRadiance;
`;

const SUMMED = `
  vPrtRadiance = vec3(0.0);
  int prtWidth = textureSize(prtTransport, 0).x;
  for (int i = 0; i < 9; i++) {
    int at = 9 * gl_VertexID + i;
    vPrtRadiance += texelFetch(prtTransport, ivec2(at % prtWidth, at / prtWidth), 0).rgb * prtLight[i];
  }
`;

/** The layers of a geometry as one texture; they are taken off it, as a shader has room for sixteen attributes. */
export class TransportTexture {
  readonly texture: DataTexture;
  readonly inOwnAxes: boolean;

  constructor(mesh: Mesh) {
    const { geometry } = mesh, layers = NAMES.map((name) => geometry.getAttribute(name) as BufferAttribute);
    const vertices = layers[0]!.count, height = Math.max(1, Math.ceil((9 * vertices) / WIDTH));
    const data = new Float32Array(4 * WIDTH * height);
    const scales = layerScales(geometry.userData["prt_relight"]);
    layers.forEach((layer, i) => {
      const [colour, alpha] = scales[i]!;
      for (let vertex = 0; vertex < vertices; vertex++) {
        for (let k = 0; k < 4; k++) data[4 * (9 * vertex + i) + k] = layer.getComponent(vertex, k) * (k < 3 ? colour : alpha);
      }
    });
    this.inOwnAxes = data[3]! < OWN_AXES_BELOW;
    for (const name of NAMES) geometry.deleteAttribute(name);
    this.texture = new DataTexture(data, WIDTH, height, RGBAFormat, FloatType);
    this.texture.minFilter = this.texture.magFilter = NearestFilter;
    this.texture.needsUpdate = true;
  }
}
