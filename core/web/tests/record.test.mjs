// The flight recorder: what it refuses, and several of them on one tracker.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Recorder } from "../record.js";
import { frames, libraries } from "./library.mjs";

const { simd: smr } = await libraries();
const [first, second] = frames();

test("wrong numbers of bytes are refused, and nothing is recorded", () => {
  const tracker = smr.paper();
  tracker.lock(first, first.box);
  for (const bytes of [null, "x", "8", {}, [], true, 10n, Symbol("x")]) {
    assert.throws(() => new Recorder(tracker, { bytes }), { name: "TypeError", message: /^bytes must be a number, not / });
  }
  for (const bytes of [NaN, Infinity, -Infinity, -1, 0, 0.5, 1e300]) {
    assert.throws(() => new Recorder(tracker, { bytes }), { name: "RangeError", message: /^bytes must be a whole number from 1 to / });
  }
  for (const take of [undefined, null, 5, {}]) {
    assert.throws(() => tracker.record(take), { name: "TypeError", message: /^take must be a function, not / });
  }
  tracker.update(second);
});

test("every recorder of a tracker records, until it is stopped itself", () => {
  const tracker = smr.robust();
  const recorders = [new Recorder(tracker), new Recorder(tracker), new Recorder(tracker)];
  const lengths = () => recorders.map((recorder) => recorder.bytes().length);
  tracker.lock(first, first.box);
  tracker.update(second);
  assert.deepEqual(recorders[1].bytes(), recorders[0].bytes());
  assert.deepEqual(recorders[2].bytes(), recorders[0].bytes());
  let before = lengths();
  recorders[0].stop();
  recorders[0].stop();
  tracker.update(first);
  assert.deepEqual(lengths().map((length, at) => length > before[at]), [false, true, true]);
  recorders[2].stop();
  before = lengths();
  tracker.update(second);
  assert.deepEqual(lengths().map((length, at) => length > before[at]), [false, true, false]);
  tracker.free();
  recorders[1].stop();
});
