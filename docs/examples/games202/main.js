// SPDX-License-Identifier: GPL-3.0-or-later
// The page of transport draws the mesh, under the sky that the slider turns.
"use strict";

const SUPERSAMPLING = 2; // not multisampling, which shades pixels beyond the edges of triangles: they show as dots
const canvas = element("view");
const gl = canvas.getContext("webgl", { antialias: false });

if (gl) {
  const viewer = new Viewer(gl);
  const draw = () => {
    viewer.turn = Page.turn();
    [canvas.width, canvas.height] = [canvas.clientWidth, canvas.clientHeight].map((size) => SUPERSAMPLING * size * devicePixelRatio);
    viewer.draw(canvas.width, canvas.height);
  };
  new Page(canvas, ["InterRef", "Shadowed", "Unshadowed"], viewer, draw).start();
} else say("This browser draws no WebGL: try another, or another graphics driver.");
