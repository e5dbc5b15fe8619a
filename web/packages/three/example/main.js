// SPDX-License-Identifier: MIT
// A baked file under its own sky's light, seen from its own camera; what it draws can be read as linear light.

import { FloatType, Scene, WebGLRenderer, WebGLRenderTarget } from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { PRTRelightPlugin } from "@prt-relight/three";

/** Loads a file's bytes, and draws it with every call of `draw`. */
export async function show(canvas, bytes) {
  const renderer = new WebGLRenderer({ canvas, antialias: true });
  const loader = new GLTFLoader().register(() => new PRTRelightPlugin());
  const gltf = await loader.parseAsync(bytes, "");
  const camera = gltf.cameras[0], { prt } = gltf.userData;
  const scene = new Scene().add(gltf.scene);
  scene.updateMatrixWorld(true);
  return {
    prt,
    scene,
    draw: () => renderer.render(scene, camera),
    radiance(width, height) {
      const target = new WebGLRenderTarget(width, height, { type: FloatType }), pixels = new Float32Array(4 * width * height);
      renderer.setClearAlpha(0);
      renderer.setRenderTarget(target);
      renderer.render(scene, camera);
      renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
      renderer.setRenderTarget(null);
      target.dispose();
      return pixels;
    },
  };
}
