// A film of the head that follows, as raw RGB images of 162x182 pixels on standard output: above the camera's picture with its
// centre; then the pulses of pan and tilt, from 900 to 2100 microseconds; below the target's distance from the centre in the
// last seconds, right in red and down in blue, between lines at 10 pixels. SMR_PICO is the firmware's ELF.

import { writeSync } from "node:fs";
import { HEIGHT, WIDTH } from "./camera.mjs";
import { Rig } from "./rig.mjs";
import { swing } from "./scene.mjs";

const SECONDS = 8;
/** Frames of the camera for an image of the film. */
const EVERY = 6;
const [BARS, GRAPH] = [16, 44];
const FILM_HEIGHT = HEIGHT + BARS + GRAPH;
const LARGEST = 14; // pixels in the graph
const [RED, BLUE, GREEN, DARK, LIGHT] = [[230, 70, 60], [70, 130, 240], [90, 220, 110], [24, 24, 28], [90, 90, 96]];

class Picture {
  constructor() {
    this.bytes = Buffer.alloc(WIDTH * FILM_HEIGHT * 3, Uint8Array.from(DARK));
  }

  dot(x, y, color) {
    if (x >= 0 && x < WIDTH && y >= 0 && y < FILM_HEIGHT) this.bytes.set(color, (Math.round(y) * WIDTH + Math.round(x)) * 3);
  }

  line(y, color, from = 0, to = WIDTH) {
    for (let x = from; x < to; x++) this.dot(x, y, color);
  }
}

function image({ frames, led }) {
  const picture = new Picture();
  const { pixels, pan, tilt } = frames[frames.length - 1];
  for (let at = 0; at < pixels.length; at++) picture.bytes.fill(pixels[at] & 0xf0, at * 3, at * 3 + 3);
  for (let arm = 3; arm < 9; arm++) {
    for (const side of [-arm, arm]) {
      picture.dot(WIDTH / 2 + side, HEIGHT / 2, led ? GREEN : RED);
      picture.dot(WIDTH / 2, HEIGHT / 2 + side, led ? GREEN : RED);
    }
  }
  for (const [number, microseconds] of [pan, tilt].entries()) {
    const [middle, x] = [WIDTH / 2, ((microseconds - 900) / 1200) * WIDTH];
    for (let row = 0; row < 4; row++) {
      picture.line(HEIGHT + 3 + number * 6 + row, [RED, BLUE][number], Math.round(Math.min(middle, x)), Math.round(Math.max(middle, x)) + 1);
    }
  }
  const level = (error) => HEIGHT + BARS + GRAPH / 2 + (Math.max(-LARGEST, Math.min(LARGEST, error)) * (GRAPH / 2 - 1)) / LARGEST;
  for (const error of [-10, 0, 10]) picture.line(level(error), LIGHT);
  frames.slice(-WIDTH * 3).filter((_, number) => number % 3 === 0).forEach(({ error }, x) => {
    picture.dot(x, level(error.x), RED);
    picture.dot(x, level(error.y), BLUE);
  });
  return picture.bytes;
}

const rig = new Rig(process.env.SMR_PICO, (seconds) => swing(Math.max(0, seconds - 0.5)));
rig.untilFrame(3);
rig.press(true);
rig.untilFrame(8);
rig.press(false);
for (let frame = 12; rig.board.seconds < SECONDS; frame += EVERY) {
  rig.untilFrame(frame);
  writeSync(1, image(rig));
}
