// SPDX-License-Identifier: MIT
// Radiance pictures (.hdr), read: RGBE, flat or with run lengths (Ward, "Real Pixels", Graphics Gems II, 1991).

import type { Picture } from "./sky.js";

const MOST_PIXELS = 1 << 26; // 8192 x 8192: more is a broken header

/** Reads a picture; throws an Error whose message is a sentence for people. */
export function readRadiance(bytes: Uint8Array): Picture {
  const { width, height, start } = readHeader(bytes);
  const pixels = new Float32Array(3 * width * height), row = new Uint8Array(4 * width);
  let at = start;
  for (let y = 0; y < height; y++) {
    at = readRow(bytes, at, row);
    decodeRow(row, pixels, 3 * y * width);
  }
  return { width, height, pixels };
}

function readHeader(bytes: Uint8Array): { width: number; height: number; start: number } {
  let at = 0;
  const line = () => {
    const end = bytes.indexOf(10, at);
    if (end < 0 || end - at > 4096) throw new Error("The file ends within its header: it is no whole .hdr picture.");
    const text = String.fromCharCode(...bytes.subarray(at, end));
    at = end + 1;
    return text.trimEnd();
  };
  if (bytes[0] !== 35 || bytes[1] !== 63 || !line().startsWith("#?")) {
    throw new Error("The file is no Radiance picture (.hdr).");
  }
  for (let text = line(); text; text = line()) {
    if (text.startsWith("FORMAT=") && text !== "FORMAT=32-bit_rle_rgbe") {
      throw new Error(`The picture's format is ${text.slice(7)}: only 32-bit_rle_rgbe can be read.`);
    }
  }
  const size = line(), found = /^-Y (\d+) \+X (\d+)$/.exec(size);
  if (!found) throw new Error(`The picture's size, "${size}", cannot be read: rows must go down, and columns right.`);
  const height = Number(found[1]), width = Number(found[2]);
  if (!width || !height || width * height > MOST_PIXELS) throw new Error(`The picture has an impossible size: ${size}.`);
  return { width, height, start: at };
}

function readRow(bytes: Uint8Array, at: number, row: Uint8Array): number {
  const width = row.length / 4;
  const packed = bytes[at] === 2 && bytes[at + 1] === 2 && ((bytes[at + 2]! << 8) | bytes[at + 3]!) === width;
  if (packed && width >= 8 && width < 32768) return readPackedRow(bytes, at + 4, row);
  if (at + row.length > bytes.length) throw new Error("The picture ends too early: the file is broken.");
  row.set(bytes.subarray(at, at + row.length));
  return at + row.length;
}

function readPackedRow(bytes: Uint8Array, start: number, row: Uint8Array): number {
  const width = row.length / 4;
  let at = start;
  for (let channel = 0; channel < 4; channel++) {
    for (let x = 0; x < width; ) {
      const code = bytes[at++], repeated = code !== undefined && code > 128;
      const count = repeated ? code - 128 : (code ?? 0);
      if (!count || x + count > width || at + (repeated ? 1 : count) > bytes.length) {
        throw new Error("The picture's run lengths do not fit its width: the file is broken, or ends too early.");
      }
      for (let n = 0; n < count; n++) row[4 * x++ + channel] = bytes[repeated ? at : at + n]!;
      at += repeated ? 1 : count;
    }
  }
  return at;
}

function decodeRow(row: Uint8Array, pixels: Float32Array, first: number): void {
  for (let k = 0, out = first; k < row.length; k += 4, out += 3) {
    const scale = row[k + 3] ? 2 ** (row[k + 3]! - 136) : 0;
    pixels[out] = row[k]! * scale;
    pixels[out + 1] = row[k + 1]! * scale;
    pixels[out + 2] = row[k + 2]! * scale;
  }
}
