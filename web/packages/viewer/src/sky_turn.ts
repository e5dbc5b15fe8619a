// SPDX-License-Identifier: MIT
// How a sky is turned: three angles in radians, by which it rolls about Y, then tilts about X, then turns about Z.

import { about, aboutZ, type Matrix3, multiplied, type Vector3 } from "@prt-relight/core";

export interface SkyTurn {
  /** -pi to pi. */
  readonly turn: number;
  /** -pi / 2 to pi / 2. */
  readonly tilt: number;
  /** -pi to pi. */
  readonly roll: number;
}

export const UNTURNED: SkyTurn = { turn: 0, tilt: 0, roll: 0 };

export function rotationOf({ turn, tilt, roll }: SkyTurn): Matrix3 {
  return multiplied(aboutZ(turn), multiplied(about([1, 0, 0], tilt), about([0, 1, 0], roll)));
}

/** Turned further, about any unit vector. */
export function turnedAbout(before: SkyTurn, axis: Vector3, angle: number): SkyTurn {
  if (axis[2] === 1) return { ...before, turn: wrapped(before.turn + angle) };
  const [, b, , , e, , g, h, i] = multiplied(about(axis, angle), rotationOf(before));
  return { turn: Math.atan2(-b, e), tilt: Math.asin(Math.min(Math.max(h, -1), 1)), roll: Math.atan2(-g, i) };
}

/** An angle as it is between -pi and pi. */
export function wrapped(angle: number): number {
  return angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
}
