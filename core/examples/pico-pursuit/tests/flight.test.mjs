// Seventeen seconds of the firmware in its head: a target that swings, a camera that stops in the middle of a frame, a target
// that leaves and comes back. SMR_PICO is the firmware's ELF, SMR_TRACKER its tracker: `paper` or `robust`.

import assert from "node:assert/strict";
import { test } from "node:test";
import { FRAMES_PER_SECOND } from "./camera.mjs";
import { Rig } from "./rig.mjs";
import { swing } from "./scene.mjs";

/** Seconds at which it swings, stands, is hidden and is seen again, and at which the camera stops and goes on. */
const [SWINGS, STANDS, STOPS, GOES_ON, HIDDEN, BACK, END] = [0.8, 7.8, 8.8, 9.5, 10.5, 15, 16.5];

function target(seconds) {
  if (seconds > HIDDEN && seconds < BACK) return null;
  return swing(Math.max(0, Math.min(seconds, STANDS) - SWINGS));
}

const off = ({ error }) => Math.hypot(error.x, error.y);
const largest = (frames) => Math.max(...frames.map(off));
const at = (rig, seconds) => rig.between(seconds)[0];
/** Seconds from `from` until the LED is `on`. */
const until = (rig, from, on) => (rig.between(from).find(({ led }) => led === on)?.seconds ?? Infinity) - from;

/**
 * Mean seconds from the middle of a picture to the end of the first pulse that it commands. After a command the firmware takes
 * the newest frame, or if it has had that one, waits for the next.
 */
function delay({ commands, stored, scene }, from, to) {
  const delays = [];
  let had = null;
  for (const [number, commanded] of commands.entries()) {
    if (commanded < from || commanded > to) continue;
    const newest = stored.filter(({ seconds }) => seconds < commands[number - 1]).pop();
    const taken = newest === had ? stored[stored.indexOf(newest) + 1] : newest;
    const { start, microseconds } = scene.pan.pulses.find(({ start }) => start >= commanded);
    delays.push(start + microseconds / 1e6 - (taken.seconds - 0.5 / FRAMES_PER_SECOND));
    had = taken;
  }
  return delays.reduce((sum, one) => sum + one, 0) / delays.length;
}

/** Pixels off the centre at most while it swings, frames a second at least, and seconds at most until it is found again. */
const LIMITS = {
  paper: { lag: 10, rate: 45, found: 0.3 },
  robust: { lag: 18, rate: 14, found: 1 },
};
const name = process.env.SMR_TRACKER;
const { lag, rate, found } = LIMITS[name];

const rig = new Rig(process.env.SMR_PICO, target);
rig.untilFrame(3);
rig.press(true);
rig.untilFrame(8);
rig.press(false);
rig.untilSecond(STOPS);
rig.untilMidFrame();
rig.camera.stop();
rig.untilSecond(GOES_ON);
rig.camera.resume();
rig.untilSecond(END);

test("the target swings by 60 pixels, and stays near the centre", () => {
  const [from, to] = [SWINGS + 2, STANDS];
  const commands = rig.commands.filter((seconds) => seconds > from && seconds <= to).length;
  const [most, frames] = [largest(rig.between(from, to)), commands / (to - from)];
  console.log(`${name}: ${frames.toFixed(1)} frames a second, at most ${most.toFixed(1)} pixels off the centre`);
  console.log(`${name}: ${(1000 * delay(rig, from, to)).toFixed(0)} milliseconds from a picture to its pulse`);
  assert.ok(most < lag, `${most} pixels off`);
  assert.ok(frames > rate, `${frames} frames a second`);
  assert.ok(rig.between(from, to).every(({ led }) => led), "the LED goes out");
});

test("it stands, and is in the centre", () => {
  assert.ok(largest(rig.between(STANDS + 0.7, STOPS)) < 3, `${largest(rig.between(STANDS + 0.7, STOPS))} pixels off`);
});

test("the camera stops in the middle of a frame: the head holds still, the LED goes out", () => {
  const [before, after] = [at(rig, STOPS - 0.1), at(rig, GOES_ON)];
  assert.equal(after.led, false);
  assert.ok(Math.abs(before.pan - after.pan) < 4 && Math.abs(before.tilt - after.tilt) < 4, "the head has moved");
  assert.ok(rig.commands.filter((seconds) => seconds > STOPS + 0.2 && seconds < GOES_ON).length >= 1, "no sign of life");
});

test("the camera goes on: the torn frame is dropped, the target is followed again", () => {
  assert.equal(rig.stored.filter(({ equal }) => !equal).length, 1, "torn frames");
  assert.ok(until(rig, GOES_ON, true) < 0.5, `${until(rig, GOES_ON, true)} s until the LED is on`);
  assert.ok(largest(rig.between(GOES_ON + 0.1, HIDDEN)) < 3, `${largest(rig.between(GOES_ON + 0.1, HIDDEN))} pixels off`);
});

test("the target leaves: the LED goes out, the head holds still for 3 seconds and turns home", () => {
  assert.ok(until(rig, HIDDEN, false) < 1, `${until(rig, HIDDEN, false)} s until the LED is off`);
  const [before, held, home] = [at(rig, HIDDEN + 0.6), at(rig, HIDDEN + 2.8), at(rig, BACK - 0.1)];
  assert.ok(Math.abs(before.tilt - 1500) > 40, "the head was turned");
  assert.ok(Math.abs(before.pan - held.pan) < 6 && Math.abs(before.tilt - held.tilt) < 6, "the head does not hold still");
  assert.ok(Math.abs(home.pan - 1500) < 0.5 && Math.abs(home.tilt - 1500) < 0.5, "the head is not at home");
});

test("the target comes back: it is found, and in the centre", () => {
  console.log(`${name}: found again in ${until(rig, BACK, true).toFixed(1)} s`);
  assert.ok(until(rig, BACK, true) < found, `${until(rig, BACK, true)} s until the LED is on`);
  assert.ok(off(at(rig, END - 0.1)) < 3, `${off(at(rig, END - 0.1))} pixels off`);
});
