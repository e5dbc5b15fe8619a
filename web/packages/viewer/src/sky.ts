// SPDX-License-Identifier: MIT
// A sky to light with: a picture, its light, and how it was turned and scaled in Blender.

import { findLamps, fromColumns, IDENTITY, lightOfLamps, type Light, lightOf, type Matrix3, type Picture, projected, readRadiance, transposed, type Vector3 } from "@prt-relight/core";
import { readExr } from "./exr.js";
import { file, type SkyEntry, type SunEntry, type SunRule } from "./page.js";

export interface Sky {
  readonly name: string;
  readonly light: Light;
  /** The part of the light that suns show instead; as their direct light alone, what bounces of it stays. */
  readonly lamps: Light;
  readonly suns: readonly SunEntry[];
  /** Along w, the sky shows what its picture holds along `turn` w. */
  readonly turn: Matrix3;
  readonly strength: number;
  readonly picture: Picture;
}

/** A sky that was exported with the page. */
export async function embeddedSky(entry: SkyEntry): Promise<Sky> {
  const [x, y, z] = entry.turn as [Vector3, Vector3, Vector3];
  return {
    name: entry.name,
    light: lightOf(entry.light),
    lamps: lightOf(entry.lamps),
    suns: entry.suns,
    turn: transposed(fromColumns(x, y, z)),
    strength: entry.strength,
    picture: readRadiance(await file(entry.picture)),
  };
}

const READERS: Record<string, (bytes: Uint8Array) => Picture> = { hdr: readRadiance, exr: readExr };

/** A sky of a person's own, whose suns are taken out by a rule; throws an Error whose message is a sentence. */
export async function openedSky(chosen: File, { most, enough }: SunRule): Promise<Sky> {
  const [, name, kind] = /^(.*)\.(\w+)$/.exec(chosen.name) ?? [], read = READERS[kind?.toLowerCase() ?? ""];
  if (!read) throw new Error(`"${chosen.name}" is no .hdr or .exr file: other panoramas must be converted to one.`);
  let picture: Picture;
  try {
    picture = read(new Uint8Array(await chosen.arrayBuffer()));
  } catch (error) {
    throw new Error(`"${chosen.name}" cannot be opened. ${(error as Error).message}`);
  }
  if (Math.abs(picture.width - 2 * picture.height) > 1) {
    throw new Error(`"${chosen.name}" is ${picture.width} × ${picture.height}: a panorama is twice as wide as high.`);
  }
  const found = findLamps(picture, most, enough);
  const suns = found.lamps.map(({ direction, irradiance, radius }) => (
    { direction, radius, irradiance: found.colour.map((channel) => irradiance * channel) as unknown as Vector3 }
  ));
  return { name: name!, light: projected(picture), lamps: lightOfLamps(found), suns, turn: IDENTITY, strength: 1, picture };
}
