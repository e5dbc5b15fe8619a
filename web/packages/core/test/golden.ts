// SPDX-License-Identifier: MIT
// The golden numbers of tests/golden, which Blender's side is checked against, too.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";

export function golden<Numbers>(name: string): Numbers {
  const path = new URL(`../../../../tests/golden/${name}.json`, import.meta.url);
  return JSON.parse(readFileSync(path, "utf8")) as Numbers;
}

/** Fails unless all numbers are as wanted, to an absolute error. */
export function near(found: ArrayLike<number>, wanted: ArrayLike<number>, most: number): void {
  assert.equal(found.length, wanted.length);
  for (let i = 0; i < wanted.length; i++) {
    assert.ok(Math.abs(found[i]! - wanted[i]!) <= most, `number ${i} is ${found[i]} and not ${wanted[i]}`);
  }
}
