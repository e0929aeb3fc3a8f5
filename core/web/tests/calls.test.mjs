// Calls with invalid arguments throw an error with the reason and change nothing. One tracker can have several flight
// recorders.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { runInNewContext } from "node:vm";
import { Recorder } from "../record.js";
import { POOR_QUALITY, SmrError, State, Tracker, load } from "../smr.js";
import { PACKAGE, colored, frames, libraries, random } from "./library.mjs";

const { simd: smr } = await libraries();
const [first, second, third] = frames();
const { width, height, data, box } = first;

function locked(method = "paper", options = {}) {
  const tracker = smr[method](options);
  tracker.lock(first, box);
  return tracker;
}

/** Returns a frame whose buffer was transferred to another thread. */
function detached() {
  const bytes = data.slice();
  structuredClone(bytes.buffer, { transfer: [bytes.buffer] });
  return { data: bytes, width, height };
}

const NUMBERS = [undefined, null, NaN, Infinity, -Infinity, 0.5, "8", {}, [], true, 10n, Symbol("x"), 1e300];
const FRAMES = [
  undefined, null, 5, "frame", {}, [], true, () => 1, data,
  ...[undefined, null, [1, 2, 3], "x", new Uint16Array(width * height), new DataView(new ArrayBuffer(8)), data.buffer].map((data) => ({ data, width, height })),
  ...NUMBERS.flatMap((wrong) => [{ data, width: wrong, height }, { data, width, height: wrong }]),
  ...NUMBERS.filter((wrong) => wrong !== undefined).map((stride) => ({ data, width, height, stride })),
  ...[-1, 0, 65536].flatMap((wrong) => [{ data, width: wrong, height }, { data, width, height: wrong }]),
  { data, width, height, stride: width - 1 }, { data, width, height, stride: 0 }, { data, width, height, stride: -width },
  { data: data.subarray(1), width, height }, { data: new Uint8Array(0), width, height }, { data, width: 65535, height: 65535 },
  { data, width, height, format: "bgr" }, { data, width, height, format: "rgba" }, { data, width, height, format: Symbol("x") },
  { data: new Uint8ClampedArray(width * height), width, height },
  // Frames whose byte count or stride shows that the format is wrong: colors or 16-bit pixels passed as 8-bit gray, and
  // pixels that do not have 4 bytes, such as gray ones, passed as RGBA.
  ...[2, 3, 4].flatMap((bytes) => [undefined, "gray"].map((format) => ({ data: new Uint8Array(bytes * width * height), width, height, format }))),
  { data: new Uint8Array(4 * width * height), width, height, stride: 4 * width }, { data: new Uint8Array(4 * width * height), width, height, stride: width },
  ...[1, 2, 3, 8, 12, 16].map((bytes) => ({ data: new Uint8ClampedArray(bytes * width * height), width, height })),
];
const BOXES = [
  undefined, null, 5, "box", {}, [20, 20, 8, 8],
  ...["x", "y", "width", "height"].flatMap((side) => NUMBERS.filter((wrong) => wrong !== 0.5).map((wrong) => ({ ...box, [side]: wrong }))),
  { ...box, width: 0 }, { ...box, height: 0 }, { ...box, width: -8 }, { ...box, x: -1 }, { ...box, x: width }, { ...box, y: height - 1 },
  { ...box, width: 65535 }, { ...box, width: 65536 }, { ...box, x: 2 ** 31 }, { ...box, y: -(2 ** 31) },
];
const OPTIONS = [
  null, 5, "options", { reach: 8 }, { window: 16 }, { window: [16] }, { window: [1, 2, 3] }, { window: [NaN, 1] }, { window: "16,16" }, { padding: -1 },
  { padding: 65536 }, { firstThreshold: 256 }, { firstThreshold: 0 }, { k: [0, 1] }, { k: [1, 0] }, { k: 0.25 }, { scale: 255 },
  { preset: "robust" }, { preset: 5 }, { preset: Symbol("x") }, { preset: null }, { windowLimit: [1, 1] },
  { runnerUpAlways: 2 }, { runnerUpAlways: "yes" }, { updateZone: [1, 2, 3] }, { constructor: 5 }, { __proto__: null, toString: 1 }, { gateLost: [1, 0] },
];
const ROBUST_OPTIONS = [{ window: [16, 16] }, { reach: 3 }, { reach: 9 }, { lostBelow: 40_000 }, { size: 2 }, { learningRate: 257 }, { earlyRate: 1025 }, { preset: "camera" },
  { preset: "small", reach: 8 }];

function* damaged(saved, numbers) {
  yield* [undefined, null, 5, "saved", {}, [...saved], saved.buffer, new Uint8Array(0), new Uint8ClampedArray(saved)];
  for (;;) {
    const bytes = saved.slice(0, numbers.below(2) === 0 ? saved.length : numbers.below(saved.length));
    if (bytes.length === saved.length) {
      bytes[numbers.below(bytes.length)] ^= 1 << numbers.below(8);
    }
    yield bytes;
  }
}

/** Fails unless `call` throws one of the library's own errors, with its own message. */
function refused(call, what) {
  let error;
  assert.throws(call, (thrown) => ((error = thrown), true), `${what} is accepted`);
  const kind = error instanceof SmrError || error instanceof TypeError || error instanceof RangeError;
  assert.ok(kind && !/^Cannot|undefined \(|is not a function|iterable|Invalid typed/.test(error.message), `${what}: ${error.stack}`);
  if (error instanceof SmrError) {
    assert.match(error.status, /^SMR_ERROR_[A-Z_]+$/, what);
    assert.doesNotMatch(error.message, /SMR_/, `${what} has words`);
  }
}

test("1000 wrong calls of each tracker are refused and change nothing", (context) => {
  for (const method of ["paper", "robust"]) {
    const numbers = random(17);
    const tracker = locked(method);
    tracker.update(second);
    const [saved, answer, before] = [tracker.save(), tracker.answer, smr.memory];
    const bytes = damaged(saved, numbers);
    const others = [{ data, width: width - 1, height }, { data, width, height: height - 1 }, { data, width: 8, height: 8 }];
    const calls = {
      lock: (frame) => tracker.lock(frame, box),
      box: (wrong) => tracker.lock(first, wrong),
      update: (frame) => tracker.update(frame),
      size: (frame) => tracker.update(frame),
      right: (wrong) => tracker.moved(wrong, 0),
      down: (wrong) => tracker.moved(0, wrong),
      restore: (wrong) => tracker.restore(wrong),
      options: (wrong) => smr[method](wrong),
    };
    const wrong = {
      lock: () => numbers.of([...FRAMES, detached()]),
      box: () => numbers.of(BOXES),
      update: () => numbers.of([...FRAMES, detached()]),
      size: () => numbers.of(others),
      right: () => numbers.of(NUMBERS),
      down: () => numbers.of(NUMBERS),
      restore: () => bytes.next().value,
      options: () => (method === "paper" ? numbers.of(OPTIONS) : numbers.of(ROBUST_OPTIONS)),
    };
    let count = 0;
    while (count < 1000) {
      for (const [name, call] of Object.entries(calls)) {
        const value = wrong[name]();
        refused(() => call(value), `${method}, ${name}: ${shown(value)}`);
        count += 1;
      }
    }
    assert.deepEqual(tracker.save(), saved, `${method}: the target has changed`);
    assert.equal(tracker.answer, answer);
    const free = smr.memory - before;
    assert.ok(free <= 65_536, `${method}: ${free} bytes are lost`);
    assert.equal(tracker.update(third).state, State.TRACKING);
    tracker.free();
    context.diagnostic(`${method}: ${count} calls`);
  }
});

function shown(value) {
  const text = (_, part) => (ArrayBuffer.isView(part) ? `${part.length} bytes` : typeof part === "symbol" || typeof part === "bigint" ? String(part) : part);
  return typeof value === "object" ? JSON.stringify(value, text) : String(value);
}

test("the words are those of the library", () => {
  const paper = smr.paper();
  const said = (call) => {
    try {
      call();
    } catch (error) {
      return [error.name, error.status, error.message];
    }
  };
  assert.deepEqual(said(() => paper.update(first)), ["SmrError", "SMR_ERROR_NOT_LOCKED", "there is no target yet: lock first"]);
  assert.deepEqual(said(() => paper.lock(first, { ...box, width: 0 })), [
    "SmrError", "SMR_ERROR_BOX_EMPTY", "the box has no pixels: width and height must be at least 1",
  ]);
  assert.deepEqual(said(() => paper.lock({ data: new Uint8Array(90_000), width: 300, height: 300 }, { x: 0, y: 0, width: 300, height: 300 })), [
    "SmrError", "SMR_ERROR_BOX_TOO_LARGE", "the box has more pixels than this tracker's template has room for",
  ]);
  assert.deepEqual(said(() => smr.robust().lock(first, { ...box, y: NaN })), [
    "RangeError", undefined, "the box's y must be a whole number from -2147483647 to 2147483647, not NaN",
  ]);
  assert.deepEqual(said(() => smr.paper({ windw: 1 }))?.slice(0, 2), ["TypeError", undefined]);
  assert.deepEqual(said(() => new Tracker()), ["TypeError", undefined, "make a tracker with paper() or robust() of what load() returns"]);
});

test("fractions of a box are rounded", () => {
  const [own, other] = [locked(), smr.paper()];
  const { x, y, width, height } = box;
  other.lock(first, Object.create({ x: x + 0.49, y: y - 0.5, width: width - 0.3, height: height + 0.25 }));
  assert.deepEqual(other.save(), own.save());
});

test("a freed tracker refuses every call, and can be freed again", () => {
  const tracker = locked();
  const saved = tracker.save();
  tracker.free();
  tracker[Symbol.dispose]();
  const calls = [
    () => tracker.lock(first, box), () => tracker.update(first), () => tracker.moved(0, 0), () => tracker.save(), () => tracker.restore(saved),
    () => tracker.window, () => tracker.sweepWindow, () => tracker.quality, () => tracker.last, () => tracker.template,
    () => tracker.responseMap(first), () => tracker.record(() => {}), () => tracker.beginRecord(),
  ];
  for (const call of calls) {
    assert.throws(call, { name: "SmrError", status: "SMR_ERROR_NOT_INITIALISED", message: "the tracker was freed" });
  }
});

test("a saved target of the other tracker or of other options is refused", () => {
  const [paper, robust] = [locked("paper"), locked("robust")];
  const refusal = (setting) => ({
    status: "SMR_ERROR_OTHER_CONFIG", message: `the target was saved with another configuration: ${setting} differs`,
  });
  assert.throws(() => paper.restore(robust.save()), { status: "SMR_ERROR_OTHER_METHOD" });
  assert.throws(() => robust.restore(paper.save()), { status: "SMR_ERROR_OTHER_METHOD" });
  assert.throws(() => smr.robust({ reach: 7 }).restore(robust.save()), refusal("reach"));
  assert.throws(() => smr.robust({ preset: "robust" }).restore(robust.save()), refusal("refiner"));
  assert.throws(() => smr.robust({ preset: "smallRefined" }).restore(robust.save()), { status: "SMR_ERROR_OTHER_METHOD" });
});

test("each option has its place", () => {
  const given = {
    paper: {
      plainLoop: true, k: [1, 2], firstThreshold: 3, leastThreshold: 4, padding: 5, window: [6, 7], growth: 8, windowLimit: [9, 10], neighbourhood: 11,
      updateZone: [12, 13, 14, 15], gateTracking: [16, 17], gateLeaving: [18, 19], gateReturning: [20, 21], gateLost: [22, 23], gateLead: 24,
      leastRatio: 25, runnerUpAlways: true,
    },
    robust: {
      plainLoop: true, reach: 5, size: false, sweep: 2, refiner: false, patience: 6, lostBelow: 700, uncertainBelow: 800, learningRate: 90, earlyRate: 100,
    },
  };
  for (const [method, options] of Object.entries(given)) {
    const tracker = smr[method]({ ...options, growth: undefined, ...options });
    assert.deepEqual(tracker.options, options);
    tracker.free();
  }
  assert.equal(smr.paper({ preset: "camera" }).options.leastThreshold, 10);
  assert.equal(smr.paper({ preset: "paper" }).options.leastThreshold, 0);
  const robust = [undefined, "robust", "small", "smallRefined"].map((preset) => smr.robust({ preset }));
  assert.deepEqual(robust.map(({ preset, options }) => [preset, options.refiner, options.reach]), [
    ["refined", true, 8], ["robust", false, 8], ["small", false, 7], ["smallRefined", true, 7],
  ]);
  robust.forEach((tracker) => tracker.free());
});

test("a tracker tells what it knows", () => {
  for (const method of ["paper", "robust"]) {
    const tracker = smr[method]();
    const nothing = [tracker.answer, tracker.window, tracker.sweepWindow, tracker.quality, tracker.last, tracker.template];
    assert.deepEqual(nothing, [null, null, null, null, null, null]);
    const quality = tracker.lock(first, box);
    assert.ok(quality > POOR_QUALITY && quality === tracker.quality);
    assert.deepEqual(tracker.last.state, State.TRACKING);
    assert.equal(tracker.answer, null);
    const answer = tracker.update(second);
    assert.deepEqual(answer.box, second.box);
    assert.equal(tracker.answer, answer);
    assert.deepEqual(tracker.last.fineBox, answer.fineBox);
    assert.ok(answer.work > 0);
    tracker.moved(256 * 5, 0);
    assert.equal(tracker.answer, answer);
  }
});

test("arrays of another realm are arrays", async () => {
  const [own, foreign] = [locked(), locked()];
  const other = (bytes, kind = "Uint8Array") => runInNewContext(`new ${kind}(bytes)`, { bytes });
  assert.deepEqual(foreign.update({ ...second, data: other(second.data) }), own.update(second));
  const color = colored(third);
  assert.deepEqual(foreign.update({ ...color, data: other(color.data, "Uint8ClampedArray") }), own.update(color));
  foreign.restore(other(own.save()));
  assert.deepEqual(foreign.save(), own.save());
  const bytes = readFileSync(join(PACKAGE, "smr.wasm"));
  for (const kind of ["Uint8Array(bytes)", "Uint8Array(bytes).buffer", "WebAssembly.Module(bytes)"]) {
    assert.equal((await load(runInNewContext(`new ${kind}`, { bytes }))).simd, false, kind);
  }
});

test("rows may have gaps between them", () => {
  const [gapless, gaps] = [locked(), locked()];
  const stride = width + 7;
  const spread = new Uint8Array(stride * height).fill(255);
  for (let row = 0; row < height; row++) {
    spread.set(second.data.subarray(row * width, (row + 1) * width), row * stride);
  }
  assert.deepEqual(gaps.update({ data: spread, width, height, stride }), gapless.update(second));
});

test("the response map has its peak where the target is", () => {
  const tracker = locked("robust", { reach: 6 });
  const { span, responses } = tracker.responseMap(first);
  assert.equal(span, 13);
  assert.equal(responses.length, span * span);
  assert.equal(responses.indexOf(Math.max(...responses)), (span * span - 1) / 2);
  const answer = tracker.update(second);
  assert.deepEqual(answer, { ...locked("robust", { reach: 6 }).update(second) });
  assert.throws(() => locked("paper").responseMap(first), { status: "SMR_ERROR_OTHER_METHOD" });
});

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

/** Wraps an object as stores do: what it returns is wrapped as well. */
function deepProxy(of) {
  const wrapped = (value) => (typeof value === "object" && value !== null ? deepProxy(value) : value);
  return new Proxy(of, { get: (target, key, receiver) => wrapped(Reflect.get(target, key, receiver)) });
}

test("every method and getter refuses a Proxy, with what to do, and changes nothing", async () => {
  const library = await load(readFileSync(join(PACKAGE, "smr.wasm")));
  const tracker = library.robust();
  tracker.lock(first, box);
  const objects = { library, tracker, recorder: new Recorder(tracker) };
  const values = [first, box];
  const before = [tracker.save(), objects.recorder.bytes(), library.memory];
  for (const [name, object] of Object.entries(objects)) {
    const { constructor } = object;
    const members = Reflect.ownKeys(constructor.prototype).filter((key) => key !== "constructor" && key !== Symbol.toStringTag);
    assert.ok(members.length >= 2, name);
    const words = new RegExp(`^[\\w.()]+ needs the ${name} itself, not a Proxy of it: .*\\bshallowRef\\b.*\\bmarkRaw\\b|^Symbol`);
    for (const proxy of [new Proxy(object, {}), deepProxy(object), new Proxy(new Proxy(object, {}), {}), Object.create(object)]) {
      for (const member of members) {
        const { get } = Object.getOwnPropertyDescriptor(constructor.prototype, member);
        const call = () => (get ? proxy[member] : proxy[member](...values));
        assert.throws(call, { name: "TypeError", message: words }, `${name} ${String(member)}`);
      }
    }
    for (const member of members.filter((member) => typeof member === "string")) {
      const { get, value } = Object.getOwnPropertyDescriptor(constructor.prototype, member);
      assert.throws(() => (get ?? value).call(undefined, ...values), { name: "TypeError", message: new RegExp(`^${member}.* needs its ${name}: call it as a method`) });
    }
    // Vue makes a Proxy of what has the tag of a plain object.
    assert.notEqual(Object.prototype.toString.call(object), "[object Object]");
  }
  assert.throws(() => new Recorder(new Proxy(tracker, {})), { name: "TypeError", message: /the tracker itself/ });
  assert.deepEqual([tracker.save(), objects.recorder.bytes(), library.memory], before);
  assert.deepEqual(tracker.update(second).box, second.box);
  // A box may be a Proxy, and a frame whose bytes are none.
  tracker.lock(new Proxy({ ...first }, {}), deepProxy(box));
});
