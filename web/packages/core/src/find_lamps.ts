// SPDX-License-Identifier: MIT
// Lamps in a picture of the sky, taken out as in Blender (core/sky/find_lamps.py): what bright spots exceed their surroundings by.

import { type Lamps, lightOfLamps, NO_LAMPS } from "./lamps.js";
import type { Light } from "./layout.js";
import type { Vector3 } from "./matrix.js";
import { type Picture, projected } from "./sky.js";
import { MEASURED_ORDER, truncation } from "./truncation.js";

/** Of spots: times the mean radiance, from which on a texel belongs to one; cosine of how far it goes from its middle; how bright its heart is. */
interface Kind {
  readonly brightness: number;
  readonly reach: number;
  readonly heart: number;
}

const DEGREE = Math.PI / 180;
const COMPACT: Kind = { brightness: 10, reach: Math.cos(12 * DEGREE), heart: 50 };
const WIDE: Kind = { brightness: 3, reach: Math.cos(20 * DEGREE), heart: 0 };
export const ENOUGH = 0.03; // truncation of the light under which no more lamps are looked for
const CELLS = 512, COARSE_CELLS = 64; // rows of cells in which lamps are looked for, and their seeds
const REFINEMENTS = 8;
const WORTH_IT = 0.9; // what another lamp must leave of the truncation at most

/** A picture, its light in many bands, and its mean radiance. */
interface Sky {
  readonly picture: Picture;
  readonly light: Light;
  readonly mean: number;
}

/** Texels, or cells of them: directions and excess light, three numbers each. */
interface Spots {
  readonly kind: Kind;
  readonly least: number; // radiance of the heart of each
  readonly directions: Float64Array;
  readonly excess: Float64Array;
  readonly flux: Float64Array;
  readonly radiance: Float64Array;
}

/** Lamps, and the light that was taken out of the sky for them. */
interface Taken {
  readonly lamps: Lamps["lamps"];
  readonly light: Vector3;
}

/**
 * Takes so many lamps out of a sky at most, compact ones before wide ones, the brightest first; no more compact ones than bring its
 * truncation under `enough`, or, with 0, as many as there are.
 */
export function findLamps(picture: Picture, most: number, enough = 0): Lamps {
  if (most === 0) return NO_LAMPS;
  const sky: Sky = { picture, light: projected(picture, MEASURED_ORDER, false), mean: meanOf(picture) };
  const compact = added(sky, { lamps: [], light: [0, 0, 0] }, brightTexels(sky, COMPACT, []), most, enough);
  const wide = compact.lamps.length < most ? brightTexels(sky, WIDE, compact.lamps) : null;
  return inOneColour(added(sky, compact, wide, most, ENOUGH));
}

function inOneColour({ lamps, light }: Taken): Lamps {
  if (!lamps.length) return NO_LAMPS;
  const mean = (light[0] + light[1] + light[2]) / 3;
  return { lamps, colour: light.map((value) => value / mean) as unknown as Vector3 };
}

function truncationLess(taken: Taken, { light }: Sky): number {
  const lamps = lightOfLamps(inOneColour(taken), MEASURED_ORDER);
  return truncation(light.map((value, k) => value - lamps[k]!), light);
}

/** Lamps for spots, added to those before: the fewest whose truncation is low enough, or not to be improved; with 0, all. */
function added(sky: Sky, before: Taken, spots: Spots | null, most: number, enough: number): Taken {
  if (!spots || before.lamps.length >= most) return before;
  const seeds = seedsOf(spots, most - before.lamps.length);
  if (enough === 0 && seeds.length) return withLamps(before, spots, seeds);
  let best = before, least = truncationLess(before, sky);
  for (let count = 1; count <= seeds.length && least > enough; count++) {
    const more = withLamps(before, spots, seeds.slice(0, count)), loss = truncationLess(more, sky);
    if (loss < WORTH_IT * least) [best, least] = [more, loss];
  }
  return best;
}

/** Solid angle of a texel in a row. */
function solidAngle({ width, height }: Picture, y: number): number {
  const edge = (row: number) => Math.sin(Math.PI * (0.5 - row / height));
  return ((edge(y) - edge(y + 1)) * 2 * Math.PI) / width;
}

function meanOf(picture: Picture): number {
  const { width, height, pixels } = picture;
  let whole = 0;
  for (let y = 0; y < height; y++) {
    let sum = 0;
    for (let k = 3 * y * width; k < 3 * (y + 1) * width; k++) sum += Math.max(pixels[k]!, 0);
    whole += (solidAngle(picture, y) * sum) / 3;
  }
  return whole / (4 * Math.PI);
}

/** The spots of a kind in what compact lamps have left of a sky. */
function brightTexels({ picture, mean }: Sky, kind: Kind, compact: Lamps["lamps"]): Spots | null {
  const { width, height, pixels } = picture, threshold = kind.brightness * mean;
  const directions: number[] = [], excess: number[] = [], all: number[] = [];
  for (let y = 0, k = 0; y < height; y++) {
    const elevation = Math.PI * (0.5 - (y + 0.5) / height), ring = Math.cos(elevation), solid = solidAngle(picture, y);
    for (let x = 0; x < width; x++, k += 3) {
      if ((pixels[k]! + pixels[k + 1]! + pixels[k + 2]!) / 3 <= threshold) continue;
      const rgb = [0, 1, 2].map((c) => Math.max(pixels[k + c]!, 0)), radiance = (rgb[0]! + rgb[1]! + rgb[2]!) / 3;
      const azimuth = 2 * Math.PI * (0.5 - (x + 0.5) / width);
      const towards: Vector3 = [ring * Math.cos(azimuth), ring * Math.sin(azimuth), Math.sin(elevation)];
      const taken = compact.some(({ direction: [a, b, c] }) => a * towards[0] + b * towards[1] + c * towards[2] >= COMPACT.reach);
      const left = taken ? Math.min(radiance, COMPACT.brightness * mean) : radiance;
      directions.push(...towards);
      all.push(radiance);
      excess.push(...rgb.map((value) => (value * (left - threshold) * solid) / radiance));
    }
  }
  return directions.length ? gathered(spotsOf({ kind, least: kind.heart * mean }, directions, excess, all), Math.min(height, CELLS)) : null;
}

function spotsOf(given: Pick<Spots, "kind" | "least">, directions: ArrayLike<number>, excess: ArrayLike<number>, radiance: ArrayLike<number>): Spots {
  const flux = Float64Array.from(radiance, (_, k) => (excess[3 * k]! + excess[3 * k + 1]! + excess[3 * k + 2]!) / 3);
  const { kind, least } = given;
  return { kind, least, directions: Float64Array.from(directions), excess: Float64Array.from(excess), flux, radiance: Float64Array.from(radiance) };
}

/** The same with all that is in a cell of a picture of so many rows as one. */
function gathered(spots: Spots, rows: number): Spots {
  const { directions, excess, flux, radiance } = spots;
  const cells = new Map<number, { towards: number[]; excess: number[]; weighted: number; flux: number }>();
  for (let k = 0; k < flux.length; k++) {
    const [x, y, z] = [directions[3 * k]!, directions[3 * k + 1]!, directions[3 * k + 2]!];
    const row = Math.min(Math.max(Math.floor((0.5 + Math.asin(Math.min(Math.max(z, -1), 1)) / Math.PI) * rows), 0), rows - 1);
    const column = Math.floor((0.5 - Math.atan2(y, x) / (2 * Math.PI)) * 2 * rows) % (2 * rows), key = 2 * rows * row + column;
    const cell = cells.get(key) ?? { towards: [0, 0, 0], excess: [0, 0, 0], weighted: 0, flux: 0 };
    cells.set(key, cell);
    cell.weighted += radiance[k]! * flux[k]!;
    cell.flux += flux[k]!;
    for (let c = 0; c < 3; c++) {
      cell.towards[c]! += directions[3 * k + c]! * flux[k]!;
      cell.excess[c]! += excess[3 * k + c]!;
    }
  }
  const sorted = [...cells].sort(([a], [b]) => a - b).map(([, cell]) => cell);
  const weighted = sorted.map((cell) => cell.weighted / cell.flux);
  return spotsOf(spots, sorted.flatMap(({ towards }) => unit(towards)), sorted.flatMap((cell) => cell.excess), weighted);
}

/** Middles of spots, one by one, each where most light is left. */
function seedsOf(spots: Spots, most: number): Vector3[] {
  const { kind, least, directions, flux, radiance } = gathered(spots, COARSE_CELLS), left = flux.slice(), seeds: Vector3[] = [];
  const at = (k: number): Vector3 => [directions[3 * k]!, directions[3 * k + 1]!, directions[3 * k + 2]!];
  const around = (middle: Vector3) => left.map((value, k) => (cosine(directions, k, middle) >= kind.reach ? value : 0));
  while (seeds.length < most && left.some((value) => value > 0)) {
    let best = 0, brightest = -1;
    for (let k = 0; k < left.length; k++) {
      const sum = around(at(k)).reduce((total, value) => total + value, 0);
      if (sum > brightest) [best, brightest] = [k, sum];
    }
    const its = around(at(best)), seed = mean(directions, its);
    const light = its.reduce((sum, value) => sum + value, 0), weighted = its.reduce((sum, value, k) => sum + value * radiance[k]!, 0);
    if (weighted >= least * light) seeds.push(seed);
    left.forEach((_, k) => (left[k] = cosine(directions, k, seed) >= kind.reach ? 0 : left[k]!));
  }
  return seeds;
}

/** A lamp more near each seed. */
function withLamps(before: Taken, spots: Spots, seeds: readonly Vector3[]): Taken {
  let middles = seeds;
  for (let step = 0; step < REFINEMENTS; step++) {
    const owners = ownersOf(spots, middles);
    middles = middles.map((_, number) => mean(spots.directions, spots.flux.map((flux, k) => (owners[k] === number ? flux : 0))));
  }
  const owners = ownersOf(spots, middles), light: [number, number, number] = [...before.light];
  const lamps = middles.map((direction, number) => {
    const its = spots.flux.map((flux, k) => (owners[k] === number ? flux : 0));
    its.forEach((flux, k) => [0, 1, 2].forEach((c) => (light[c]! += flux > 0 ? spots.excess[3 * k + c]! : 0)));
    return { direction, irradiance: its.reduce((sum, flux) => sum + flux, 0), radius: radiusOf(direction, spots.directions, its) };
  });
  return { lamps: [...before.lamps, ...lamps], light };
}

/** The nearest middle of each spot, -1 where none is near. */
function ownersOf({ kind, directions, flux }: Spots, middles: readonly Vector3[]): Int32Array {
  return Int32Array.from(flux, (_, k) => {
    const cosines = middles.map((middle) => cosine(directions, k, middle)), nearest = Math.max(...cosines);
    return nearest >= kind.reach ? cosines.indexOf(nearest) : -1;
  });
}

/** Of a disc whose light is as far from its middle: the mean of angle^2 / 2 is R^2 / 4. */
function radiusOf(middle: Vector3, directions: Float64Array, flux: Float64Array): number {
  let spread = 0, whole = 0;
  flux.forEach((value, k) => {
    whole += value;
    spread += value * (1 - cosine(directions, k, middle));
  });
  return 2 * Math.sqrt(Math.max(spread / whole, 0));
}

function cosine(directions: Float64Array, k: number, [x, y, z]: Vector3): number {
  return directions[3 * k]! * x + directions[3 * k + 1]! * y + directions[3 * k + 2]! * z;
}

function mean(directions: Float64Array, weights: Float64Array): Vector3 {
  const sum = [0, 0, 0];
  weights.forEach((weight, k) => [0, 1, 2].forEach((c) => (sum[c]! += weight * directions[3 * k + c]!)));
  return unit(sum);
}

function unit(v: readonly number[]): Vector3 {
  const length = Math.hypot(...v);
  return v.map((value) => value / length) as unknown as Vector3;
}
