// SPDX-License-Identifier: GPL-3.0-or-later
// Page is what the pages of a mesh have in common: where files come from, what is said of them, and the dragged camera.
"use strict";

const element = (id) => document.getElementById(id);
const say = (text) => (element("message").textContent = text);
const asked = new URLSearchParams(location.search);

class Page {
  /** Folders of transport.txt that can be chosen, what has `setScene`, `setSky` and a `camera`, and the function that draws it. */
  constructor(canvas, modes, shown, draw) {
    this._shown = shown;
    this._draw = draw;
    for (const mode of asked.has("files") ? [asked.get("files")] : modes) element("mode").add(new Option(mode));
    element("mode").onchange = () => this._load(Page._fromServer);
    element("files").onchange = () => this._load(Page._fromChoice);
    element("turn").value = asked.get("turn") ?? 0;
    element("turn").oninput = window.onresize = draw;
    this._letDrag(canvas, shown.camera);
  }

  start() {
    if (location.protocol === "file:") say("Choose an .obj, light.txt, transport.txt and the six faces of the cube map.");
    else this._load(Page._fromServer);
  }

  /** R of the sky, by the slider: about the axis that points up. */
  static turn() {
    const angle = element("turn").value * Math.PI / 180, [sin, cos] = [Math.sin(angle), Math.cos(angle)];
    return [[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]];
  }

  /** Show what `read(name)` gives of "mesh", "light.txt", "transport.txt" (texts) and of faces (pictures, or null). */
  async _load(read) {
    try {
      say("Loading ...");
      const mesh = Files.mesh(await read("mesh"));
      const transport = Files.transport(await read("transport.txt"), mesh.places.length / 3);
      this._shown.setScene(mesh, transport, Files.light(await read("light.txt")));
      const faces = await Promise.all(Files.FACES.map(read));
      if (faces.every(Boolean)) this._shown.setSky(faces);
      say("");
      this._draw();
    } catch (error) {
      say(error.message);
    }
  }

  static async _fetched(path) {
    const answer = await fetch(path);
    if (!answer.ok) throw new Error(`${path} is not there: ${answer.status}. Serve the folder that 'make course' makes, or choose files.`);
    return answer;
  }

  static _fromServer(name) {
    const at = (key) => asked.get(key) ?? document.body.dataset[key];
    if (name === "mesh") return Page._fetched(at("mesh")).then((answer) => answer.text());
    if (name.endsWith(".txt")) return Page._fetched(`${element("mode").value}/${name}`).then((answer) => answer.text());
    return Page._fetched(`${at("sky")}/${name}.jpg`).then((answer) => answer.blob()).then(createImageBitmap);
  }

  static async _fromChoice(name) {
    const files = [...element("files").files];
    const found = files.find((file) => (name === "mesh" ? /\.obj$/i.test(file.name) : file.name === name || file.name.split(".")[0] === name));
    if (found) return Files.FACES.includes(name) ? createImageBitmap(found) : found.text();
    if (Files.FACES.includes(name)) return null;
    throw new Error(`Choose ${name === "mesh" ? "an .obj" : name}, too: the mesh, light.txt and transport.txt belong together.`);
  }

  _letDrag(canvas, camera) {
    canvas.onpointerdown = (event) => canvas.setPointerCapture(event.pointerId);
    canvas.onpointermove = (event) => {
      if (!event.buttons) return;
      camera.azimuth -= event.movementX / 200;
      camera.elevation = Math.max(-1.5, Math.min(1.5, camera.elevation + event.movementY / 200));
      this._draw();
    };
  }
}
