// SPDX-License-Identifier: MIT
// The package's public names.

export { PRTRelightPlugin } from "./plugin.js";
export { PRTRelight } from "./relight.js";
