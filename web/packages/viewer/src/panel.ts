// SPDX-License-Identifier: MIT
// The panel: it shows the viewer's state and changes it, and takes panoramas that people bring.

import { say } from "./message.js";
import type { Shading } from "./surfaces.js";
import { openedSky } from "./sky.js";
import type { Hands, Viewer } from "./viewer.js";

const SHADINGS: readonly (readonly [Shading, string, string])[] = [
  ["baked", "Baked", "With the shadows and bounces of the bake"],
  ["unshadowed", "Unshadowed", "As without a bake: nothing blocks the sky"],
  ["light", "Light only", "What white surfaces would show"],
];

const HANDS: readonly (readonly [Hands, string, string])[] = [
  ["view", "The view", "Dragging looks around; with shift it turns the sky"],
  ["sky", "The sky", "Dragging turns the sky about any axis; with shift it looks around"],
];

const SMALL = matchMedia("(max-width: 620px), (max-height: 460px)");

export function element<Kind extends HTMLElement = HTMLElement>(id: string): Kind {
  return document.getElementById(id) as Kind;
}

export function fillPanel(viewer: Viewer, title: string): void {
  element("title").textContent = title;
  const turns = (["turn", "tilt", "roll"] as const).map((name) => {
    const set = slider(name, (value) => (viewer[name] = (value * Math.PI) / 180));
    return () => set((180 / Math.PI) * viewer[name], `${Math.round((180 / Math.PI) * viewer[name])}°`);
  });
  const exposure = slider("exposure", (value) => (viewer.exposure = value));
  const hands = choice("hands", HANDS.map(([, name, tip]) => [name, tip]), (index) => (viewer.dragging = HANDS[index]![0]));
  const shading = choice("shading", SHADINGS.map(([, name, tip]) => [name, tip]), (index) => (viewer.shading = SHADINGS[index]![0]));
  const view = choice("view", viewer.views.map(({ name, tip }) => [name, tip]), (index) => (viewer.view = index));
  element("view").hidden = viewer.views.length < 2;
  const sky = element<HTMLSelectElement>("sky");
  sky.addEventListener("change", () => (viewer.sky = sky.selectedIndex));
  const show = () => {
    turns.forEach((one) => one());
    hands(HANDS.findIndex(([name]) => name === viewer.dragging));
    exposure(viewer.exposure, `${viewer.exposure > 0 ? "+" : viewer.exposure < 0 ? "−" : ""}${Math.abs(viewer.exposure).toFixed(1)}`);
    shading(SHADINGS.findIndex(([name]) => name === viewer.shading));
    view(viewer.view);
    while (sky.length < viewer.skies.length) sky.add(new Option(viewer.skies[sky.length]!.name));
    if (sky.selectedIndex !== viewer.sky) sky.selectedIndex = viewer.sky;
  };
  viewer.addEventListener("change", show);
  show();
  takeFiles(viewer);
  fold(viewer);
}

/** Wires a slider; the result shows a value on it, and in words beside it. */
function slider(id: string, set: (value: number) => void): (value: number, text: string) => void {
  const input = element<HTMLInputElement>(id), output = element(`${id}-value`);
  let last = "";
  input.addEventListener("input", () => {
    last = "";
    set(input.valueAsNumber);
  });
  input.addEventListener("dblclick", () => set(0));
  return (value, text) => {
    if (`${value} ${text}` === last) return; // what is written is laid out and painted again, which frames of the scene wait for
    last = `${value} ${text}`;
    input.valueAsNumber = value;
    output.textContent = text;
    const share = (input.valueAsNumber - Number(input.min)) / (Number(input.max) - Number(input.min));
    input.style.setProperty("--filled", `${100 * share}%`);
  };
}

/** Makes one button of a few that exclude each other; the result presses one. */
function choice(id: string, names: readonly (readonly string[])[], set: (index: number) => void): (index: number) => void {
  const inputs = names.map(([name, tip], index) => {
    const label = document.createElement("label"), input = document.createElement("input"), text = document.createElement("span");
    Object.assign(input, { type: "radio", name: id });
    text.textContent = name!;
    label.title = tip!;
    label.append(input, text);
    input.addEventListener("change", () => set(index));
    element(id).append(label);
    return input;
  });
  return (index) => inputs.forEach((input, k) => (input.checked = k === index));
}

function takeFiles(viewer: Viewer): void {
  const input = element<HTMLInputElement>("file");
  const open = async (file: File | undefined) => {
    if (!file) return;
    try {
      viewer.add(await openedSky(file, viewer.suns));
      say("");
    } catch (error) {
      say((error as Error).message);
    }
  };
  element("open").addEventListener("click", () => input.click());
  input.addEventListener("change", () => {
    void open(input.files?.[0]);
    input.value = "";
  });
  const dropping = (is: boolean) => document.body.classList.toggle("dropping", is);
  document.addEventListener("dragover", (event) => {
    event.preventDefault();
    dropping(true);
  });
  document.addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) dropping(false);
  });
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    dropping(false);
    void open(event.dataTransfer?.files[0]);
  });
}

/** Small screens have the panel at the bottom, folded to begin with; the scene goes above it. */
function fold(viewer: Viewer): void {
  const panel = element("panel"), button = element("fold");
  const toggle = () => button.setAttribute("aria-expanded", String(!panel.classList.toggle("folded")));
  button.addEventListener("click", toggle);
  document.addEventListener("keydown", (event) => {
    if (event.key.toLowerCase() === "h" && !event.ctrlKey && !event.metaKey) panel.hidden = !panel.hidden;
  });
  if (SMALL.matches) toggle();
  panel.hidden = false;
  const cover = () => (viewer.covered = SMALL.matches ? Math.min(panel.offsetHeight / window.innerHeight, 0.7) : 0);
  new ResizeObserver(cover).observe(panel);
  window.addEventListener("resize", cover);
}
