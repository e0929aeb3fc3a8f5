// Both modules give the answers of the conformance vectors, number by number (tests/vectors/README.md). After every frame a second tracker, which
// is restored from the saved bytes of the first, gives them too.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { PROJECT, libraries } from "./library.mjs";

const NUMBERS = {
  k: 2, first_threshold: 1, least_threshold: 1, padding: 1, window: 2, growth: 1, window_limit: 2, neighbourhood: 1, update_zone: 4,
  gate_tracking: 2, gate_leaving: 2, gate_returning: 2, gate_lost: 2, gate_lead: 1, gate_least_ratio: 1, runner_up_always: 1, reach: 1,
  size_part: 1, sweep: 1, refiner: 1, patience: 1, lost_below: 1, uncertain_below: 1, learning_rate: 1, early_rate: 1,
};
const OPTIONS = { gate_least_ratio: "leastRatio", size_part: "size" };

const camel = (name) => name.replace(/_(.)/g, (_, letter) => letter.toUpperCase());
const hash = (bytes) => bytes.reduce((sum, byte) => Math.imul(sum ^ byte, 0x01000193) >>> 0, 0x811c9dc5).toString(16).padStart(8, "0");

function pixels(hex) {
  return Uint8Array.from(Buffer.from(hex, "hex"));
}

const VECTORS = {
  paper: {
    files: { "conformance.txt": 61 },
    preset: { preset: "paper" },
    // Without the peak, which the C interface does not give.
    expected: ([x, y, state, ratio, runnerUp, alpha, , , , , asked, template]) => [
      +x, +y, state, +ratio, asked === "1" ? +runnerUp : null, +alpha, template,
    ],
    answered: ({ box, state, ratio, runnerUpRatio, alpha }, tracker) => [
      box.x, box.y, state, ratio, runnerUpRatio, alpha, hash(tracker.template.pixels),
    ],
  },
  robust: {
    // Cases name the refiner only if it is on.
    files: { "robust.txt": 85, "refiner.txt": 15 },
    preset: { preset: "robust" },
    // Without the response and the weights, which the C interface does not give. All later answers depend on them.
    expected: ([x, y, width, height, state, confidence, ratio, , scale, found, template]) => [
      +x, +y, +width, +height, state, +confidence, +ratio, +scale, found === "1", template,
    ],
    answered: ({ fineBox: { x, y, width, height }, state, confidence, ratio, scale, foundAgain }, tracker) => [
      x, y, width, height, state, confidence, ratio, scale, foundAgain, hash(tracker.template.pixels),
    ],
  },
};

/** Follows all targets of a file of vectors. Returns the number of answers. */
function follow(smr, method, file) {
  const { preset, expected, answered } = VECTORS[method];
  const lines = readFileSync(join(PROJECT, "tests/vectors", file), "utf8").split("\n");
  let [name, options, skipped, size, trackers, answers] = ["", {}, false, [], [], 0];
  const all = (call) => trackers.map(call);
  for (const line of lines.filter((line) => line !== "" && !line.startsWith("#"))) {
    const [keyword, ...values] = line.split(" ");
    const frame = () => ({ data: pixels(values.at(-1)), width: size[0], height: size[1] });
    if (keyword === "case") {
      [name, options, skipped] = [line, { ...preset }, false];
    } else if (skipped || keyword === "scale") {
      skipped ||= values[0] !== "255"; // only Rust has another table
    } else if (keyword === "size") {
      size = values.map(Number);
    } else if (keyword === "lock") {
      all((tracker) => tracker.free());
      trackers = [smr[method](options), smr[method](options)];
      const [x, y, width, height] = values.map(Number);
      trackers[0].lock(frame(), { x, y, width, height });
      trackers[1].restore(trackers[0].save());
    } else if (keyword === "frame") {
      all((tracker) => tracker.update(frame()));
    } else if (keyword === "answer") {
      answers += 1;
      all((tracker) => assert.deepEqual(answered(tracker.answer, tracker), expected(values), `${name}, answer ${answers}`));
      trackers[1].restore(trackers[0].save());
    } else if (keyword in NUMBERS) {
      const numbers = values.map(Number);
      assert.equal(numbers.length, NUMBERS[keyword], line);
      options[OPTIONS[keyword] ?? camel(keyword)] = numbers.length === 1 ? numbers[0] : numbers;
    } else {
      assert.match(keyword, /^smr-(robust-)?vectors$/);
    }
  }
  all((tracker) => tracker.free());
  return answers;
}

for (const [name, smr] of Object.entries(await libraries())) {
  test(`the ${name} module says what it is`, () => assert.equal(smr.simd, name === "simd"));
  for (const [method, { files }] of Object.entries(VECTORS)) {
    for (const [file, least] of Object.entries(files)) {
      test(`${name}: the ${method} tracker gives the answers of ${file}`, (context) => {
        const answers = follow(smr, method, file);
        context.diagnostic(`${answers} answers`);
        assert.ok(answers >= least);
      });
    }
  }
}
