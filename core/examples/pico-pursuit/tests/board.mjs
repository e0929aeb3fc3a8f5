// A Raspberry Pi Pico: `rp2040js` with an ELF in its flash, whose core, PIO and pins keep one time, cycle by cycle.

import { RP2040 } from "rp2040js";
import { installRom } from "./rom.mjs";

const FLASH = 0x10000000;
/** The vector table stands behind the second stage of the boot loader. */
const VECTORS = 0x10000100;
const PT_LOAD = 1;

export class Board {
  /**
   * `elf`: the bytes of the firmware. `wired` stands for what is connected to the pins: `cycles` says how many pass
   * until it changes a pin again, and `pass(cycles)` lets them pass.
   */
  constructor(elf) {
    this.mcu = new RP2040();
    this.clock = this.mcu.clock;
    const complain = (name, message) => {
      throw new Error(`${name}: ${message}`);
    };
    this.mcu.logger = { debug() {}, info() {}, warn() {}, error: complain };
    this.wired = { cycles: Infinity, pass() {} };
    this.cycles = 0;
    this.charged = 0;
    installRom(this.mcu, (cycles) => {
      this.charged += cycles;
    });
    load(elf, this.mcu.flash);
    const { core } = this.mcu;
    core.VTOR = VECTORS;
    core.SP = this.mcu.readUint32(VECTORS);
    core.PC = this.mcu.readUint32(VECTORS + 4) & ~1;
    // `rp2040js` steps a PIO by a timer of the host. Here `pass` steps it.
    for (const pio of this.mcu.pio) pio.run = () => {};
  }

  get seconds() {
    return this.clock.nanos / 1e9;
  }

  /** Executes one instruction, or if the core waits for an interrupt, lets time pass until one can come. */
  step() {
    const { core } = this.mcu;
    this.charged = 0;
    let cycles;
    if (core.waiting) {
      const alarm = Math.ceil((this.clock.nanosToNextAlarm * this.mcu.clkSys) / 1e9);
      cycles = Math.max(1, Math.min(alarm, this.wired.cycles));
    } else {
      cycles = core.executeInstruction() + this.charged;
    }
    this.pass(cycles);
  }

  pass(cycles) {
    this.cycles += cycles;
    const nanos = 1e9 / this.mcu.clkSys;
    for (let left = cycles; left > 0; ) {
      const some = Math.min(left, this.wired.cycles);
      this.stepPio(some);
      this.wired.pass(some);
      this.clock.tick(some * nanos); // DMA moves what a PIO has received
      left -= some;
    }
  }

  /** A machine that waits is woken by the pin or the FIFO that it waits for, not by time. */
  stepPio(cycles) {
    for (const pio of this.mcu.pio) {
      if (pio.stopped) continue;
      for (const machine of pio.machines) {
        if (!machine.enabled) continue;
        for (let left = cycles; left > 0 && !machine.waiting; left--) machine.step();
      }
    }
  }
}

/** Copies the segments of an ELF of 32 bits to where they are loaded from. */
function load(elf, flash) {
  if (elf.readUInt32BE(0) !== 0x7f454c46) throw new Error("the firmware is not an ELF file");
  const [table, size, count] = [elf.readUInt32LE(28), elf.readUInt16LE(42), elf.readUInt16LE(44)];
  for (let number = 0; number < count; number++) {
    const segment = elf.subarray(table + number * size, table + (number + 1) * size);
    const [type, offset, , address, bytes] = [0, 4, 8, 12, 16].map((at) => segment.readUInt32LE(at));
    if (type === PT_LOAD && bytes > 0) flash.set(elf.subarray(offset, offset + bytes), address - FLASH);
  }
}
