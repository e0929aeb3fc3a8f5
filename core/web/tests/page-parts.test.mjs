// Parts of the stand-alone page that need no browser: the built-in recording, stored answers, files, command lines, and
// the bundler.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { copyWindow, frameOf } from "../frame.js";
import { bundle } from "../page/bundle.mjs";
import { about, instructions } from "../page/cost.js";
import { csv, json } from "../page/rows.js";
import { lengthOf, lineOf, metresOf, movementOf } from "../page/movement.js";
import { initsOf, optionsOf, quoted, typed } from "../page/command.js";
import { scene } from "../page/scene.js";
import { parsed, session } from "../page/session.js";
import { HOST_SIM, PACKAGE, converted } from "./library.mjs";

// Stubs of browser objects that modules use while they are loaded.
globalThis.ResizeObserver = class {};
globalThis.matchMedia = () => ({ addEventListener() {} });
const { BuiltIn } = await import("../page/built-in.js");
const { Target } = await import("../page/following.js");
const { clock, eventsOf, placeOf, sentence } = await import("../page/events.js");
const { spansOf, thinned } = await import("../page/graph.js");
const { sharing } = await import("../page/stage.js");
const { Columns } = await import("../page/timeline.js");

const BOX = { x: 1, y: 2, width: 30, height: 40 };
const FINE = { x: 257, y: 512, width: 7680, height: 10240 };
const ANSWER = {
  box: BOX, fineBox: FINE, state: "tracking", confidence: 65535, ratio: 21845, runnerUpRatio: null, alpha: 10, identity: null, scale: 65536, foundAgain: false,
  work: 9,
};

test("the module draws the built-in recording as host-sim does", { skip: HOST_SIM === undefined && "no host-sim: run .ci/web" }, async () => {
  const streetFrame = await scene(readFileSync(join(PACKAGE, "scene.wasm")));
  const { name, last } = new BuiltIn();
  const expected = converted(name);
  const size = expected.length / last;
  for (const index of [0, 149, 299]) {
    const frame = frameOf(streetFrame(index));
    const gray = Buffer.alloc(size);
    copyWindow(frame, { x: 0, y: 0, width: frame.width, height: frame.height }, gray);
    assert.ok(gray.equals(expected.subarray(index * size, (index + 1) * size)), `frame ${index + 1}`);
  }
});

/** Tracks up to frame `last`; a lock on the box `bad` fails. Returns the steps: "lock 2 3" is a lock and an update. */
function dues(target, last, bad) {
  const seen = [];
  for (let { next } = target; next <= last; { next } = target) {
    const box = target.locks.find(({ number }) => number === next)?.box;
    seen.push(box === undefined ? next : `${box === null ? "gone" : "lock"} ${next}`);
    target.took(next, box === undefined ? { answer: ANSWER } : box === null || box === bad ? {} : { quality: 9 }, Infinity);
  }
  return seen.join(" ");
}

test("a target is followed from its first box, not where it is gone or refused, and anew from a box that changed", () => {
  const [first, second] = [{ number: 2, box: BOX }, { number: 5, box: { ...BOX } }];
  const target = new Target(1, [first, { number: 4, box: null }, second], 0);
  assert.equal(dues(target, 6), "lock 2 3 gone 4 lock 5 6");
  assert.deepEqual([...target.rows.keys()], [2, 3, 5, 6]);
  assert.deepEqual([target.anew([first, second]), target.anew([first]), target.anew([second])], [2, 2, 2]);
  assert.equal(target.anew([...target.locks, { number: 6, box: null }]), 6);
  const later = { number: 9, box: BOX };
  assert.equal(target.anew([...target.locks, later]), Infinity);
  target.locks = [...target.locks, later];
  assert.equal(dues(target, 9), "7 8 lock 9");
  const again = new Target(1, [first, second], 5, target);
  assert.deepEqual([[...again.rows.keys()], dues(again, 7, second.box)], [[2, 3], "lock 5"]);
});

test("rows are those of host-sim", () => {
  const lock = { number: 7, state: "tracking", box: BOX, fineBox: { x: 256, y: 512, width: 7680, height: 10240 }, quality: 65535 };
  const rows = [lock, { number: 8, ...ANSWER }, { number: 9, ...ANSWER, state: "lost", confidence: 0, runnerUpRatio: 32767.5, identity: 49151.25 }];
  const timeOf = (frame) => (frame === 9 ? null : (frame - 1) / 30);
  const head = "frame,time,x,y,width,height,state,confidence,ratio,runner_up_ratio,alpha,identity,scale,work,centre_x,centre_y,speed\n";
  const written = ["7,0.2,1,2,30,40,tracking,,,,,,,,16,22,", "8,0.233333,1.00390625,2,30,40,tracking,1,0.333333,,10,,1,9,16.00390625,22,0.117189", "9,,,,,,lost,0,0.333333,0.5,10,0.75,1,9,,,"];
  assert.equal(csv([["1", rows]], timeOf), head + written.map((row) => `${row}\n`).join(""));
  const both = csv([["1", rows], ["2", rows]], timeOf);
  assert.equal(both, `target,${head}${written.flatMap((row) => [`1,${row}\n`, `2,${row}\n`]).join("")}`);
  const metres = csv([["1", [{ ...lock, fineBox: { x: -3, y: -9, width: 0, height: 0 } }, ...rows.slice(1)]]], timeOf, { pixels_per_metre: 1 }).split("\n");
  assert.equal(metres[0], `${head.trim()},centre_x_m,centre_y_m,speed_m_s`);
  // Halves are rounded away from zero: -3 / 256 is -0.01171875, and -9 / 256 is -0.03515625.
  assert.equal(metres[1], "7,0.2,-0.01171875,-0.03515625,0,0,tracking,,,,,,,,-0.01171875,-0.03515625,,-0.011719,-0.035156,");
  assert.equal(csv([["1", rows]], timeOf, { pixels_per_metre: 2.5 }).split("\n")[2], `${written[1]},6.401563,8.8,0.046875`);
  assert.match(metres[3], /^9,,,,,,lost,.*,,,,,,$/);
  const origin = { version: "0.1.0", method: "paper", options: { config: "camera" } };
  const [locked, , lost] = json([["1", rows]], origin, timeOf).trim().split("\n").map((line) => JSON.parse(line));
  assert.deepEqual(locked, {
    ...origin, frame: 7, time: 0.2, state: "tracking", box: BOX, fine: BOX, confidence: null, ratio: null,
    runner_up_ratio: null, alpha: null, identity: null, scale: null, found_again: null, work: null, quality: 1,
  });
  assert.deepEqual([lost.time, lost.box, lost.fine, lost.found_again, lost.quality], [null, null, null, false, null]);
});

test("a session is read as it was written, and others say why not", () => {
  const recording = { name: "my clip.v2.mp4", width: 100, height: 80 };
  const targets = [{ id: 2, name: "car", locks: [{ number: 1, box: BOX, byHand: true }, { number: 9, box: { ...BOX, x: 70 } }, { number: 12, box: null }], hidden: [[3, 4]] }];
  const using = { method: "robust", options: { set: ["reach=6"] } };
  const length = { pixels_per_metre: 40.5, line: [0, 80, 100, 0] };
  const text = session({ name: recording.name, using, targets, ids: 3, checked: new Map([[2, [[1, 7]]]]), madeBy: "page", length });
  assert.equal(JSON.parse(text).recording, "my clip.v2");
  const read = parsed(text, recording);
  assert.deepEqual([read.using, read.ids, read.madeBy, read.length, read.targets[0].checked, read.targets[0].hidden], [using, 3, "page", length, [[1, 7]], [[3, 4]]]);
  assert.deepEqual(read.targets[0].locks.map(({ number, box, byHand }) => [number, box?.x, byHand ?? false]), [[1, 1, true], [9, 70, false], [12, undefined, false]]);
  for (const other of ["", "frame,x,y", "[1]", "null", "7", "{}"]) {
    assert.equal(parsed(other, recording), null, other);
  }
  const damaged = [["\"smr_session\": 1", "\"smr_session\": 2"], ["\"id\": 2", "\"id\": \"2\""], ["30,", "0,"], ["70,", "71,"], ["\"frame\": 9", "\"frame\": 0.5"], ["\"locks\"", "\"lock\""], ["3,", "9,"], ["80,", "81,"], ["40.5", "0"],
    ["40.5", '"40.5"'], ["7\n", "1e15\n"], ['"ids": 3', '"ids": 1e308'], ['{\n    "set"', 'null, "set2": {\n "set"'], ["reach=6", "reach=6 --out x"], ['"frame": 12', '"frame": 9'], ['"frame": 12', '"frame": 1e9999']];
  for (const [from, to] of damaged) {
    assert.ok(text.includes(from), from);
    assert.throws(() => parsed(text.replace(from, to), recording), /damaged, or of another version/, `${from} ${to}`);
  }
  assert.throws(() => parsed(text, { ...recording, name: "other.mp4" }), /it is of my clip.v2: open that recording first/);
  assert.throws(() => parsed(text.replace("robust", "sad"), recording), /no tracker sad/);
});

test("centre and speed are those of the box that is seen, in pixels or metres, and have no value without a box or a time", () => {
  const at = (x, y) => ({ x, y, width: 4, height: 2 });
  const boxes = [undefined, at(0, 0), at(30, 40), at(30, 40), null, at(0, 0), at(1, 0)];
  const values = (first, length, timeOf = (number) => number / 10) =>
    movementOf(null, "robust", { first, last: 6, boxAt: (number) => boxes[number] ?? null, timeOf, length }).map(({ lines: [{ numbers, values, read }] }) => [numbers[0], ...values.map((value, at) => value && read(at))]);
  const [x, y, speed] = values(2, null);
  assert.deepEqual(x, [1, "2 pixels", "32 pixels", "32 pixels", null, "2 pixels", "3 pixels"]);
  assert.deepEqual(y, [1, "1 pixels", "41 pixels", "41 pixels", null, "1 pixels", "1 pixels"]);
  assert.deepEqual(speed, [1, null, "500 pixels/s", 0, null, null, "10 pixels/s"]);
  const [across, , metres] = values(1, { pixels_per_metre: 20 });
  assert.deepEqual([across.slice(0, 4), metres.slice(0, 4)], [[0, null, "0.1 m", "1.6 m"], [0, null, null, "25 m/s"]]);
  assert.deepEqual(values(1, null, () => null)[2], [0, null, null, null, null, null, null, null]);
  const [{ least, most }, , { least: zero, title }] = movementOf(null, "robust", { first: 2, last: 3, boxAt: (number) => boxes[number], timeOf: () => null, length: null });
  assert.deepEqual([least < 2 && least > -2, most > 32 && most < 36, zero, title], [true, true, 0, "Speed: no times"]);
});

test("a line has the length that is typed, with a point or a comma; nonsense, nothing and less are no length", () => {
  const line = { x: 10, y: 50, width: 300, height: -40 };
  const length = lengthOf(line, " 2,5 ");
  assert.deepEqual(length, { pixels_per_metre: 121.062, line: [10, 50, 310, 10] });
  assert.deepEqual([lineOf(length), metresOf(length), metresOf(null), lineOf({ pixels_per_metre: 9, line: null })], [line, "2.5", "", null]);
  for (const text of ["", "0", "0.0", "-2", "two", "2.5 km", "1.000,5", "NaN", "Infinity", "1e-9", "1e99"]) {
    assert.equal(lengthOf(line, text), null, text);
  }
});

test("options and names are those of a shell", () => {
  assert.deepEqual(["a-b/c.mp4", "it's a car.mp4", "-x"].map(quoted), ["a-b/c.mp4", "'it'\\''s a car.mp4'", "'-x'"]);
  const settings = { paper: { config: "paper" }, robust: { reach: 6, size: false, sweep: 0, refiner: false } };
  assert.deepEqual(optionsOf("paper", settings), {});
  assert.deepEqual(typed(optionsOf("robust", settings)), ["--set reach=6", "--set size=off", "--set sweep=0", "--set refiner=off"]);
  const one = { name: "1", locks: [{ number: 1, box: BOX }, { number: 9, box: null }] };
  assert.deepEqual(initsOf([one]), ["--init 1,2,30,40", "--init gone@9"]);
  assert.deepEqual(initsOf([one, { name: "2", locks: [{ number: 3, box: BOX }] }]), ["--init 1=1,2,30,40", "--init 1=gone@9", "--init 2=1,2,30,40@3"]);
});

test("instructions are about what was measured", () => {
  const said = (method, answer) => Object.values(instructions(method, answer)).map(about);
  assert.deepEqual(said("robust", { work: 4_325_579 }), ["about 4.7 M", "about 1.4 M"]);
  assert.deepEqual(said("paper", { work: 57_019, runnerUpRatio: null }), ["about 180 k", "about 91 k"]);
  assert.deepEqual(said("paper", { work: 931_000, runnerUpRatio: 9 }), ["about 5.6 M", "about 2.9 M"]);
  assert.deepEqual(said("paper", {}), ["–", "–"]);
});

test("events: losses end by being found or by a correction, and doubts that last count", () => {
  const rows = (...spans) => spans.flatMap(([state, count]) => Array(count).fill(state)).map((state, at) => ({ number: at + 1, state }));
  const told = (rows, ...locks) => eventsOf(rows, locks.map((number) => ({ number }))).map(({ kind, frame, until }) => `${kind} ${frame}-${until}`);
  assert.deepEqual(told(rows(["tracking", 5], ["lost", 3], ["tracking", 2], ["lost", 4]), 1), ["locked 1-1", "lost 6-8", "found 9-9", "lost 11-14"]);
  assert.deepEqual(told(rows(["tracking", 5], ["lost", 3], ["tracking", 2]), 1, 9), ["locked 1-1", "lost 6-8", "corrected 9-9"]);
  assert.deepEqual(told(rows(["tracking", 2], ["uncertain", 9], ["leaving", 10], ["lost", 1], ["uncertain", 10]), 1), [
    "locked 1-1", "leaving 12-21", "lost 22-22", "found 23-23", "uncertain 23-32",
  ]);
  assert.deepEqual(told(rows(["tracking", 4]), 1, 3), ["locked 1-1", "corrected 3-3"]);
  assert.deepEqual(told([]), []);
});

test("times are minutes and seconds, and frames where none is known", () => {
  assert.deepEqual([0, 12.4, 59.96, 3723.42].map(clock), ["0:00.0", "0:12.4", "1:00.0", "1:02:03.4"]);
  const timeOf = (frame) => (frame === 311 ? 12.4 : null);
  assert.deepEqual([placeOf(311, timeOf), placeOf(312, timeOf), placeOf(311)], ["0:12.4 (frame 311)", "frame 312", "frame 311"]);
  const lost = { kind: "lost", frame: 311, until: 320 };
  assert.deepEqual([sentence(lost, timeOf), sentence({ ...lost, name: "SMR" })], ["lost at 0:12.4", "SMR lost at frame 311"]);
});

test("the slider has the worst state of each column, and looks at a long video in turns", () => {
  const lost = new Set([1, 150_000, 200_000]);
  const states = (frame) => (lost.has(frame) ? "lost" : frame > 190_000 ? undefined : "tracking");
  const columns = new Columns(400, 1, 200_000);
  assert.deepEqual([columns.frames(0), columns.frames(399)], [[1, 500], [199_501, 200_000]]);
  assert.deepEqual([columns.sample(states).states[0], columns.states[299]], ["lost", "tracking"]);
  let turns = 0;
  for (let seen = 0; seen < 400; turns++) {
    seen += columns.refresh(states, 10_000);
  }
  assert.equal(turns, 20);
  assert.deepEqual([0, 1, 299, 390, 399].map((at) => columns.states[at]), ["lost", "tracking", "lost", undefined, "lost"]);
  lost.add(700);
  columns.see(700, states);
  assert.equal(columns.states[1], "lost");
  const wide = new Columns(9, 5, 7);
  assert.deepEqual([0, 2, 3, 8].map((at) => wide.frames(at)), [[5, 5], [5, 5], [6, 6], [7, 7]]);
});

test("modules become one script, in which nothing is imported", () => {
  const script = bundle(new URL("../page/worker.js", import.meta.url));
  assert.doesNotMatch(script, /^\s*(import|export)\b/m);
  assert.doesNotThrow(() => new Function(script));
});

test("of a long recording the least and the largest value of each column are drawn, and gaps stay", () => {
  const numbers = Array.from({ length: 200_000 }, (_, at) => at + 1);
  const values = numbers.map((number) => (number > 100_000 && number <= 150_000 ? null : number === 777 ? 9 : number % 2));
  const points = thinned({ numbers, values }, { from: 0.5, to: 200_000.5 }, 500);
  assert.ok(points.length <= 1100 && points.includes(776) && points.includes(null), `${points.length} points`);
  assert.deepEqual(points.filter((at) => at !== null), points.filter((at) => at !== null).sort((one, other) => one - other));
  assert.deepEqual(thinned({ numbers, values }, { from: 9.5, to: 12.5 }, 500), [8, 9, 10, 11, 12]);
});

test("spans are of equal values, and a missing one ends a span", () => {
  assert.deepEqual(spansOf(["lost", "lost", null, "lost", "leaving"]).map(({ value, from, to }) => [value, from, to]), [["lost", 0, 1], ["lost", 3, 3], ["leaving", 4, 4]]);
});

test("boxes that coincide share a line, the last one of a lost target does not", () => {
  const place = [10, 20, 30, 40];
  const [one, last, near, far] = sharing([{ place }, { place, isLast: true }, { place: [12, 20, 28, 41] }, { place: [13, 20, 30, 40], dash: [14, 5] }]);
  assert.deepEqual([[one.dash, one.offset], [near.dash, near.offset]], [[[10, 10], -0], [[10, 10], -10]]);
  assert.deepEqual([last.dash, far.dash], [undefined, [14, 5]]);
});
