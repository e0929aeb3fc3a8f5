// Paths of the files built by `.ci/web`, and frames for the tests.

import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { load } from "../smr.js";

export const PROJECT = fileURLToPath(new URL("../../../", import.meta.url));
export const PACKAGE = process.env.SMR_WEB ?? join(PROJECT, "target/web");
export const HOST_SIM = process.env.SMR_HOST_SIM;

/** An expression of a page: the charts that reach beyond the window, and those whose name and value do not fit in a line. */
export const BELOW = `[...document.querySelectorAll("#curves .panel")].filter((panel) => panel.getBoundingClientRect().bottom > innerHeight
  || panel.firstElementChild.scrollWidth > panel.clientWidth || panel.firstElementChild.offsetHeight > 24).map((panel) => panel.textContent)`;
/** An expression of a page: opens the menu of files, and tells if all of it is in the window's width. */
export const MENU_IS_SEEN = `(() => {
  const menu = document.querySelector(".menu");
  menu.open = true;
  const { left, right } = menu.lastElementChild.getBoundingClientRect();
  menu.open = false;
  return left >= 0 && right <= innerWidth;
})()`;
/** An expression of a page: the chosen target is in sight in the list of targets. */
export const CHOSEN_IS_SEEN = `(() => {
  const [list, chosen] = [document.getElementById("targets"), document.querySelector("#targets .chosen")].map((node) => node.getBoundingClientRect());
  return chosen.top >= list.top - 1 && chosen.bottom <= list.bottom + 1;
})()`;

export async function libraries() {
  const library = (name) => load(readFileSync(join(PACKAGE, name)));
  return { plain: await library("smr.wasm"), simd: await library("smr-simd.wasm") };
}

/** Returns the gray pixels of all frames of a recording, converted by host-sim. */
export function converted(recording) {
  const folder = mkdtempSync(join(tmpdir(), "smr-frames-"));
  try {
    const file = join(folder, "frames.raw");
    const { status, stderr, error } = spawnSync(HOST_SIM, ["convert", recording, "--out", file], { encoding: "utf8" });
    if (status !== 0) {
      throw new Error(`host-sim convert ${recording}: ${stderr ?? error}; SMR_HOST_SIM names host-sim`);
    }
    return readFileSync(file);
  } finally {
    rmSync(folder, { recursive: true });
  }
}

export const SYNTHETIC = { width: 160, height: 120, length: 240 };
let synthetic = null;

export function syntheticFrame(index) {
  synthetic ??= converted("synthetic");
  const size = SYNTHETIC.width * SYNTHETIC.height;
  return synthetic.subarray(index * size, (index + 1) * size);
}

/** Returns a seeded generator of random numbers: xorshift, 32 bits. */
export function random(seed) {
  let state = seed >>> 0 || 1;
  const next = () => {
    state ^= state << 13;
    state ^= state >>> 17;
    state = (state ^ (state << 5)) >>> 0;
    return state;
  };
  const below = (most) => next() % most;
  return {
    next,
    below,
    bytes: (count) => Uint8Array.from({ length: count }, () => next() >>> 24),
    of: (values) => values[below(values.length)],
  };
}

/** Returns 4x4-pixel blocks of random grays; single pixels would average out in the means of the robust tracker. */
function blocks(width, height, { bytes }) {
  const across = Math.ceil(width / 4);
  const grays = bytes(across * Math.ceil(height / 4));
  return Uint8Array.from({ length: width * height }, (_, at) => grays[Math.floor(at / width / 4) * across + ((at % width) >> 2)]);
}

/** Yields frames { data, width, height, box } of a textured box, moving by `speed` pixels [right, down] per frame. */
export function* frames({ width = 160, height = 120, side = 24, down = side, speed = [2, 1], count = 20, seed = 7 } = {}) {
  const numbers = random(seed);
  const background = blocks(width, height, numbers).map((level) => 64 + level / 4);
  const target = blocks(side, down, numbers);
  for (let at = 0; at < count; at++) {
    const box = { x: Math.floor(width / 4) + speed[0] * at, y: Math.floor(height / 4) + speed[1] * at, width: side, height: down };
    const data = background.slice();
    for (let row = 0; row < down; row++) {
      data.set(target.subarray(row * side, (row + 1) * side), (box.y + row) * width + box.x);
    }
    yield { data, width, height, box };
  }
}

/** Returns a gray frame as RGBA with made-up colors; converted back, most pixels differ from the original gray. */
export function colored({ data, width, height, box }) {
  const channel = (level, at) => [level, 255 - level, (level * 7 + at) & 255, at & 255];
  return { data: Uint8ClampedArray.from({ length: 4 * data.length }, (_, at) => channel(data[at >> 2], at >> 2)[at & 3]), width, height, box };
}
