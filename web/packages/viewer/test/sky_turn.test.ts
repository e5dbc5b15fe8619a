// SPDX-License-Identifier: MIT
// Skies turned about any axis.

import assert from "node:assert/strict";
import { test } from "node:test";
import { about, aboutZ, multiplied, type Vector3 } from "@prt-relight/core";
import { rotationOf, turnedAbout, UNTURNED, wrapped } from "../src/sky_turn.js";

function near(found: readonly number[], wanted: readonly number[]): void {
  wanted.forEach((value, k) => assert.ok(Math.abs(found[k]! - value) < 1e-12, `${found} is not ${wanted}`));
}

test("turns about any axes add up to their product, and stay within their ranges", () => {
  const steps: [Vector3, number][] = [[[0, 0, 1], 3], [[0.6, 0.8, 0], 1.2], [[0, 0, 1], 2], [[0, -1, 0], 2.5], [[0.48, 0.6, 0.64], -1.9]];
  let sky = UNTURNED, wanted = rotationOf(UNTURNED);
  for (const [axis, angle] of steps) {
    sky = turnedAbout(sky, axis, angle);
    wanted = multiplied(about(axis, angle), wanted);
    near(rotationOf(sky), wanted);
    assert.ok(Math.abs(sky.turn) <= Math.PI && Math.abs(sky.tilt) <= Math.PI / 2 && Math.abs(sky.roll) <= Math.PI);
  }
});

test("about Z a sky only turns", () => {
  const tilted = turnedAbout(UNTURNED, [1, 0, 0], 0.4), further = turnedAbout(tilted, [0, 0, 1], 0.5);
  assert.ok(Math.abs(further.turn - tilted.turn - 0.5) < 1e-12);
  assert.equal(further.tilt, tilted.tilt);
  near(rotationOf(turnedAbout(UNTURNED, [0, 0, 1], 1)), aboutZ(1));
});

test("angles go round", () => near([wrapped(3.5), wrapped(-3.5), wrapped(0.1)], [3.5 - 2 * Math.PI, 2 * Math.PI - 3.5, 0.1]));
