// SPDX-License-Identifier: MIT
// One sentence for the person, which goes again by itself.

const SECONDS = 9;
let timer = 0;

/** Says a sentence, or, if it is empty, takes the last one away; one that stays is for what cannot be mended. */
export function say(sentence: string, stays = false): void {
  const place = document.getElementById("message")!;
  place.textContent = sentence;
  place.hidden = !sentence;
  clearTimeout(timer);
  if (sentence && !stays) timer = window.setTimeout(() => (place.hidden = true), 1000 * SECONDS);
}
