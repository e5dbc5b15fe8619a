// SPDX-License-Identifier: MIT
// Builds the package: one module without three.js, and its types.

import { execFileSync } from "node:child_process";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = fileURLToPath(new URL("./", import.meta.url));
const options = { bundle: true, format: "esm", target: "es2022", external: ["three", "three/*"] };
await build({ ...options, entryPoints: [`${here}src/index.ts`], outfile: `${here}dist/index.js` });
const tsc = fileURLToPath(new URL("../../node_modules/typescript/bin/tsc", import.meta.url));
execFileSync(process.execPath, [tsc, "-p", `${here}tsconfig.json`], { stdio: "inherit" });
