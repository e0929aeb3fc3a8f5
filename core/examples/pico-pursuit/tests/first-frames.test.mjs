// The first 40 frames of the firmware in its head, less than a second. SMR_PICO is the firmware's ELF.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Rig } from "./rig.mjs";

const FRAMES = 40;
/** The target stands in the middle, then moves to the right and up within a tenth of a second, and stands again. */
const [LEAVES, ARRIVES] = [0.35, 0.45];
const PLACE = { x: 12, y: -8 };
function target(seconds) {
  const part = Math.max(0, Math.min(1, (seconds - LEAVES) / (ARRIVES - LEAVES)));
  return { x: PLACE.x * part, y: PLACE.y * part };
}

/**
 * [register, value]: reset, one bit per clock, half of the columns and rows, 128 rows of 215 clocks, stream. No sensor has
 * confirmed them.
 */
const REGISTERS = [
  [0x0103, 0x01], [0x3059, 0x22], [0x0383, 0x03], [0x0387, 0x03], [0x0390, 0x03], [0x3010, 0x01], [0x0340, 0x00],
  [0x0341, 0x80], [0x0342, 0x00], [0x0343, 0xd7], [0x3060, 0x08], [0x0104, 0x01], [0x0100, 0x01],
];

const rig = new Rig(process.env.SMR_PICO, target);
rig.untilFrame(3);
const pressed = rig.board.seconds;
rig.press(true);
rig.untilFrame(6);
rig.press(false);
rig.untilFrame(FRAMES);
const last = rig.frames[FRAMES - 1];

test("the sensor gets its registers, in their order", () => {
  assert.deepEqual(rig.camera.written, REGISTERS);
});

test("every frame in memory is the one that was clocked out", () => {
  assert.ok(rig.stored.length > FRAMES / 2, `${rig.stored.length} frames are stored`);
  assert.deepEqual(rig.stored.filter(({ equal }) => !equal), []);
});

test("the LED is off until the button is pressed, then on", () => {
  assert.deepEqual(rig.between(0, pressed).map(({ led }) => led), [false, false, false]);
  const locked = rig.frames.findIndex(({ led }) => led);
  assert.ok(locked >= 3 && locked < 12, `the LED lights up at frame ${locked}`);
  assert.ok(rig.frames.slice(locked).every(({ led }) => led), "the LED goes out again");
});

for (const name of ["pan", "tilt"]) {
  test(`the pulses of ${name} are those of a servo, every 20 milliseconds`, () => {
    const { pulses } = rig.scene[name];
    assert.ok(pulses.length > 20, `${pulses.length} pulses`);
    pulses.forEach(({ start, microseconds }, number) => {
      assert.ok(microseconds > 900 && microseconds < 2100, `${microseconds} us`);
      if (start < LEAVES) assert.ok(Math.abs(microseconds - 1500) < 0.5, `${microseconds} us at home`);
      const period = number > 0 ? (start - pulses[number - 1].start) * 1e6 : 20_000;
      assert.ok(Math.abs(period - 20_000) < 1, `${period} us from a pulse to the next`);
    });
  });
}

test("the head turns to the target", () => {
  console.log(`target off the centre after ${FRAMES} frames: ${last.error.x.toFixed(1)}, ${last.error.y.toFixed(1)} pixels`);
  assert.ok(Math.hypot(last.error.x, last.error.y) < 3, JSON.stringify(last.error));
});
