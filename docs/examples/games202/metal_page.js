// SPDX-License-Identifier: GPL-3.0-or-later
// The page of metal turns the lamp, and takes the colour of the metal.
"use strict";

const element = (id) => document.getElementById(id);
const canvas = element("view");

async function start() {
  if (location.protocol === "file:") throw new Error("Browsers read no pictures from disk: serve the folder that 'make course' makes.");
  const gl = canvas.getContext("webgl");
  if (!gl) throw new Error("This browser draws no WebGL: try another, or another graphics driver.");
  const metal = new Metal(gl, ...(await Promise.all(["GGX_E_LUT.png", "GGX_Eavg_LUT.png"].map(Metal.table))));
  const draw = () => {
    const angle = element("lamp").value * Math.PI / 180, hex = element("metal").value;
    metal.lamp = [Math.sin(angle), 0, Math.cos(angle)];
    metal.metal = [1, 3, 5].map((at) => (parseInt(hex.slice(at, at + 2), 16) / 255) ** 2.2);
    metal.course = element("course").checked;
    [canvas.width, canvas.height] = [canvas.clientWidth, canvas.clientHeight].map((size) => size * devicePixelRatio);
    metal.draw(canvas.width, canvas.height);
  };
  for (const id of ["lamp", "metal", "course"]) element(id).oninput = draw;
  window.onresize = draw;
  draw();
}

start().catch((error) => (element("message").textContent = error.message));
