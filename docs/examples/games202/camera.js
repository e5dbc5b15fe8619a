// SPDX-License-Identifier: GPL-3.0-or-later
// Camera looks at the middle of a mesh from all around, from as far away as shows all of it.
"use strict";

const FIELD_OF_VIEW = 40 * Math.PI / 180;

class Camera {
  constructor() {
    this.azimuth = 0.35;
    this.elevation = 0.12;
    this.lookAt([0, 0, 0]);
  }

  /** Places of corners, three numbers each. */
  lookAt(places) {
    const least = [0, 1, 2].map((k) => places.reduce((m, v, i) => (i % 3 === k ? Math.min(m, v) : m), Infinity));
    const most = [0, 1, 2].map((k) => places.reduce((m, v, i) => (i % 3 === k ? Math.max(m, v) : m), -Infinity));
    this.centre = least.map((value, k) => (value + most[k]) / 2);
    this.radius = Math.hypot(...most.map((value, k) => value - least[k])) / 2;
  }

  /** Where it is, its axes (right, up and back), and how far from the middle. */
  place() {
    const [sa, ca, se, ce] = [Math.sin(this.azimuth), Math.cos(this.azimuth), Math.sin(this.elevation), Math.cos(this.elevation)];
    const axes = [[ca, 0, -sa], [-se * sa, ce, -se * ca], [ce * sa, se, ce * ca]];
    const distance = this.radius / Math.sin(FIELD_OF_VIEW / 2);
    return { eye: this.centre.map((value, k) => value + distance * axes[2][k]), axes, distance };
  }

  /** World to view: three rows of four numbers. */
  view() {
    const { eye, axes } = this.place();
    return axes.map((axis) => [...axis, -axis.reduce((sum, v, k) => sum + v * eye[k], 0)]);
  }

  /** World to clip space, column by column. */
  matrix(aspect) {
    const rows = this.view(), { distance } = this.place(), scale = 1 / Math.tan(FIELD_OF_VIEW / 2);
    const near = distance - 1.01 * this.radius, far = distance + 1.01 * this.radius;
    const clip = [
      rows[0].map((v) => v * scale / aspect),
      rows[1].map((v) => v * scale),
      rows[2].map((v, k) => (v * (far + near) + (k === 3 ? 2 * far * near : 0)) / (near - far)),
      rows[2].map((v) => -v),
    ];
    return [0, 1, 2, 3].flatMap((column) => clip.map((row) => row[column]));
  }

  /** Tangents of half the angle that is seen, across and up. */
  static tangents(aspect) {
    const tangent = Math.tan(FIELD_OF_VIEW / 2);
    return [tangent * aspect, tangent];
  }
}
