// SPDX-License-Identifier: MIT
// How finely movements are drawn.

import assert from "node:assert/strict";
import { test } from "node:test";
import { FINEST, Pace } from "../src/pace.js";

function noted(pace: Pace, milliseconds: number, frames: number): Pace {
  for (let frame = 0; frame < frames; frame++) pace.note(milliseconds);
  return pace;
}

test("a quick machine draws finely", () => assert.equal(noted(new Pace(false), 16, 500).moving, FINEST));

test("one slow frame among others changes nothing", () => {
  const pace = new Pace(false);
  for (let k = 0; k < 50; k++) noted(noted(pace, 300, 2), 16, 1);
  assert.equal(pace.moving, FINEST);
});

test("a slow machine draws coarser, down to a limit, and a very slow one gets there sooner", () => {
  const slow = noted(new Pace(false), 60, 3), slower = noted(new Pace(false), 200, 3);
  assert.ok(slow.moving.samples < FINEST.samples && slower.moving.scale < slow.moving.scale);
  assert.equal(noted(slow, 60, 100).moving.scale, noted(slower, 200, 100).moving.scale);
  assert.ok(slow.moving.scale > 0.3);
});

test("without a graphics card it begins coarsely, and draws finely if it can", () => {
  const pace = new Pace(true);
  assert.ok(pace.moving.scale < 0.5);
  assert.equal(noted(pace, 16, 600).moving, FINEST);
});

test("a machine that was busy draws finely again, but does not go to and fro for ever", () => {
  const pace = noted(new Pace(false), 60, 3);
  assert.equal(noted(pace, 16, 60).moving, FINEST);
  noted(pace, 60, 3);
  assert.notEqual(noted(pace, 16, 600).moving, FINEST);
});
