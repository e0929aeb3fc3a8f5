// Measures updates of 640x480 frames by both WebAssembly modules: node core/web/tests/time.mjs. Prints microseconds:
// the minimum over the rounds' medians, because other programs only add time.

import assert from "node:assert/strict";
import { frames, libraries, random } from "./library.mjs";

const ROUNDS = 10;
const COUNT = 40;

/** Returns frames with noise like a camera's, as gray or as RGBA pixels (with the same gray in red, green and blue). */
function recording(side, isColor) {
  const { next } = random(3);
  return [...frames({ width: 640, height: 480, side, count: COUNT })].map(({ data, box, width, height }) => {
    const noisy = data.map((level) => Math.min(255, Math.max(0, level + (next() % 7) - 3)));
    const rgba = () => Uint8ClampedArray.from({ length: 4 * noisy.length }, (_, at) => noisy[at >> 2]);
    return { data: isColor ? rgba() : noisy, width, height, box };
  });
}

/** Returns the median time of a round's updates in microseconds. After each, the state must be *tracking*. */
function round(tracker, [first, ...others]) {
  tracker.lock(first, first.box);
  const times = others.map((frame) => {
    const start = performance.now();
    const { state } = tracker.update(frame);
    assert.equal(state, "tracking");
    return 1000 * (performance.now() - start);
  });
  return times.sort((a, b) => a - b)[times.length >> 1];
}

const time = (tracker, frames) => `${Math.min(...Array.from({ length: ROUNDS }, () => round(tracker, frames))).toFixed(0).padStart(6)} us`;

for (const [name, smr] of Object.entries(await libraries())) {
  for (const side of [24, 64]) {
    for (const isColor of [false, true]) {
      const shown = recording(side, isColor);
      const how = `${name.padEnd(5)} ${side}x${side} ${isColor ? "RGBA" : "gray"}`;
      console.log(`${how} paper  ${time(smr.paper({ window: [16, 16] }), shown)}`);
      console.log(`${how} robust ${time(smr.robust(), shown)}`);
    }
  }
}
