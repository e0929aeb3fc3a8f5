// Both WebAssembly modules (plain and SIMD) reproduce the answers and bytes of the flight records in tests/vectors.
// After every frame, a second tracker, restored from the saved bytes of the first, must give the same answer.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { Recorder } from "../record.js";
import { State } from "../smr.js";
import { PROJECT, libraries } from "./library.mjs";

// Options of the paper tracker (P) and of the robust one (R, or S of the small size), in the order of the flight record. Each value is the
// count of 16-bit numbers in that option.
const ROBUST = { size: 1, sweep: 1, parts: 4, reach: 1, patience: 1, lostBelow: 1, uncertainBelow: 1, learningRate: 1, earlyRate: 1, refiner: 1 };
const OPTIONS = {
  P: {
    k: 2, gateTracking: 2, gateLeaving: 2, gateReturning: 2, gateLost: 2, gateLead: 1, leastRatio: 1, firstThreshold: 1, leastThreshold: 1, padding: 1,
    window: 2, growth: 1, windowLimit: 2, neighbourhood: 1, runnerUpAlways: 1, updateZone: 4,
  },
  R: ROBUST,
  S: ROBUST,
};
const PRESETS = { P: "paper", R: "robust", S: "small" };
const FILES = { "paper.smr": 61, "robust.smr": 85, "refined.smr": 15, "small.smr": 85 };
const TABLE = 512;

/** Yields the entries { tag, content } of a flight record. */
function* entries(record) {
  for (let at = 0; at < record.length; ) {
    const length = record.readUInt32LE(at + 8);
    yield { tag: record.toString("latin1", at, at + 4), content: record.subarray(at + 12, at + 12 + length) };
    at += 16 + length;
  }
}

function begun(smr, content) {
  const letter = String.fromCharCode(content[2]);
  const options = { preset: PRESETS[letter] };
  let at = 4 + TABLE;
  for (const [name, count] of Object.entries(OPTIONS[letter])) {
    const numbers = Array.from({ length: count }, (_, i) => (at + 2 * i < content.length ? content.readUInt16LE(at + 2 * i) : 0));
    options[name] = count === 1 ? numbers[0] : numbers;
    at += 2 * count;
  }
  delete options.parts;
  return smr[letter === "P" ? "paper" : "robust"](options);
}

const rect = (content, at) => ({
  x: content.readUInt16LE(at), y: content.readUInt16LE(at + 2), width: content.readUInt16LE(at + 4), height: content.readUInt16LE(at + 6),
});

/** Builds a whole frame, black where the record lacks pixels. */
function frame(content, places) {
  const [width, height] = [content.readUInt16LE(0), content.readUInt16LE(2)];
  const data = new Uint8Array(width * height);
  let at = 20;
  for (const part of places.map((place) => rect(content, place))) {
    for (let row = 0; row < part.height; row++, at += part.width) {
      data.set(content.subarray(at, at + part.width), (part.y + row) * width + part.x);
    }
  }
  return { data, width, height };
}

function answer(content) {
  const [flags, number] = [content[17], (at) => content.readUInt16LE(at)];
  return {
    fineBox: { x: content.readInt32LE(0), y: content.readInt32LE(4), width: content.readUInt32LE(8), height: content.readUInt32LE(12) },
    state: Object.values(State)[content[16]],
    foundAgain: (flags & 1) !== 0,
    confidence: number(18),
    ratio: number(20),
    runnerUpRatio: flags & 2 ? number(22) : null,
    alpha: flags & 4 ? number(24) : null,
    identity: flags & 8 ? number(26) : null,
    scale: content.readUInt32LE(28),
  };
}

function follow(smr, file) {
  const record = readFileSync(join(PROJECT, "tests/vectors", file));
  let [first, second, recorder, answers, recorded] = [null, null, null, 0, []];
  for (const { tag, content } of entries(record)) {
    if (tag === "SMRB") {
      [first, second] = [begun(smr, content), begun(smr, content)];
      recorder = new Recorder(first);
    } else if (tag === "SMRL") {
      first.lock(frame(content, [12]), rect(content, 4));
      second.restore(first.save());
    } else if (tag === "SMRW") {
      [first, second].forEach((tracker) => tracker.update(frame(content, [4, 12])));
    } else if (tag === "SMRA") {
      answers += 1;
      for (const { answer: { box, work, ...given } } of [first, second]) {
        assert.deepEqual(given, answer(content), `answer ${answers}`);
        assert.equal(box.x, Math.floor((given.fineBox.x + 128) / 256));
      }
      second.restore(first.save());
    } else {
      assert.equal(tag, "SMRS");
      assert.deepEqual(Buffer.from(second.save()), content);
      first.restore(Uint8Array.from(content));
      recorded.push(recorder.bytes());
      [first, second].forEach((tracker) => tracker.free());
    }
  }
  assert.ok(Buffer.concat(recorded).equals(record), "the recorder writes other bytes");
  return answers;
}

for (const [name, smr] of Object.entries(await libraries())) {
  test(`the ${name} module says what it is`, () => assert.equal(smr.simd, name === "simd"));
  for (const [file, count] of Object.entries(FILES)) {
    test(`${name}: the answers of ${file}`, () => assert.equal(follow(smr, file), count));
  }
}
