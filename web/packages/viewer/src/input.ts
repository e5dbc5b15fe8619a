// SPDX-License-Identifier: MIT
// Hands on the scene: dragging, wheels, fingers and keys.

import type { Viewer } from "./viewer.js";

const TURN = 0.006; // radians a pixel
const STEP = 0.08; // radians a key

interface Finger { x: number; y: number; turnsSky: boolean; shifts: boolean }

export function listen(canvas: HTMLCanvasElement, viewer: Viewer): void {
  const fingers = new Map<number, Finger>();
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    const turnsSky = (event.shiftKey || event.button === 2) !== (viewer.dragging === "sky"), shifts = event.button === 1 || event.ctrlKey || event.metaKey;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY, turnsSky, shifts });
  });
  for (const end of ["pointerup", "pointercancel"] as const) {
    canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  }
  canvas.addEventListener("pointermove", (event) => {
    const finger = fingers.get(event.pointerId);
    if (!finger) return;
    const before = [...fingers.values()].map(({ x, y }) => ({ x, y })), right = event.clientX - finger.x, down = event.clientY - finger.y;
    [finger.x, finger.y] = [event.clientX, event.clientY];
    if (fingers.size === 2) pinch(viewer, before, [...fingers.values()], canvas.clientHeight);
    else if (fingers.size === 1) drag(viewer, finger, right, down, canvas.clientHeight);
    viewer.redraw();
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    viewer.orbit.zoom(Math.exp(Math.sign(event.deltaY) * Math.min(Math.abs(event.deltaY), 100) * 0.0015));
    viewer.redraw();
  }, { passive: false });
  canvas.addEventListener("dblclick", () => {
    viewer.orbit.reset();
    viewer.redraw();
  });
  canvas.addEventListener("keydown", (event) => {
    if (press(viewer, event)) event.preventDefault();
  });
}

function drag(viewer: Viewer, finger: Finger, right: number, down: number, height: number): void {
  if (finger.turnsSky) turnSky(viewer, TURN * right, TURN * down);
  else if (finger.shifts) viewer.orbit.shift(right / height, -down / height);
  else viewer.orbit.turn(-TURN * right, TURN * down);
}

/** About the upward axis, and about the camera's right. */
function turnSky(viewer: Viewer, aside: number, forward: number): void {
  const [x, , , y, , , z] = viewer.orbit.rotation;
  if (aside) viewer.turnSky([0, 0, 1], aside);
  if (forward) viewer.turnSky([x, y, z], forward);
}

interface Point { x: number; y: number }

/** Two fingers: apart goes nearer, twisted turns the sky, together moves along. */
function pinch(viewer: Viewer, before: readonly Point[], now: readonly Point[], height: number): void {
  const between = ([a, b]: readonly Point[]) => ({ x: b!.x - a!.x, y: b!.y - a!.y });
  const middle = ([a, b]: readonly Point[]) => ({ x: (a!.x + b!.x) / 2, y: (a!.y + b!.y) / 2 });
  const then = between(before), here = between(now), from = middle(before), to = middle(now);
  viewer.orbit.zoom(Math.hypot(then.x, then.y) / Math.max(Math.hypot(here.x, here.y), 1));
  viewer.turn -= Math.atan2(then.x * here.y - then.y * here.x, then.x * here.x + then.y * here.y);
  viewer.orbit.shift((to.x - from.x) / height, -(to.y - from.y) / height);
}

/** True if the key means something. */
function press(viewer: Viewer, { key, shiftKey }: KeyboardEvent): boolean {
  const arrow = (right: number, up: number) => () =>
    shiftKey ? turnSky(viewer, STEP * right, -STEP * up) : viewer.orbit.turn(STEP * right, STEP * up);
  const actions: Record<string, () => void> = {
    ArrowLeft: arrow(-1, 0),
    ArrowRight: arrow(1, 0),
    ArrowUp: arrow(0, 1),
    ArrowDown: arrow(0, -1),
    "+": () => viewer.orbit.zoom(1 / 1.1),
    "-": () => viewer.orbit.zoom(1.1),
    "[": () => (viewer.turn -= STEP),
    "]": () => (viewer.turn += STEP),
    Home: () => viewer.orbit.reset(),
    "1": () => (viewer.shading = "baked"),
    "2": () => (viewer.shading = "unshadowed"),
    "3": () => (viewer.shading = "light"),
    s: () => (viewer.dragging = viewer.dragging === "sky" ? "view" : "sky"),
  };
  actions[key]?.();
  viewer.redraw();
  return key in actions;
}
