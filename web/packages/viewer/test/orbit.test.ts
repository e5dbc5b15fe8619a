// SPDX-License-Identifier: MIT
// The camera: where it begins, and what it keeps in sight.

import assert from "node:assert/strict";
import { test } from "node:test";
import type { Vector3 } from "@prt-relight/core";
import { transformed, type Matrix4 } from "../src/matrix4.js";
import { Orbit } from "../src/orbit.js";

const MODEL = { instances: [], least: [-1, -1, 0] as Vector3, most: [1, 1, 2] as Vector3 };
const CAMERA = { position: [3, -8, 4], target: [0, 0, 1], right: [0.936, 0.351, 0], tangents: [0.3, 0.2] as const, orthographic: false };

function seenAt(clip: Matrix4, [x, y, z]: Vector3): Vector3 {
  const w = clip[3]! * x + clip[7]! * y + clip[11]! * z + clip[15]!;
  return transformed(clip, [x, y, z]).map((value) => value / w) as unknown as Vector3;
}

test("it begins at the scene's camera, and looks at its target", () => {
  const orbit = new Orbit(MODEL, CAMERA);
  orbit.position.forEach((value, k) => assert.ok(Math.abs(value - CAMERA.position[k]!) < 1e-12));
  const [x, y, depth] = seenAt(orbit.clip(1.5), [0, 0, 1]);
  assert.ok(Math.abs(x) < 1e-12 && Math.abs(y) < 1e-12 && Math.abs(depth) < 1);
});

test("windows of any shape hold the frame of the scene's camera", () => {
  const orbit = new Orbit(MODEL, CAMERA);
  for (const aspect of [0.3, 1, 1.5, 4]) {
    const [across, up] = orbit.seen(aspect);
    assert.ok(across >= 0.3 - 1e-12 && up >= 0.2 - 1e-12 && Math.abs(across / up - aspect) < 1e-12);
    assert.ok(Math.abs(across - 0.3) < 1e-12 || Math.abs(up - 0.2) < 1e-12);
  }
});

test("above what is covered, all of the frame stays in sight", () => {
  const orbit = new Orbit(MODEL, CAMERA);
  for (const covered of [0.2, 0.6]) {
    const [x, y] = seenAt(orbit.clip(0.5, covered), [0, 0, 1]);
    assert.ok(Math.abs(x) < 1e-12 && Math.abs(y - covered) < 1e-12); // the middle of what is free
    const [across, up] = orbit.seen(0.5, covered);
    assert.ok(across >= 0.3 - 1e-12 && up * (1 - covered) >= 0.2 - 1e-12 && Math.abs(across / up - 0.5) < 1e-12);
  }
});

test("the model stays between the planes that clip, however near it goes", () => {
  for (const factor of [0.01, 0.3, 1, 30]) {
    const orbit = new Orbit(MODEL, CAMERA);
    orbit.zoom(factor);
    orbit.turn(1, 5);
    const clip = orbit.clip(1);
    for (const x of [-1, 1]) for (const y of [-1, 1]) for (const z of [0, 2]) {
      const corner: Vector3 = [x, y, z], w = clip[3]! * x + clip[7]! * y + clip[11]! * z + clip[15]!;
      if (w > 0.05) assert.ok(Math.abs(seenAt(clip, corner)[2]) <= 1);
    }
  }
});

test("without a camera it sees all of the model, and comes back after turns", () => {
  const orbit = new Orbit(MODEL, null), before = orbit.position;
  orbit.turn(0.4, -0.2);
  orbit.shift(0.2, 0.1);
  assert.notDeepEqual(orbit.position, before);
  orbit.reset();
  assert.deepEqual(orbit.position, before);
  for (const x of [-1, 1]) for (const y of [-1, 1]) for (const z of [0, 2]) {
    const [across, up] = seenAt(orbit.clip(1), [x, y, z]);
    assert.ok(Math.abs(across) < 1 && Math.abs(up) < 1);
  }
});

test("up is up: right of the camera stays level", () => {
  const orbit = new Orbit(MODEL, CAMERA);
  orbit.turn(2, 0.7);
  assert.ok(Math.abs(orbit.rotation[6]) < 1e-12 && orbit.rotation[7] > 0);
});

test("an orthographic camera sees what is far as large as what is near, and all of its frame", () => {
  const orbit = new Orbit(MODEL, { ...CAMERA, orthographic: true }), { rotation } = orbit;
  const half = 0.3 * Math.hypot(...CAMERA.position.map((value, k) => value - CAMERA.target[k]!));
  const across = (right: number, back: number) => {
    const point = CAMERA.target.map((value, k) => value + right * rotation[3 * k]! + back * rotation[3 * k + 2]!);
    return seenAt(orbit.clip(1.5), point as unknown as Vector3)[0];
  };
  for (const back of [-0.5, 0, 0.5]) assert.ok(Math.abs(across(0, back)) < 1e-12 && Math.abs(across(half, back) - 1) < 1e-12);
  orbit.zoom(2);
  assert.ok(Math.abs(across(half, 0) - 0.5) < 1e-12);
});

test("a camera that looks straight down is turned as it was", () => {
  for (const angle of [0, 0.5, -2]) {
    const right = [Math.cos(angle), Math.sin(angle), 0], orbit = new Orbit(MODEL, { ...CAMERA, position: [0, 0, 9], right });
    const [x, , , y, , , z] = orbit.rotation;
    [x, y, z].forEach((value, k) => assert.ok(Math.abs(value! - right[k]!) < 1e-9, `${angle}: ${[x, y, z]}`));
  }
});
