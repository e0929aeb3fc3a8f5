// Textures: 256x256 gray levels that repeat.

import { Random } from "./random.js";

/** The number of units in a pixel: positions are counted in sixteenths. */
export const PIXEL = 16;

/** Random gray levels `coarse` pixels apart, with as many again `fine` pixels apart, and what lies between them blended. */
export function texture(seed, coarse, fine, darkest, brightest) {
  const random = new Random(seed);
  const grid = () => Uint8Array.from({ length: 65536 }, () => random.next());
  const [first, second] = [grid(), grid()];
  const at = (levels, place, cell) => sample(levels, ((place & 255) * PIXEL) / cell, ((place >> 8) * PIXEL) / cell);
  return Uint8Array.from({ length: 65536 }, (_, place) => {
    const average = (at(first, place, coarse) + at(second, place, fine)) >> 1;
    return darkest + (((brightest - darkest) * average) >> 16);
  });
}

/** Blends the four pixels around the position, in 256ths of a gray level. It is called for every pixel, so it makes no arrays. */
export function sample(levels, x, y) {
  const column = (x >> 4) & 255;
  const next = (column + 1) & 255;
  const row = ((y >> 4) & 255) << 8;
  const below = (row + 256) & 65535;
  const right = x & 15;
  const low = y & 15;
  const upper = levels[row | column] * (PIXEL - right) + levels[row | next] * right;
  const lower = levels[below | column] * (PIXEL - right) + levels[below | next] * right;
  return upper * (PIXEL - low) + lower * low;
}
