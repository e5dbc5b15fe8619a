// SPDX-License-Identifier: GPL-3.0-or-later
// Milliseconds of a frame of an exported page, in a headless Chromium that draws by software: while the camera moves, and
// while the sky turns.
//
// node page_frames.mjs PAGE BROWSER [WIDTH HEIGHT] gives {camera, sky}, each {wall, cpu, scale, frames}: seconds of a frame
// by the clock and of all the browser's processes, and the share of the screen's pixels, along each side, that is drawn.

import { readdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const SETTLES = 4000, MEASURED = 4000; // milliseconds
const TICK = 0.01; // seconds, of /proc

const puppeteer = createRequire(new URL("../../web/package.json", import.meta.url))("puppeteer-core");
const [path, executablePath, width = "1280", height = "720"] = process.argv.slice(2);
const args = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];
const browser = await puppeteer.launch({ executablePath, headless: true, args });
try {
  const page = await browser.newPage();
  await page.setViewport({ width: Number(width), height: Number(height) });
  await page.goto(pathToFileURL(path).href);
  await page.waitForSelector("body:not(.loading)", { timeout: 120_000 });
  const camera = await measured(page, "prt.orbit.turn(0.01, 0)"), sky = await measured(page, "prt.turn += 0.01");
  process.stdout.write(JSON.stringify({ camera, sky }));
} finally {
  await browser.close();
}

/** What a frame of a movement takes, once the page draws as finely as it will. */
async function measured(page, step) {
  await moved(page, step, SETTLES);
  const before = spent();
  const { frames, milliseconds, scale } = await moved(page, step, MEASURED);
  return { wall: milliseconds / frames / 1000, cpu: (spent() - before) / frames, scale, frames };
}

/** Takes a step with every frame of the screen, as a hand does that drags. */
function moved(page, step, least) {
  return page.evaluate(async (code, until) => {
    const prt = await window.prt, take = new Function("prt", code), canvas = document.getElementById("canvas");
    const begun = performance.now();
    let frames = 0;
    while (performance.now() - begun < until) {
      take(prt);
      prt.redraw();
      await new Promise((done) => prt.addEventListener("change", done, { once: true }));
      frames++;
    }
    return { frames, milliseconds: performance.now() - begun, scale: canvas.width / canvas.clientWidth };
  }, step, least);
}

/** Processor seconds of all the browser's processes. */
function spent() {
  const children = new Map();
  for (const id of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      const [, parent, ...rest] = readFileSync(`/proc/${id}/stat`, "utf8").replace(/^.*\) /s, "").split(" ");
      children.set(parent, [...(children.get(parent) ?? []), { id, ticks: Number(rest[9]) + Number(rest[10]) }]);
    } catch {
      continue; // it has ended meanwhile
    }
  }
  const below = (id) => (children.get(String(id)) ?? []).reduce((sum, child) => sum + child.ticks + below(child.id), 0);
  return TICK * below(browser.process().pid);
}
