// SPDX-License-Identifier: MIT
// What three.js' reader of .exr needs of three.js: the build gives it this in three.js' place, which is ten times as large.

export { DataUtils } from "three/src/extras/DataUtils.js";
export { FloatType, HalfFloatType, LinearFilter, LinearSRGBColorSpace, NoColorSpace, RedFormat, RGBAFormat, RGFormat } from "three/src/constants.js";

/** Its base class loads from the network, which the page does not. */
export function DataTextureLoader() {}
