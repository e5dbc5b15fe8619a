// SPDX-License-Identifier: MIT
// Lamps in a picture of the sky, taken out as in Blender (core/sky/lamps.py): what bright spots exceed their surroundings by.

import { type Lamps, lightOfLamps, NO_LAMPS } from "./lamps.js";
import type { Vector3 } from "./matrix.js";
import { type Picture, projected } from "./sky.js";
import { MEASURED_ORDER, truncation } from "./truncation.js";

const BRIGHT = 10; // times the mean radiance, from which on a texel belongs to a spot
const REACH = Math.cos((12 * Math.PI) / 180); // cosine of how far a spot goes from its middle
const CELLS = 512, COARSE_CELLS = 64; // rows of cells in which lamps are looked for, and their seeds
const REFINEMENTS = 8;
const WORTH_IT = 0.9; // what another lamp must leave of the truncation at most

/** Texels, or cells of them: directions and excess light, three numbers each. */
interface Spots {
  readonly directions: Float64Array;
  readonly excess: Float64Array;
  readonly flux: Float64Array;
}

/**
 * Takes so many lamps out of a sky at most, the brightest first; no more than bring its truncation under `enough`, or, with 0, as many
 * as there are.
 */
export function findLamps(picture: Picture, most: number, enough = 0): Lamps {
  const spots = most > 0 ? brightTexels(picture) : null;
  if (!spots) return NO_LAMPS;
  const seeds = seedsOf(spots, most), found = (count: number) => lampsNear(spots, seeds.slice(0, count));
  return enough > 0 ? fewest(picture, seeds.length, found, enough) : found(seeds.length);
}

/** The fewest lamps whose truncation is low enough, or not to be improved. */
function fewest(picture: Picture, most: number, found: (count: number) => Lamps, enough: number): Lamps {
  const sky = projected(picture, MEASURED_ORDER, false);
  let best = NO_LAMPS, least = truncation(sky);
  for (let count = 1; count <= most && least > enough; count++) {
    const lamps = found(count), taken = lightOfLamps(lamps, MEASURED_ORDER);
    const loss = truncation(sky.map((value, k) => value - taken[k]!), sky);
    if (loss < WORTH_IT * least) [best, least] = [lamps, loss];
  }
  return best;
}

function brightTexels({ width, height, pixels }: Picture): Spots | null {
  const edge = (y: number) => Math.sin(Math.PI * (0.5 - y / height)), angle = (y: number) => ((edge(y) - edge(y + 1)) * 2 * Math.PI) / width;
  let whole = 0;
  for (let y = 0; y < height; y++) {
    let sum = 0;
    for (let k = 3 * y * width; k < 3 * (y + 1) * width; k++) sum += Math.max(pixels[k]!, 0);
    whole += (angle(y) * sum) / 3;
  }
  const threshold = (BRIGHT * whole) / (4 * Math.PI), directions: number[] = [], excess: number[] = [];
  for (let y = 0, k = 0; y < height; y++) {
    const elevation = Math.PI * (0.5 - (y + 0.5) / height), ring = Math.cos(elevation), solid = angle(y);
    for (let x = 0; x < width; x++, k += 3) {
      if ((pixels[k]! + pixels[k + 1]! + pixels[k + 2]!) / 3 <= threshold) continue;
      const rgb = [0, 1, 2].map((c) => Math.max(pixels[k + c]!, 0)), share = 1 - (3 * threshold) / (rgb[0]! + rgb[1]! + rgb[2]!);
      const azimuth = 2 * Math.PI * (0.5 - (x + 0.5) / width);
      directions.push(ring * Math.cos(azimuth), ring * Math.sin(azimuth), Math.sin(elevation));
      excess.push(...rgb.map((value) => value * share * solid));
    }
  }
  return directions.length ? gathered(spotsOf(directions, excess), Math.min(height, CELLS)) : null;
}

function spotsOf(directions: ArrayLike<number>, excess: ArrayLike<number>): Spots {
  const flux = Float64Array.from({ length: excess.length / 3 }, (_, k) => (excess[3 * k]! + excess[3 * k + 1]! + excess[3 * k + 2]!) / 3);
  return { directions: Float64Array.from(directions), excess: Float64Array.from(excess), flux };
}

/** The same with all that is in a cell of a picture of so many rows as one. */
function gathered({ directions, excess, flux }: Spots, rows: number): Spots {
  const cells = new Map<number, { towards: number[]; excess: number[] }>();
  for (let k = 0; k < flux.length; k++) {
    const [x, y, z] = [directions[3 * k]!, directions[3 * k + 1]!, directions[3 * k + 2]!];
    const row = Math.min(Math.max(Math.floor((0.5 + Math.asin(Math.min(Math.max(z, -1), 1)) / Math.PI) * rows), 0), rows - 1);
    const column = Math.floor((0.5 - Math.atan2(y, x) / (2 * Math.PI)) * 2 * rows) % (2 * rows), key = 2 * rows * row + column;
    const cell = cells.get(key) ?? { towards: [0, 0, 0], excess: [0, 0, 0] };
    cells.set(key, cell);
    for (let c = 0; c < 3; c++) {
      cell.towards[c]! += directions[3 * k + c]! * flux[k]!;
      cell.excess[c]! += excess[3 * k + c]!;
    }
  }
  const sorted = [...cells].sort(([a], [b]) => a - b).map(([, cell]) => cell);
  return spotsOf(sorted.flatMap(({ towards }) => unit(towards)), sorted.flatMap((cell) => cell.excess));
}

/** Middles of spots, one by one, each where most light is left. */
function seedsOf(spots: Spots, most: number): Vector3[] {
  const { directions, flux } = gathered(spots, COARSE_CELLS), left = flux.slice(), seeds: Vector3[] = [];
  const at = (k: number): Vector3 => [directions[3 * k]!, directions[3 * k + 1]!, directions[3 * k + 2]!];
  const around = (middle: Vector3) => left.map((value, k) => (cosine(directions, k, middle) >= REACH ? value : 0));
  while (seeds.length < most && left.some((value) => value > 0)) {
    let best = 0, brightest = -1;
    for (let k = 0; k < left.length; k++) {
      const sum = around(at(k)).reduce((total, value) => total + value, 0);
      if (sum > brightest) [best, brightest] = [k, sum];
    }
    const seed = mean(directions, around(at(best)));
    seeds.push(seed);
    left.forEach((_, k) => (left[k] = cosine(directions, k, seed) >= REACH ? 0 : left[k]!));
  }
  return seeds;
}

/** A lamp near each seed. */
function lampsNear(spots: Spots, seeds: readonly Vector3[]): Lamps {
  let middles = seeds;
  for (let step = 0; step < REFINEMENTS; step++) {
    const owners = ownersOf(spots, middles);
    middles = middles.map((_, number) => mean(spots.directions, spots.flux.map((flux, k) => (owners[k] === number ? flux : 0))));
  }
  const owners = ownersOf(spots, middles), taken: [number, number, number] = [0, 0, 0];
  const lamps = middles.map((direction, number) => {
    let irradiance = 0, spread = 0;
    owners.forEach((owner, k) => {
      if (owner !== number) return;
      irradiance += spots.flux[k]!;
      spread += spots.flux[k]! * (1 - cosine(spots.directions, k, direction));
      for (let c = 0; c < 3; c++) taken[c]! += spots.excess[3 * k + c]!;
    });
    return { direction, irradiance, radius: 2 * Math.sqrt(Math.max(spread / irradiance, 0)) }; // a disc's mean of angle^2 / 2 is R^2 / 4
  });
  const whole = (taken[0] + taken[1] + taken[2]) / 3;
  return { lamps, colour: taken.map((value) => value / whole) as unknown as Vector3 };
}

/** The nearest middle of each spot, -1 where none is near. */
function ownersOf({ directions, flux }: Spots, middles: readonly Vector3[]): Int32Array {
  return Int32Array.from(flux, (_, k) => {
    const cosines = middles.map((middle) => cosine(directions, k, middle)), nearest = Math.max(...cosines);
    return nearest >= REACH ? cosines.indexOf(nearest) : -1;
  });
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
