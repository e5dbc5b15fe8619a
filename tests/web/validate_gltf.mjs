// SPDX-License-Identifier: GPL-3.0-or-later
// Print Khronos' report on a glTF file, as JSON, so that Python can read it.
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";

const [packages, path] = process.argv.slice(2);
const { validateBytes } = createRequire(join(packages, "package.json"))("gltf-validator");
const externalResourceFunction = (uri) => readFile(join(dirname(path), decodeURIComponent(uri)));
const report = await validateBytes(new Uint8Array(await readFile(path)), { maxIssues: 0, externalResourceFunction });
process.stdout.write(JSON.stringify(report));
