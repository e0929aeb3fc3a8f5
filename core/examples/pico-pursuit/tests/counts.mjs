// What the emulated core executes while it follows: for each address of an instruction how often it ran, how often the next
// instruction stood elsewhere, and the cycles that the emulator gave it, as JSON. SMR_PICO is the firmware's ELF.

import { Rig } from "./rig.mjs";
import { swing } from "./scene.mjs";

/** Frames of the camera from the lock on, and those that are counted. */
const [SETTLED, COUNTED] = [24, 12];
/** An instruction from here on has a second half. */
const WIDE = 0xe800;

const rig = new Rig(process.env.SMR_PICO, swing);
rig.untilFrame(3);
rig.press(true);
rig.untilFrame(8);
rig.press(false);
rig.untilFrame(SETTLED);
const { core } = rig.board.mcu;
const counts = {};
while (rig.camera.frames < SETTLED + COUNTED) {
  const [address, before] = [core.PC, rig.board.cycles];
  const next = address + (rig.board.mcu.readUint16(address) >= WIDE ? 4 : 2);
  rig.board.step();
  const count = (counts[address] ??= [0, 0, 0]);
  count[0]++;
  if (core.PC !== next) count[1]++;
  count[2] += rig.board.cycles - before;
}
console.log(JSON.stringify(counts));
