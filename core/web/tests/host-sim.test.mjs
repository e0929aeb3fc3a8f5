// JavaScript's answers equal host-sim's on the same pixels, in gray and in color, and host-sim replays the flight
// records of JavaScript.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, test } from "node:test";
import { Recorder } from "../record.js";
import { colored, frames, libraries } from "./library.mjs";

const hostSim = process.env.SMR_HOST_SIM;
const skip = hostSim === undefined && "no host-sim: run .ci/web";
const folder = mkdtempSync(join(tmpdir(), "smr-web-"));
after(() => rmSync(folder, { recursive: true }));
const { simd: smr } = await libraries();

// For each tracker its method and options, and those of host-sim.
const TRACKERS = {
  paper: { make: () => smr.paper(), options: ["--config", "camera"] },
  robust: { make: () => smr.robust(), options: ["--method", "robust"] },
  small: { make: () => smr.robust({ preset: "small" }), options: ["--config", "small"] },
  smallRefined: { make: () => smr.robust({ preset: "smallRefined" }), options: ["--config", "small-refined"] },
};
const recording = [...frames({ count: 24, side: 20 })];
// The target is hidden in frames 9 to 16, so that the tracker loses it, searches for it and finds it again.
const hidden = { ...recording[23], data: recording[23].data.map(() => 90) };
const shown = recording.map((frame, at) => (at >= 8 && at < 16 ? hidden : frame));

function run(...values) {
  const { status, stdout, stderr } = spawnSync(hostSim, values, { encoding: "utf8" });
  assert.equal(status, 0, `host-sim ${values.join(" ")}: ${stderr}`);
  return stdout;
}

function pictures(name, frames) {
  const place = mkdtempSync(join(folder, name));
  frames.forEach(({ data, width, height }, at) => {
    const isColor = data.length > width * height;
    const samples = isColor ? data.filter((_, at) => at % 4 < 3) : data;
    const head = Buffer.from(`${isColor ? "P6" : "P5"} ${width} ${height} 255\n`);
    writeFileSync(join(place, `${String(at + 1).padStart(4, "0")}.${isColor ? "ppm" : "pgm"}`), Buffer.concat([head, Buffer.from(samples)]));
  });
  return place;
}

const millionths = (value, unit) => Math.round((1e6 * value) / unit) / 1e6;

/**
 * Converts an answer to host-sim's JSON, which has no box of a lost target. The work of the paper tracker is left
 * out, because it depends on the tracker's capacity, which is larger in host-sim.
 */
function printed({ box, fineBox, state, confidence, ratio, alpha, identity, scale, foundAgain, work }, method) {
  const fine = Object.fromEntries(Object.entries(fineBox).map(([side, value]) => [side, value / 256]));
  const boxes = state === "lost" ? { box: null, fine: null } : { box, fine };
  const counted = method === "robust" ? { work } : {};
  const parts = { confidence: millionths(confidence, 65535), ratio: millionths(ratio, 65535), scale: millionths(scale, 65536) };
  const optional = { alpha, identity: identity === null ? null : millionths(identity, 65535) };
  return { ...boxes, ...parts, ...optional, ...counted, state, found_again: foundAgain };
}

for (const [name, { make, options }] of Object.entries(TRACKERS)) {
  for (const [colors, sequence] of [["gray", shown], ["RGBA", shown.map(colored)]]) {
    test(`${name}: answers for ${colors} frames are those of host-sim`, { skip }, () => {
      const { x, y, width, height } = sequence[0].box;
      const lines = run("track", ...options, "--json", "--init", [x, y, width, height].join(), pictures(colors, sequence));
      const expected = lines.trim().split("\n").map((line) => JSON.parse(line));
      const tracker = make();
      tracker.lock(sequence[0], sequence[0].box);
      const states = new Set();
      sequence.slice(1).forEach((frame, at) => {
        const answer = printed(tracker.update(frame), tracker.method);
        const wanted = Object.fromEntries(Object.keys(answer).map((key) => [key, expected[at + 1][key]]));
        assert.deepEqual(answer, wanted, `frame ${at + 2}`);
        states.add(answer.state);
      });
      assert.ok(states.has("tracking") && (states.has("lost") || colors === "RGBA"), [...states].join());
    });
  }
}

/** Lets host-sim replay a flight record; all answers must be as recorded. Returns their count. */
function replayed(bytes, name) {
  const file = join(folder, `${name}.smr`);
  writeFileSync(file, bytes);
  const { flights, cut_off, damage, difference } = JSON.parse(run("replay", "--json", file));
  assert.deepEqual({ cut_off, damage, difference }, { cut_off: 0, damage: null, difference: null });
  return flights.reduce((sum, { answers }) => sum + answers, 0);
}

const RECORDED = {
  paper: () => smr.paper({ updateZone: [1, 2, 3, 4], k: [1, 3], leastRatio: 9, gateLead: 50, runnerUpAlways: true }),
  robust: () => smr.robust({ reach: 6, patience: 100 }),
  small: () => smr.robust({ preset: "smallRefined", patience: 100 }),
};
for (const [method, make] of Object.entries(RECORDED)) {
  test(`${method}: host-sim replays a flight record`, { skip }, () => {
    const tracker = make();
    const recorder = new Recorder(tracker);
    tracker.lock(shown[0], shown[0].box);
    shown.slice(1, 12).forEach((frame) => tracker.update(frame));
    tracker.moved(300, -200);
    const saved = tracker.save();
    shown.slice(12).forEach((frame) => tracker.update(frame));
    tracker.restore(saved);
    shown.slice(12).forEach((frame) => tracker.update(frame));
    const bytes = recorder.bytes();
    assert.equal(replayed(bytes, method), 35);
    recorder.stop();
    tracker.update(shown[0]);
    assert.deepEqual(recorder.bytes(), bytes);
  });
}

for (const method of ["paper", "robust"]) {
  test(`${method}: a record keeps the last frames, in bounded memory`, { skip }, () => {
    const most = 400_000;
    const tracker = smr[method]();
    tracker.lock(shown[0], shown[0].box);
    const recorder = new Recorder(tracker, { bytes: most });
    let kept = 0;
    for (let at = 0; at < 200; at++) {
      tracker.update(shown[at % shown.length]);
      kept = Math.max(kept, recorder.bytes().length);
    }
    assert.ok(kept > most / 2 && kept < 1.5 * most, `${kept} bytes`);
    const answers = replayed(recorder.bytes(), method);
    assert.ok(answers > 3 && answers < 200, `${answers} answers`);
  });
}

test("robust: host-sim replays records with the refiner and without, and their boxes differ", { skip }, () => {
  // In color frames, the refiner changes almost every box.
  const [first, ...others] = shown.map(colored);
  const boxes = [true, false].map((refiner) => {
    const tracker = smr.robust({ refiner });
    const recorder = new Recorder(tracker);
    tracker.lock(first, first.box);
    const found = others.map((frame) => tracker.update(frame).fineBox);
    assert.equal(replayed(recorder.bytes(), `refiner-${refiner}`), others.length);
    return found;
  });
  assert.notDeepEqual(...boxes);
});
