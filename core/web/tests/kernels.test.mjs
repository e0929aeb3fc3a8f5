// SIMD128 gives the same integers as the plain loops, for boxes 1 to 80 pixels wide and thresholds from 0 to 255. In
// the module built by `.ci/web all`, every kernel also compares itself with its plain loop.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { frames, libraries, random } from "./library.mjs";

const SIDES = Array.from({ length: 80 }, (_, number) => number + 1);
const PIXELS = 4096;
const FRAMES = 4;

function noisy(frame, numbers, most) {
  return { ...frame, data: frame.data.map((level) => Math.min(255, Math.max(0, level + numbers.below(2 * most + 1) - most))) };
}

function* cases() {
  const numbers = random(99);
  for (const side of SIDES) {
    const down = Math.max(1, Math.min(numbers.below(80) + 1, Math.floor(PIXELS / side)));
    const most = numbers.of([0, 3, 20, 120]);
    const options = {
      paper: { window: [numbers.below(12), numbers.below(12)], leastThreshold: numbers.of([0, 10, 30, 60, 120, 255]) },
      robust: { reach: 4 + numbers.below(5) },
    };
    const shown = [...frames({ width: 200, height: 180, side, down, speed: [1, 1], count: FRAMES, seed: side })];
    yield { options, frames: shown.map((frame) => noisy(frame, numbers, most)), name: `${side}x${down}` };
  }
}

/** Tracks all frames. Returns the answers, with `work` set to 0, and the target as saved after the last frame. */
function follow(smr, method, { options, frames: [first, ...others] }, more = {}) {
  const tracker = smr[method]({ ...options[method], ...more });
  tracker.lock(first, first.box);
  const answers = others.map((frame) => ({ ...tracker.update(frame), work: 0 }));
  const saved = tracker.save();
  tracker.free();
  return { answers, saved };
}

const { plain, simd } = await libraries();
for (const method of ["paper", "robust"]) {
  test(`${method}: SIMD128 and the plain module are equal`, () => {
    for (const one of cases()) {
      const expected = follow(plain, method, one);
      assert.deepEqual(follow(simd, method, one), expected, `SIMD128, ${one.name}`);
    }
  });

  test(`${method}: the plain loop of the module with SIMD128 is equal`, () => {
    for (const one of [...cases()].filter((_, number) => number % 8 === 0)) {
      assert.deepEqual(follow(simd, method, one, { plainLoop: true }), follow(simd, method, one), one.name);
    }
  });
}

const file = process.env.SMR_CHECK;
const skip = file === undefined && "no module that checks its kernels: run .ci/web all";
test("the kernels equal the plain loops", { skip }, async () => {
  const { exports } = await WebAssembly.instantiate(await WebAssembly.compile(readFileSync(file)));
  assert.equal(exports.smr_simd(), 1);
  exports.smr_check_kernels();
});
