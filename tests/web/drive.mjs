// SPDX-License-Identifier: GPL-3.0-or-later
// Drives a real browser, headless, as a request on standard input says; answers with JSON on standard output.
//
// {browser, page, width, height, touch, flags, steps: [{run: "expression"} | {await: "expression, until it is true"} | {drag: {from, to, keys, button}} | {picture: path} | {drop: {name, data}} | {press: key} | {resize: [width, height]}]}
// gives {results: [of each step], errors: [what the page could not do]}. Floats come as {floats: base64}.

import { createRequire } from "node:module";
import { readFileSync } from "node:fs";

const require = createRequire(new URL("../../web/package.json", import.meta.url));
const puppeteer = require("puppeteer-core");
const request = JSON.parse(readFileSync(0, "utf8"));

const browser = await puppeteer.launch({
  executablePath: request.browser,
  headless: true,
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", ...(request.flags ?? [])],
});
try {
  process.stdout.write(JSON.stringify(await drive()));
} finally {
  await browser.close();
}

async function drive() {
  const page = await browser.newPage(), errors = [];
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("request", (asked) => /^(file|data|blob):/.test(asked.url()) || errors.push(`asked the network for ${asked.url()}`));
  const { width, height, touch } = request;
  await page.setViewport({ width, height, isMobile: Boolean(touch), hasTouch: Boolean(touch) });
  await page.goto(request.page);
  await page.waitForSelector("body:not(.loading)", { timeout: 120_000 });
  const results = [];
  for (const step of request.steps) results.push(await done(page, step));
  return { results, errors };
}

async function done(page, step) {
  if (step.run) return page.evaluate(inPage, step.run);
  if (step.await) return void (await page.waitForFunction(step.await, { timeout: 120_000 }));
  if (step.picture) return void (await page.screenshot({ path: step.picture }));
  if (step.drop) return page.evaluate(drop, step.drop.name, step.drop.data);
  if (step.resize) return void (await page.setViewport({ width: step.resize[0], height: step.resize[1] }));
  if (step.press) return void (await page.keyboard.press(step.press));
  return drag(page, step.drag);
}

/** Evaluates an expression in the page, in which `prt` is the viewer. */
async function inPage(expression) {
  const prt = await window.prt.catch(() => null);
  const value = await new Function("prt", `return (async () => ${expression})()`)(prt);
  if (!(value instanceof Float32Array)) return value;
  let text = "";
  for (const byte of new Uint8Array(value.buffer)) text += String.fromCharCode(byte);
  return { floats: btoa(text) };
}

async function drop(name, data) {
  const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
  const transfer = new DataTransfer();
  transfer.items.add(new File([bytes], name));
  for (const kind of ["dragover", "drop"]) {
    document.body.dispatchEvent(new DragEvent(kind, { dataTransfer: transfer, bubbles: true, cancelable: true }));
  }
  await new Promise((resolve) => setTimeout(resolve, 500));
}

async function drag(page, { from, to, keys = [], button = "left" }) {
  for (const key of keys) await page.keyboard.down(key);
  await page.mouse.move(...from);
  await page.mouse.down({ button });
  await page.mouse.move(...to, { steps: 4 });
  await page.mouse.up({ button });
  for (const key of keys) await page.keyboard.up(key);
}
