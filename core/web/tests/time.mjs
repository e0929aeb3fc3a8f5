// Times updates of 640x480 frames by both modules: node core/web/tests/time.mjs. Prints the median in microseconds.

import { frames, libraries, random } from "./library.mjs";

const ROUNDS = 10;
const COUNT = 40;

/** The frames as a camera sends them, with noise in each: gray, or colors. */
function recording(side, isColor) {
  const { next } = random(3);
  return [...frames({ width: 640, height: 480, side, count: COUNT })].map(({ data, box, width, height }) => {
    const noisy = data.map((level) => Math.min(255, Math.max(0, level + (next() % 7) - 3)));
    const rgba = () => Uint8ClampedArray.from({ length: 4 * noisy.length }, (_, at) => noisy[at >> 2]);
    return { data: isColor ? rgba() : noisy, width, height, box };
  });
}

function median(times) {
  return times.sort((a, b) => a - b)[times.length >> 1];
}

/** Median time of an update in microseconds, and how often the target was tracked. */
function time(tracker, frames) {
  const times = [];
  let tracked = 0;
  for (let round = 0; round < ROUNDS; round++) {
    tracker.lock(frames[0], frames[0].box);
    for (const frame of frames.slice(1)) {
      const start = performance.now();
      const { state } = tracker.update(frame);
      times.push(1000 * (performance.now() - start));
      tracked += state === "tracking";
    }
  }
  const micros = median(times).toFixed(0).padStart(6);
  return `${micros} us, tracked in ${((100 * tracked) / times.length).toFixed(0)} %`;
}

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
