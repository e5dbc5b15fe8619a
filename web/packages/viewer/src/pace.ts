// SPDX-License-Identifier: MIT
// How finely frames of a movement are drawn: as finely as the machine keeps up with. What rests is always drawn finely.

export interface Quality {
  /** Of the screen's pixels, along each side. */
  readonly scale: number;
  /** Samples a pixel. */
  readonly samples: number;
  /** Whether meshes are coarse, and mirror the sky at their vertices. */
  readonly coarse: boolean;
  /** Whether the sky is smoothed by cubic splines, which costs four looks for one. */
  readonly smoothSky: boolean;
}

export const FINEST: Quality = { scale: 1, samples: 4, coarse: false, smoothSky: true };

const moving = (coarse: boolean) => (scale: number): Quality => ({ scale, samples: 1, coarse, smoothSky: false });
const QUALITIES: readonly Quality[] = [FINEST, ...[1, 0.7, 0.5].map(moving(false)), ...[0.5, 0.31].map(moving(true))];
const SLOW = 40, QUICK = 20; // milliseconds a frame
const STEP = 2; // by what about the next quality is quicker
const SLOW_FRAMES = 3, QUICK_FRAMES = 60; // in a row, before anything changes
const TRIES = 2; // of a quality that has been too slow: something else may have kept the machine busy

export class Pace {
  private level: number;
  private taken: number[] = [];
  private readonly failures = QUALITIES.map(() => 0);

  /** Begins with the coarsest where there is no graphics card. */
  constructor(inSoftware: boolean) {
    this.level = inSoftware ? QUALITIES.length - 1 : 0;
  }

  get moving(): Quality { return QUALITIES[this.level]!; }

  /** Takes note of how many milliseconds a frame of a movement has taken. */
  note(milliseconds: number): void {
    this.taken.push(milliseconds);
    const last = this.taken.slice(-SLOW_FRAMES), quickest = Math.min(...last);
    if (last.length === SLOW_FRAMES && quickest > SLOW) this.drop(Math.ceil(Math.log(quickest / SLOW) / Math.log(STEP)));
    else if (this.taken.length >= QUICK_FRAMES) this.rise();
  }

  private drop(levels: number): void {
    this.failures[this.level]!++;
    this.level = Math.min(this.level + levels, QUALITIES.length - 1);
    this.taken = [];
  }

  private rise(): void {
    const quick = Math.max(...this.taken) < QUICK && this.level > 0 && this.failures[this.level - 1]! < TRIES;
    if (quick) this.level--;
    this.taken = [];
  }
}
