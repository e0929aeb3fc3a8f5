// A drawn clip of 30 seconds whose truth is known: the target passes behind a pillar, sinks into fog, leaves the picture
// and comes back elsewhere.

import { random } from "./library.mjs";

export const FRAMES = 750;
export const RATE = 25;
export const SIZE = { width: 160, height: 120 };
const [WIDE, HIGH] = [24, 28];
const PILLAR = { from: 66, to: 98 }; // columns
/** Frames in which the target is behind the pillar, in fog, and away. */
export const HIDDEN = [165, 185], FOG = [350, 410], GONE = [560, 620];

// The left edge and the top of the target's box: it crosses the picture, comes back, leaves it, and appears at another place.
function placeIn(frame) {
  if (frame < 300) {
    return [6 + (frame * 110) / 300, 40 + 8 * Math.sin(frame / 90)];
  }
  if (frame < GONE[0]) {
    return [116 - ((frame - 300) * 152) / 280, 39 + 6 * Math.sin((frame - 300) / 60)];
  }
  return [20 + ((frame - GONE[1]) * 40) / 130, 70 + 8 * Math.sin(frame / 30)];
}

/** Returns the target's box in frame `number`, from 1; null where it is hidden, or half of it is not in the picture. */
export function truthIn(number) {
  const isIn = ([from, to]) => from <= number && number <= to;
  const [x, y] = placeIn(number);
  return isIn(HIDDEN) || isIn(GONE) || x < -WIDE / 2 ? null : { x: Math.round(x), y: Math.round(y), width: WIDE, height: HIGH };
}

/** Returns the clip as Y4M. */
export function clip() {
  const numbers = random(7);
  const blocks = (across, down, from, to) => Array.from({ length: across * down }, () => from + numbers.below(to - from));
  const [ground, target] = [blocks(20, 15, 60, 150), blocks(6, 7, 0, 255)];
  const frames = Array.from({ length: FRAMES }, (_, at) => {
    const number = at + 1;
    const [left, top] = placeIn(number).map(Math.round);
    const isGone = GONE[0] <= number && number <= GONE[1];
    const inFog = FOG[0] <= number && number <= FOG[1];
    const pixels = Buffer.alloc(SIZE.width * SIZE.height);
    for (let y = 0; y < SIZE.height; y++) {
      for (let x = 0; x < SIZE.width; x++) {
        const [across, down] = [x - left, y - top];
        const isTarget = !isGone && across >= 0 && across < WIDE && down >= 0 && down < HIGH;
        let level = ground[Math.floor(y / 8) * 20 + Math.floor(x / 8)];
        if (isTarget) {
          const own = target[Math.floor(down / 4) * 6 + Math.floor(across / 4)];
          level = inFog ? level + Math.round((own - level) / 12) : own;
        }
        if (x >= PILLAR.from && x < PILLAR.to && number < 300) {
          level = 30 + (x % 4);
        }
        pixels[y * SIZE.width + x] = Math.min(Math.max(level + numbers.below(5) - 2, 0), 255);
      }
    }
    return Buffer.concat([Buffer.from("FRAME\n"), pixels]);
  });
  return Buffer.concat([Buffer.from(`YUV4MPEG2 W${SIZE.width} H${SIZE.height} F${RATE}:1 Ip A1:1 Cmono\n`), ...frames]);
}
