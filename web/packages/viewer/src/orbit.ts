// SPDX-License-Identifier: MIT
// The camera: it goes round a point, nearer and farther, with Z up, and begins where the scene's own stands.

import { aboutZ, applied, type Matrix3, transposed, type Vector3 } from "@prt-relight/core";
import { type Matrix4, product } from "./matrix4.js";
import type { Model } from "./model.js";
import type { Camera } from "./page.js";

const STEEPEST = 1.55; // radians above and below the horizon
const UPRIGHT = 1e-4; // sine of the angle to the vertical, under which that to the horizon says nothing of how a camera is turned
const SKY_TANGENT = 0.45; // how widely an orthographic camera sees the sky, of which it should see one point

export class Orbit {
  private azimuth = 0;
  private elevation = 0;
  private distance = 1;
  private target: Vector3 = [0, 0, 0];
  private tangents: readonly [number, number] = [0.4, 0.4];
  private readonly size: number;
  /** Whether it looks everywhere the same way: what is far is as large as what is near. */
  readonly isOrthographic: boolean;

  constructor(private readonly model: Model, private readonly start: Camera | null) {
    const { least, most } = model;
    this.size = Math.hypot(most[0] - least[0], most[1] - least[1], most[2] - least[2]) || 1;
    this.isOrthographic = start?.orthographic ?? false;
    this.reset();
  }

  /** Back to the scene's own view; without one, all of the model from the front. */
  reset(): void {
    const { least, most } = this.model;
    const centre: Vector3 = [(least[0] + most[0]) / 2, (least[1] + most[1]) / 2, (least[2] + most[2]) / 2];
    if (!this.start) {
      [this.azimuth, this.elevation, this.distance, this.target] = [-1.2, 0.3, 1.25 * this.size, centre];
      return;
    }
    const { position, target, right, tangents } = this.start;
    const away = [0, 1, 2].map((k) => position[k]! - target[k]!) as unknown as Vector3;
    this.distance = Math.hypot(...away);
    const isUpright = Math.hypot(away[0], away[1]) > UPRIGHT * this.distance;
    this.azimuth = isUpright ? Math.atan2(away[1], away[0]) : Math.atan2(-right[0]!, right[1]!);
    this.elevation = Math.asin(away[2] / this.distance);
    this.target = target as unknown as Vector3;
    this.tangents = tangents;
  }

  turn(azimuth: number, elevation: number): void {
    this.azimuth += azimuth;
    this.elevation = Math.min(Math.max(this.elevation + elevation, -STEEPEST), STEEPEST);
  }

  zoom(factor: number): void {
    this.distance = Math.min(Math.max(this.distance * factor, 0.02 * this.size), 20 * this.size);
  }

  /** Moves what is looked at, by shares of the height that is seen. */
  shift(right: number, up: number): void {
    const [x, y] = this.axes(), step = 2 * this.tangents[1] * this.distance;
    this.target = this.target.map((value, k) => value - step * (right * x[k]! + up * y[k]!)) as unknown as Vector3;
  }

  get position(): Vector3 {
    const [, , z] = this.axes();
    return this.target.map((value, k) => value + this.distance * z[k]!) as unknown as Vector3;
  }

  /** Where the camera is, and 1; or, if it looks everywhere the same way, the way to it, and 0. */
  get eye(): readonly [number, number, number, number] {
    return this.isOrthographic ? [...this.axes()[2], 0] : [...this.position, 1];
  }

  /** Columns: the camera's right, up and back, in the world. */
  get rotation(): Matrix3 {
    return transposed(this.axes().flat() as unknown as Matrix3);
  }

  /**
   * Half of what is seen across and up, over the distance: all that the scene's frame holds, whatever the shape of the window, and
   * above the share of it that is covered from below.
   */
  seen(aspect: number, covered = 0): readonly [number, number] {
    const [across, up] = this.tangents, free = aspect / (1 - covered);
    const width = free >= across / up ? up * free : across;
    return [width, width / aspect];
  }

  /** The same for the sky. */
  skySeen(aspect: number, covered: number): readonly [number, number] {
    return this.isOrthographic ? [SKY_TANGENT, SKY_TANGENT / aspect] : this.seen(aspect, covered);
  }

  /** From the world to what WebGL clips. */
  clip(aspect: number, covered = 0): Matrix4 {
    const [right, up, back] = this.axes(), eye = this.position;
    const along = (axis: Vector3) => -(axis[0] * eye[0] + axis[1] * eye[1] + axis[2] * eye[2]);
    const view = Float64Array.of(
      right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
      along(right), along(up), along(back), 1,
    );
    return product(this.isOrthographic ? this.parallel(aspect, covered) : this.perspective(aspect, covered), view);
  }

  private perspective(aspect: number, covered: number): Matrix4 {
    const [x, y] = this.seen(aspect, covered), [middle, reach] = this.depths();
    const near = Math.max(middle - reach, this.size / 1000), far = Math.max(middle + reach, 2 * near);
    return Float64Array.of(
      1 / x, 0, 0, 0, 0, 1 / y, 0, 0, 0, -covered, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0,
    );
  }

  private parallel(aspect: number, covered: number): Matrix4 {
    const [x, y] = this.seen(aspect, covered), [middle, reach] = this.depths(), { distance } = this;
    return Float64Array.of(1 / (x * distance), 0, 0, 0, 0, 1 / (y * distance), 0, 0, 0, 0, -1 / reach, 0, 0, covered, -middle / reach, 1);
  }

  /** How far ahead the middle of the model is, and how far the model reaches from there. */
  private depths(): [number, number] {
    const { least, most } = this.model, eye = this.position, [, , back] = this.axes();
    const middle = eye.reduce((sum, value, k) => sum + back[k]! * (value - (least[k]! + most[k]!) / 2), 0);
    return [middle, 0.6 * this.size];
  }

  private axes(): [Vector3, Vector3, Vector3] {
    const cos = Math.cos(this.elevation), sin = Math.sin(this.elevation), turn = aboutZ(this.azimuth);
    return [applied(turn, [0, 1, 0]), applied(turn, [-sin, 0, cos]), applied(turn, [cos, 0, sin])];
  }
}
