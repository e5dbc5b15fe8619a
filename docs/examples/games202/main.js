// SPDX-License-Identifier: GPL-3.0-or-later
// The page loads what it is told to, turns the sky by its slider, and the camera by dragging.
"use strict";

const MODES = ["InterRef", "Shadowed", "Unshadowed"];
const SUPERSAMPLING = 2; // not multisampling, which shades pixels beyond the edges of triangles: they show as dots
const element = (id) => document.getElementById(id);
const asked = new URLSearchParams(location.search);
const canvas = element("view");
const say = (text) => (element("message").textContent = text);
let viewer;

/** Show what `read(name)` gives of "mesh", "light.txt", "transport.txt" (texts) and of faces (pictures, or null). */
async function load(read) {
  try {
    say("Loading ...");
    const places = Files.corners(await read("mesh"));
    const transport = Files.transport(await read("transport.txt"), places.length / 3);
    viewer.setScene(places, transport, Files.light(await read("light.txt")));
    const faces = await Promise.all(Files.FACES.map(read));
    if (faces.every(Boolean)) viewer.setSky(faces);
    say("");
    draw();
  } catch (error) {
    say(error.message);
  }
}

async function fetched(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(`${path} is not there: ${answer.status}. Serve the folder that 'make course' makes, or choose files.`);
  return answer;
}

function fromServer(name) {
  const at = (key, otherwise) => asked.get(key) ?? otherwise;
  if (name === "mesh") return fetched(at("mesh", "figure.obj")).then((answer) => answer.text());
  if (name.endsWith(".txt")) return fetched(`${element("mode").value}/${name}`).then((answer) => answer.text());
  return fetched(`${at("sky", "cubemap/Forest")}/${name}.jpg`).then((answer) => answer.blob()).then(createImageBitmap);
}

async function fromChoice(name) {
  const files = [...element("files").files];
  const found = files.find((file) => (name === "mesh" ? /\.obj$/i.test(file.name) : file.name === name || file.name.split(".")[0] === name));
  if (found) return Files.FACES.includes(name) ? createImageBitmap(found) : found.text();
  if (Files.FACES.includes(name)) return null;
  throw new Error(`Choose ${name === "mesh" ? "an .obj" : name}, too: the mesh, light.txt and transport.txt belong together.`);
}

function draw() {
  const angle = element("turn").value * Math.PI / 180, [sin, cos] = [Math.sin(angle), Math.cos(angle)];
  viewer.turn = [[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]];
  [canvas.width, canvas.height] = [canvas.clientWidth, canvas.clientHeight].map((size) => SUPERSAMPLING * size * devicePixelRatio);
  viewer.draw(canvas.width, canvas.height);
}

function listen() {
  for (const mode of asked.has("files") ? [asked.get("files")] : MODES) element("mode").add(new Option(mode));
  element("mode").onchange = () => load(fromServer);
  element("files").onchange = () => load(fromChoice);
  element("turn").oninput = draw;
  window.onresize = draw;
  canvas.onpointerdown = (event) => canvas.setPointerCapture(event.pointerId);
  canvas.onpointermove = (event) => {
    if (!event.buttons) return;
    viewer.azimuth -= event.movementX / 200;
    viewer.elevation = Math.max(-1.5, Math.min(1.5, viewer.elevation + event.movementY / 200));
    draw();
  };
  element("turn").value = asked.get("turn") ?? 0;
}

const gl = canvas.getContext("webgl", { antialias: false });
if (gl) {
  viewer = new Viewer(gl);
  listen();
  if (location.protocol === "file:") say("Choose an .obj, light.txt, transport.txt and the six faces of the cube map.");
  else load(fromServer);
} else say("This browser draws no WebGL: try another, or another graphics driver.");
