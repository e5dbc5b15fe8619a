// SPDX-License-Identifier: MIT
// The state of the page: which sky, turned how far, seen from where and shown how. Draws when something has changed.

import { multiplied, transposed, type Vector3 } from "@prt-relight/core";
import type { Model } from "./model.js";
import { Orbit } from "./orbit.js";
import { FINEST, Pace, type Quality } from "./pace.js";
import type { Description, SunRule } from "./page.js";
import { type Frame, Renderer } from "./renderer.js";
import type { Sky } from "./sky.js";
import { rotationOf, type SkyTurn, turnedAbout, UNTURNED, wrapped } from "./sky_turn.js";
import type { Shading } from "./surfaces.js";

/** What people turn when they drag. */
export type Hands = "view" | "sky";

export interface View {
  readonly name: string;
  readonly tip: string;
  readonly table: Uint8Array | null;
}

const REST = 200; // milliseconds without a change, after which the scene is drawn finely

export class Viewer extends EventTarget {
  readonly orbit: Orbit;
  readonly skies: Sky[];
  /** How suns are taken out of skies that are opened. */
  readonly suns: SunRule;
  private renderer: Renderer | null = null;
  private chosen = 0;
  private skyTurn: SkyTurn = UNTURNED;
  private hands: Hands = "view";
  private stops: number;
  private shown: Shading = "baked";
  private through: number;
  private readonly pace: Pace;
  private waiting = false;
  private resting = 0;
  private hidden = 0;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    gl: WebGL2RenderingContext,
    model: Model,
    skies: readonly Sky[],
    readonly views: readonly View[],
    page: Description,
  ) {
    super();
    this.skies = [...skies];
    this.suns = page.suns;
    this.stops = page.exposure;
    this.through = page.view;
    this.orbit = new Orbit(model, page.camera);
    this.renderer = new Renderer(gl, model);
    this.pace = new Pace(/swiftshader|llvmpipe|software|basic render/i.test(rendererOf(gl)));
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.renderer = null;
    });
    canvas.addEventListener("webglcontextrestored", () => {
      this.renderer = new Renderer(gl, model);
      this.redraw();
    });
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  /** Index of the sky. */
  get sky(): number { return this.chosen; }
  set sky(index: number) { this.chosen = index; this.redraw(); }

  /** How far the sky is turned about Z, in radians from how it stood in Blender, -pi to pi. */
  get turn(): number { return this.skyTurn.turn; }
  set turn(turn: number) { this.setTurn({ turn: wrapped(turn) }); }

  /** How far it is tilted about X before, -pi / 2 to pi / 2. */
  get tilt(): number { return this.skyTurn.tilt; }
  set tilt(tilt: number) { this.setTurn({ tilt: Math.min(Math.max(tilt, -Math.PI / 2), Math.PI / 2) }); }

  /** How far it is rolled about Y before that, -pi to pi. */
  get roll(): number { return this.skyTurn.roll; }
  set roll(roll: number) { this.setTurn({ roll: wrapped(roll) }); }

  /** Turns the sky further, about a unit vector. */
  turnSky(axis: Vector3, angle: number): void { this.setTurn(turnedAbout(this.skyTurn, axis, angle)); }

  /** What dragging turns. */
  get dragging(): Hands { return this.hands; }
  set dragging(hands: Hands) { this.hands = hands; this.redraw(); }

  /** In stops. */
  get exposure(): number { return this.stops; }
  set exposure(stops: number) { this.stops = stops; this.redraw(); }

  get shading(): Shading { return this.shown; }
  set shading(shading: Shading) { this.shown = shading; this.redraw(); }

  /** Index of the view transform. */
  get view(): number { return this.through; }
  set view(index: number) { this.through = index; this.redraw(); }

  /** Which share of the canvas is covered from below. */
  get covered(): number { return this.hidden; }
  set covered(share: number) { this.hidden = share; this.redraw(); }

  /** Adds a sky to the list, and lights with it. */
  add(sky: Sky): void {
    this.skies.push(sky);
    this.sky = this.skies.length - 1;
  }

  /** Draws with the next frame of the screen, as finely as the machine keeps up with, and tells listeners of `change`. */
  redraw(): void {
    if (this.waiting) return;
    this.waiting = true;
    clearTimeout(this.resting);
    requestAnimationFrame((begun) => {
      this.waiting = false;
      const quality = this.pace.moving;
      this.drawIn(quality);
      this.dispatchEvent(new Event("change"));
      requestAnimationFrame((ended) => {
        this.pace.note(ended - begun);
        if (quality !== FINEST && !this.waiting) this.resting = window.setTimeout(() => this.draw(), REST);
      });
    });
  }

  /** Draws now, finely. */
  draw(): void {
    this.drawIn(FINEST);
  }

  private drawIn(quality: Quality): void {
    const { canvas } = this, ratio = Math.min(window.devicePixelRatio || 1, 2) * quality.scale;
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio)), height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    this.renderer?.draw(this.frame, this.orbit, this.covered, quality);
  }

  /** Linear light without the sky: four floats a pixel, the lowest row first; or, coarse, that of movements on slow machines. */
  radiance(width: number, height: number, coarse = false): Float32Array {
    if (!this.renderer) throw new Error("The browser has lost its graphics.");
    return this.renderer.radiance(this.frame, this.orbit, width, height, coarse);
  }

  private setTurn(change: Partial<SkyTurn>): void {
    this.skyTurn = { ...this.skyTurn, ...change };
    this.redraw();
  }

  private get frame(): Frame {
    const sky = this.skies[this.chosen]!;
    return {
      sky,
      turn: multiplied(sky.turn, transposed(rotationOf(this.skyTurn))),
      exposure: this.stops,
      shading: this.shown,
      table: this.views[this.through]!.table,
    };
  }
}

/** What the browser says that it draws with. */
function rendererOf(gl: WebGL2RenderingContext): string {
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  return String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
}
