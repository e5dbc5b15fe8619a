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

/** Gives three.js' reader the few parts of three.js that it needs. */
const partsOfThree = {
  name: "parts of three.js",
  setup: ({ onResolve }) => onResolve({ filter: /^three$/ }, () => ({ path: new URL("src/three_parts.js", here).pathname })),
};

/** What the licences of what is built in want to be told. */
function notice() {
  const three = new URL("../../node_modules/three/", here), reader = readFileSync(new URL("examples/jsm/loaders/EXRLoader.js", three), "utf8");
  const [said] = /^(\/\/.*\n|\n)+/m.exec(reader.slice(reader.indexOf("// Referred")));
  const licences = [readFileSync(new URL("LICENSE", three), "utf8"), said.replace(/^[/ ]+/gm, ""), "fflate: the MIT licence, as above, Copyright (c) Arjun Barrett"];
  return licences.join("\n").replace(/-{2,}/g, "").replace(/\n{2,}/g, "\n").trim();
}

async function bundled(entry) {
  const options = { plugins: [partsOfThree], bundle: true, minify: true, write: false, format: "iife", target: "es2022", legalComments: "none" };
  const { outputFiles } = await build({ ...options, entryPoints: [new URL(entry, here).pathname] });
  return outputFiles[0].text.trim();
}

const parts = { STYLE: await bundled("src/style.css"), SCRIPT: await bundled("src/main.ts"), DIGEST: digest(), NOTICE: notice() };
const page = readFileSync(new URL("src/index.html", here), "utf8");
writeFileSync(TARGET, page.replace(/\{\{(STYLE|SCRIPT|DIGEST|NOTICE)\}\}/g, (_, name) => parts[name]));
