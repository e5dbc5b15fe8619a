// SPDX-License-Identifier: MIT
// A mesh whose material takes its diffuse sky light from transport. Lamps, shadow maps and reflections stay three's own.

import { BACKS, BAKED_BELOW, GLSL_WITHOUT_NEGATIVES, LAYERS, layerScales, type Light, OWN_AXES_BELOW } from "@prt-relight/core";
import { type BufferAttribute, DataTexture, FloatType, type Mesh, type MeshStandardMaterial, NearestFilter, RGBAFormat } from "three";

const WIDTH = 4096; // of the texture

const lowerCase = (names: readonly string[]) => names.map((name) => name.toLowerCase()); // as GLTFLoader writes them
const NAMES = lowerCase(LAYERS), NAMES_OF_BACKS = lowerCase(BACKS);

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
    const sides = transport.hasBacks ? "#define PRT_BACKS\n" : "";
    material.onBeforeCompile = (shader) => {
      shader.uniforms["prtTransport"] = this.transport;
      shader.uniforms["prtLight"] = this.light;
      shader.vertexShader = sides + DECLARED + shader.vertexShader.replace("#include <begin_vertex>", `#include <begin_vertex>\n${SUMMED}`);
      shader.fragmentShader = sides + SEEN + shader.fragmentShader.replace(
        "#include <lights_fragment_end>",
        "#include <lights_fragment_end>\n  reflectedLight.indirectDiffuse = withoutNegatives(prtOfThisSide()) * diffuseColor.rgb;",
      );
    };
    material.customProgramCacheKey = () => `prt-relight ${sides}`;
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
#ifdef PRT_BACKS
varying vec3 vPrtBehind;
const int PRT_LAYERS = ${LAYERS.length + BACKS.length};
#else
const int PRT_LAYERS = ${LAYERS.length};
#endif
vec4 prtLayer(int layer) {
  int at = PRT_LAYERS * gl_VertexID + layer, width = textureSize(prtTransport, 0).x;
  return texelFetch(prtTransport, ivec2(at % width, at / width), 0);
}
`;

const SUMMED = `
  vPrtRadiance = vec3(0.0);
  for (int i = 0; i < 9; i++) vPrtRadiance += prtLayer(i).rgb * prtLight[i];
#ifdef PRT_BACKS
  vec4 prtFirst = prtLayer(9), prtSecond = prtLayer(10), prtThird = prtLayer(11);
  vec3 prtColour = vec3(prtSecond.a, prtThird.a, 3.0 - prtSecond.a - prtThird.a);
  vPrtBehind = prtColour * ((prtFirst.r + 1.0) * prtLight[0] + prtFirst.g * prtLight[1] + prtFirst.b * prtLight[2]
    + prtSecond.r * prtLight[3] + prtSecond.g * prtLight[4] + prtSecond.b * prtLight[5]
    + prtThird.r * prtLight[6] + prtThird.g * prtLight[7] + prtThird.b * prtLight[8]);
  if (prtFirst.r > ${BAKED_BELOW.toFixed(1)}) vPrtBehind = vPrtRadiance;
#endif
`;

const SEEN = `
varying vec3 vPrtRadiance;
${GLSL_WITHOUT_NEGATIVES}
#ifdef PRT_BACKS
varying vec3 vPrtBehind;
vec3 prtOfThisSide() { return gl_FrontFacing ? vPrtRadiance : vPrtBehind; }
#else
vec3 prtOfThisSide() { return vPrtRadiance; }
#endif
`;

/** The layers of a geometry as one texture; they are taken off it, as a shader has room for sixteen attributes. */
export class TransportTexture {
  readonly texture: DataTexture;
  readonly inOwnAxes: boolean;
  readonly hasBacks: boolean;

  constructor(mesh: Mesh) {
    const { geometry } = mesh, extras: unknown = geometry.userData["prt_relight"];
    this.hasBacks = NAMES_OF_BACKS.every((name) => name in geometry.attributes);
    const names = this.hasBacks ? [...NAMES, ...NAMES_OF_BACKS] : NAMES, scales = [...layerScales(extras), ...layerScales(extras, "backs")];
    const vertices = geometry.getAttribute(NAMES[0]!).count, height = Math.max(1, Math.ceil((names.length * vertices) / WIDTH));
    const data = new Float32Array(4 * WIDTH * height);
    names.forEach((name, i) => {
      const [colour, alpha] = scales[i]!, layer = geometry.getAttribute(name) as BufferAttribute;
      for (let vertex = 0; vertex < vertices; vertex++) {
        for (let k = 0; k < 4; k++) data[4 * (names.length * vertex + i) + k] = layer.getComponent(vertex, k) * (k < 3 ? colour : alpha);
      }
    });
    this.inOwnAxes = data[3]! < OWN_AXES_BELOW;
    for (const name of [...NAMES, ...NAMES_OF_BACKS]) geometry.deleteAttribute(name);
    this.texture = new DataTexture(data, WIDTH, height, RGBAFormat, FloatType);
    this.texture.minFilter = this.texture.magFilter = NearestFilter;
    this.texture.needsUpdate = true;
  }
}
