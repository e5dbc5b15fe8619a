// SPDX-License-Identifier: MIT
// The plugin of GLTFLoader: it leaves a PRTRelight in the userData of what was loaded.

import type { GLTF, GLTFLoaderPlugin } from "three/examples/jsm/loaders/GLTFLoader.js";
import { PRTRelight } from "./relight.js";

/** `loader.register(() => new PRTRelightPlugin())`; then `gltf.userData.prt` is a PRTRelight. */
export class PRTRelightPlugin implements GLTFLoaderPlugin {
  readonly name = "PRT_relight";

  afterRoot(gltf: GLTF): null {
    gltf.userData["prt"] = new PRTRelight(gltf.scene, gltf.scene.userData["prt_relight"]);
    return null;
  }
}
