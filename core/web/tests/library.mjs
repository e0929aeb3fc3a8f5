// Where the tests find the package that `.ci/web` has built, and both of its modules.

import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { load } from "../smr.js";

/** The folder of the package, and that of the project. */
export const PACKAGE = new URL(`${process.env.SMR_WEB ?? "../../../target/web"}/`, import.meta.url);
export const PROJECT = fileURLToPath(new URL("../../../", import.meta.url));

/** The library from each module, by name. */
export async function libraries() {
  const library = (name) => load(readFileSync(new URL(name, PACKAGE)));
  return { plain: await library("smr.wasm"), simd: await library("smr-simd.wasm") };
}

/** Numbers that look random and are the same in every run: xorshift, 32 bits. */
export function random(seed) {
  let state = seed >>> 0 || 1;
  const next = () => {
    state ^= state << 13;
    state ^= state >>> 17;
    state = (state ^ (state << 5)) >>> 0;
    return state;
  };
  return { next, below: (most) => next() % most, bytes: (count) => Uint8Array.from({ length: count }, () => next() >>> 24) };
}

/** Frames of a textured square that moves over a textured background: { data, width, height, box }. */
export function* frames({ width = 160, height = 120, side = 24, count = 20, seed = 7 } = {}) {
  const { bytes } = random(seed);
  const background = bytes(width * height).map((byte) => 64 + byte / 4);
  // Blocks of 4x4 pixels: the robust tracker looks at means.
  const blocks = bytes(side * side);
  const target = blocks.map((_, at) => blocks[(Math.floor(at / side / 4) * side) / 4 + ((at % side) >> 2)]);
  for (let at = 0; at < count; at++) {
    const box = { x: Math.floor(width / 4) + 2 * at, y: Math.floor(height / 4) + at, width: side, height: side };
    const data = background.slice();
    for (let row = 0; row < side; row++) {
      data.set(target.subarray(row * side, (row + 1) * side), (box.y + row) * width + box.x);
    }
    yield { data, width, height, box };
  }
}
