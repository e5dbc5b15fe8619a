// SPDX-License-Identifier: MIT
// The page comes to life: its parts are unpacked, the viewer is made, and panel and hands are joined to it.

import { listen } from "./input.js";
import { say } from "./message.js";
import { readModel } from "./model.js";
import { description, file } from "./page.js";
import { fillPanel } from "./panel.js";
import { embeddedSky } from "./sky.js";
import { Viewer } from "./viewer.js";

declare global {
  interface Window {
    /** For scripts: the viewer, once all is there; rejected if it cannot be. */
    prt: Promise<Viewer>;
  }
}

async function open(): Promise<Viewer> {
  const page = description(), canvas = document.getElementById("canvas") as HTMLCanvasElement;
  const gl = canvas.getContext("webgl2", { antialias: false, alpha: false, depth: false, powerPreference: "high-performance" });
  if (!gl) throw new Error("This browser has no WebGL 2: this is a still picture of the scene.");
  if (!("DecompressionStream" in window)) throw new Error("This browser is too old to unpack the scene: this is a still picture of it.");
  const parts = 2 + page.skies.length;
  let done = 0;
  const counted = async <Result>(part: Promise<Result>) => {
    const result = await part;
    const bar = document.querySelector<HTMLElement>("#progress i")!;
    bar.style.width = `${(100 * ++done) / parts}%`;
    await new Promise((resolve) => setTimeout(resolve)); // lets the bar be seen
    return result;
  };
  const model = await counted(file("prt-model").then(readModel));
  const views = await counted(Promise.all(page.views.map(async ({ name, tip, table }) => ({ name, tip, table: table ? await file(table) : null }))));
  const skies = [];
  for (const entry of page.skies) skies.push(await counted(embeddedSky(entry)));
  const viewer = new Viewer(canvas, gl, model, skies, views, page);
  viewer.draw();
  fillPanel(viewer, page.title);
  listen(canvas, viewer);
  document.body.classList.remove("loading");
  return viewer;
}

window.prt = open();
window.prt.catch((error: unknown) => {
  document.body.classList.replace("loading", "no-gl");
  say((error as Error).message, true);
});
