// SPDX-License-Identifier: MIT
// What the exporter has put into the page: the scene's description, and files in base64 and gzip.

/** A lamp that stands for a spot of the sky. */
export interface SunEntry {
  /** A unit vector towards it, in the unturned sky. */
  readonly direction: readonly [number, number, number];
  /** Of a surface that faces it, at strength 1. */
  readonly irradiance: readonly [number, number, number];
  /** Of its disc, in radians. */
  readonly radius: number;
}

export interface SkyEntry {
  readonly name: string;
  /** Nine RGB coefficients, unturned and at strength 1. */
  readonly light: readonly (readonly number[])[];
  /** The part of it that suns show instead, and these. */
  readonly lamps: readonly (readonly number[])[];
  readonly suns: readonly SunEntry[];
  /** Rows of R: along w, the sky shows what its picture holds along R w. */
  readonly turn: readonly (readonly number[])[];
  readonly strength: number;
  /** Identifier of the element that holds the .hdr file. */
  readonly picture: string;
}

export interface ViewEntry {
  readonly name: string;
  readonly tip: string;
  /** Identifier of the element that holds the table, three bytes a texel, red fastest; none for Standard. */
  readonly table?: string;
}

export interface Camera {
  readonly position: readonly number[];
  readonly target: readonly number[];
  /** A unit vector to its right, which says how it is turned where it looks straight down or up. */
  readonly right: readonly number[];
  /** Half of what the frame takes, across and up, over the distance: of a lens, the tangents of half its angles. */
  readonly tangents: readonly [number, number];
  /** Whether it looks everywhere the same way. */
  readonly orthographic: boolean;
}

/** How suns are taken out of skies that are opened. */
export interface SunRule {
  /** So many at most: 0 where bakes lack their direct part. */
  readonly most: number;
  /** Truncation of the light under which no more are looked for; 0 for as many as there are. */
  readonly enough: number;
}

export interface Description {
  readonly title: string;
  readonly camera: Camera | null;
  readonly exposure: number;
  readonly skies: readonly SkyEntry[];
  readonly suns: SunRule;
  readonly views: readonly ViewEntry[];
  /** Index of the view to begin with. */
  readonly view: number;
}

export function description(): Description {
  return JSON.parse(textOf("prt-scene")) as Description;
}

/** The bytes of an embedded file. */
export async function file(id: string): Promise<Uint8Array> {
  const binary = atob(textOf(id));
  const packed = new Uint8Array(binary.length);
  for (let k = 0; k < binary.length; k++) packed[k] = binary.charCodeAt(k);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function textOf(id: string): string {
  const text = document.getElementById(id)?.textContent;
  if (!text) throw new Error(`The page is not whole: its part "${id}" is missing. Export it again.`);
  return text;
}
