// SPDX-License-Identifier: MIT
// Builds the viewer into one file of the extension, with a digest of its sources: npm run build, in packages/viewer.

import { createHash } from "node:crypto";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

const here = new URL("./", import.meta.url);
const WEB = new URL("../../", here);
const TARGET = new URL("../prt_addon/scene/export/viewer.html", WEB);
const FOLDERS = ["packages/core/src/", "packages/viewer/src/"];

/** Of all that the built file is made of; tests/web/test_viewer_file.py reckons it again. */
function digest() {
  const hash = createHash("sha256");
  for (const folder of FOLDERS) {
    for (const name of readdirSync(new URL(folder, WEB)).sort()) {
      hash.update(`${folder}${name}\n`).update(readFileSync(new URL(folder + name, WEB)));
    }
  }
  return hash.digest("hex");
}

async function bundled(entry) {
  const options = { bundle: true, minify: true, write: false, format: "iife", target: "es2022", legalComments: "none" };
  const { outputFiles } = await build({ ...options, entryPoints: [new URL(entry, here).pathname] });
  return outputFiles[0].text.trim();
}

const parts = { STYLE: await bundled("src/style.css"), SCRIPT: await bundled("src/main.ts"), DIGEST: digest() };
const page = readFileSync(new URL("src/index.html", here), "utf8");
writeFileSync(TARGET, page.replace(/\{\{(STYLE|SCRIPT|DIGEST)\}\}/g, (_, name) => parts[name]));
