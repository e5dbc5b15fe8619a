// SPDX-License-Identifier: MIT
// OpenEXR pictures (.exr), read by three.js' loader.

import type { Picture } from "@prt-relight/core";
import { FloatType } from "three";
import { EXRLoader } from "three/examples/jsm/loaders/EXRLoader.js";

/** Reads a picture; throws an Error whose message is a sentence for people. Texels that are no numbers are black. */
export function readExr(bytes: Uint8Array): Picture {
  if (bytes[0] !== 0x76 || bytes[1] !== 0x2f || bytes[2] !== 0x31 || bytes[3] !== 0x01) throw new Error("The file is no OpenEXR picture.");
  const { width, height, data } = decoded(bytes), channels = data.length / (width * height), pixels = new Float32Array(3 * width * height);
  for (let y = 0, k = 0; y < height; y++) {
    const row = channels * width * (height - 1 - y); // the loader gives the lowest row first
    for (let x = 0; x < width; x++) {
      for (let c = 0; c < 3; c++, k++) {
        const value = data[row + channels * x + Math.min(c, channels - 1)]!;
        pixels[k] = Number.isFinite(value) ? value : 0;
      }
    }
  }
  return { width, height, pixels };
}

const ZEROS = 1024; // behind the file: the loader looks for the zeros that end names, and for ever in a file that ends within one

function decoded(bytes: Uint8Array): { width: number; height: number; data: Float32Array } {
  const ended = new Uint8Array(bytes.length + ZEROS);
  ended.set(bytes);
  try {
    return new EXRLoader().setDataType(FloatType).parse(ended.buffer) as unknown as ReturnType<typeof decoded>;
  } catch {
    throw new Error("It is broken, or packed in a way that cannot be read here.");
  }
}
