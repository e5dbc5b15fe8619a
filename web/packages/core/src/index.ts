// SPDX-License-Identifier: MIT
// The package's public names.

export * from "./bands.js";
export * from "./find_lamps.js";
export * from "./harmonics.js";
export * from "./lamps.js";
export * from "./layout.js";
export * from "./matrix.js";
export * from "./radiance.js";
export * from "./shading.js";
export * from "./sky.js";
export * from "./truncation.js";
export * from "./turn.js";
export * from "./vertex_light.js";
export * from "./view.js";
