// The library's memory is bounded: it grows neither with updates nor with trackers that were freed.

import assert from "node:assert/strict";
import { test } from "node:test";
import { setFlagsFromString } from "node:v8";
import { runInNewContext } from "node:vm";
import { Memory } from "../memory.js";
import { SmrError } from "../smr.js";
import { frames, libraries, random } from "./library.mjs";

const UPDATES = { paper: 98_000, robust: 2_000 };
const { simd } = await libraries();

test("100,000 updates take no memory", () => {
  const shown = [...frames({ width: 96, height: 80, side: 12, speed: [1, 1] })];
  const grown = Object.entries(UPDATES).map(([method, count]) => {
    const tracker = simd[method](method === "paper" ? { window: [4, 4] } : { reach: 4 });
    tracker.lock(shown[0], shown[0].box);
    tracker.update(shown[1]);
    const before = simd.memory;
    for (let at = 0; at < count; at++) {
      tracker.update(shown[at % shown.length]);
    }
    tracker.free();
    return simd.memory - before;
  });
  assert.deepEqual(grown, [0, 0]);
});

test("locks, saved targets and freed trackers take no memory", () => {
  const [first, second] = frames();
  const cycle = () => {
    const trackers = [simd.paper(), simd.robust(), simd.paper()];
    for (const tracker of trackers) {
      tracker.record(() => {});
      tracker.lock(first, first.box);
      tracker.update(second);
      tracker.restore(tracker.save());
    }
    trackers.forEach((tracker) => tracker.free());
    assert.throws(() => simd.paper({ k: [1, 0] }));
  };
  cycle();
  const before = simd.memory;
  for (let at = 0; at < 100; at++) {
    cycle();
  }
  assert.equal(simd.memory, before);
});

test("the memory of trackers that nobody has comes back", async () => {
  setFlagsFromString("--expose-gc");
  const { simd } = await libraries();
  const forget = async () => {
    Array.from({ length: 100 }, () => simd.robust().record(() => {}));
    runInNewContext("gc")();
    await new Promise((done) => setTimeout(done, 50));
    return simd.memory;
  };
  const before = await forget();
  await forget();
  // The last tracker may remain in memory, because the stack may still reference it.
  assert.ok((await forget()) - before <= 3 * 65_536);
});

test("a call that is refused takes no memory", async () => {
  const { simd } = await libraries();
  const [frame] = frames();
  const [paper, robust] = [simd.paper(), simd.robust()];
  const large = new Uint8Array(4_000_000);
  const whole = { data: large, width: 2000, height: 2000 };
  const starts = (head) => {
    const bytes = large.slice();
    bytes.set(head);
    return bytes;
  };
  const [before, calls] = [simd.memory, [
    () => robust.restore(large),
    () => robust.restore(starts([83, 77, 82])), // "SMR"
    () => paper.lock(whole, { x: 0, y: 0, width: 2000, height: 2000 }),
    () => robust.update(whole),
  ]];
  calls.forEach((call) => assert.throws(call, SmrError));
  assert.equal(simd.memory, before);
  // Bytes that begin like a saved target take at most as much memory as the largest saved target.
  robust.lock(frame, frame.box);
  const head = robust.save().subarray(0, 14);
  for (const bytes of [starts(head), starts([...head.subarray(0, 13), 1])]) {
    assert.throws(() => robust.restore(bytes), SmrError);
  }
  assert.ok(simd.memory - before <= 3 * 65_536, `${simd.memory - before} bytes`);
});

test("many targets take their storage only", () => {
  const before = simd.memory;
  const trackers = Array.from({ length: 100 }, () => simd.robust());
  const grown = simd.memory - before;
  assert.ok(grown > 0 && grown <= 100 * 12_408 + 2 * 65_536, `${grown} bytes`);
  trackers.forEach((tracker) => tracker.free());
});

test("blocks do not overlap, and their memory comes back", () => {
  const numbers = random(5);
  const wasm = new WebAssembly.Memory({ initial: 1 });
  const memory = new Memory(wasm, 1003);
  const taken = new Map();
  for (let step = 0; step < 20_000; step++) {
    if (numbers.below(2) === 0 && taken.size < 40) {
      const size = numbers.below(3000);
      const at = memory.take(size);
      assert.equal(at % 8, 0);
      assert.ok(at >= 1003 && at + size <= memory.bytes.length);
      memory.bytes.fill(step & 255, at, at + size);
      taken.set(at, { size, mark: step & 255 });
    } else if (taken.size > 0) {
      const at = numbers.of([...taken.keys()]);
      const { size, mark } = taken.get(at);
      assert.ok(memory.copy(at, size).every((byte) => byte === mark), "another block has written here");
      memory.give(at);
      taken.delete(at);
    }
  }
  assert.ok(memory.bytes.length <= 4 * 65_536, `${memory.bytes.length} bytes`);
  taken.forEach((_, at) => memory.give(at));
  const whole = memory.bytes.length - 1008;
  memory.give(memory.take(whole));
  assert.equal(memory.bytes.length - 1008, whole, "all of it is one block again");
});

test("memory that is not there is an error", () => {
  const memory = new Memory(new WebAssembly.Memory({ initial: 1, maximum: 2 }), 0);
  assert.throws(() => memory.take(3 * 65_536), /^RangeError: no memory for 196608 bytes$/);
  memory.give(memory.take(2 * 65_536));
});
