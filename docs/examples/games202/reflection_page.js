// SPDX-License-Identifier: GPL-3.0-or-later
// The page of reflection draws the mesh in the chosen light.
"use strict";

const canvas = element("view");
const gl = canvas.getContext("webgl2", { antialias: false });

try {
  if (!gl) throw new Error("This browser draws no WebGL 2: try another, or another graphics driver.");
  const reflection = new Reflection(gl);
  const draw = () => {
    reflection.turn = Page.turn();
    reflection.mode = element("light").value;
    reflection.floorOnly = element("floor").checked;
    reflection.samples = Math.max(1, Math.min(64, Math.round(element("samples").valueAsNumber) || 1));
    reflection.bound = element("bound").valueAsNumber;
    [canvas.width, canvas.height] = [canvas.clientWidth, canvas.clientHeight].map((size) => size * devicePixelRatio);
    reflection.draw(canvas.width, canvas.height);
  };
  for (const id of ["light", "floor", "samples", "bound"]) element(id).oninput = draw;
  element("light").value = asked.get("light") ?? "mirror";
  element("samples").value = asked.get("rays") ?? 8;
  new Page(canvas, ["Boxes"], reflection, draw).start();
} catch (error) {
  say(error.message);
}
