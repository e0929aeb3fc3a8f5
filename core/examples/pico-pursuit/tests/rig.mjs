// The firmware in its head: board, camera, servos, button and LED, wired as the README says, and a record of what happened.

import { readFileSync } from "node:fs";
import { Board } from "./board.mjs";
import { Camera, PIXELS } from "./camera.mjs";
import { Scene } from "./scene.mjs";

const [PAN, TILT, BUTTON, LED] = [20, 21, 22, 25];
const RAM = 0x20000000;
/** `value` of a pin of rp2040js that is an output and high. */
const HIGH = 1;
/** The PWM slice of both servos, and the offset of its compare register. */
const COMPARE = 2 * 0x14 + 0x0c;

export class Rig {
  /** `target(seconds)`: see `Scene`. */
  constructor(file, target) {
    this.board = new Board(readFileSync(file));
    const { mcu } = this.board;
    const now = () => this.board.seconds;
    this.scene = new Scene(target, now);
    this.camera = new Camera(mcu, this.scene);
    this.board.wired = this.camera;
    this.press(false);
    connect(mcu.gpio[PAN], this.scene.pan, now);
    connect(mcu.gpio[TILT], this.scene.tilt, now);
    /** One entry for each frame of the camera. */
    this.frames = [];
    this.camera.onFrame = () => this.note();
    /** For each frame that DMA has stored: the seconds of its end, and whether its bytes are those that were clocked out. */
    this.stored = [];
    mcu.dma.checkInterrupts = () => this.compare(mcu.dma);
    /** Seconds at which the firmware commanded the servos: once for each frame that it has followed or waited for. */
    this.commands = [];
    let panFirst = false;
    const write = mcu.pwm.writeUint32.bind(mcu.pwm);
    mcu.pwm.writeUint32 = (offset, value) => {
      // Pan is written first, then tilt.
      if (offset === COMPARE && (panFirst = !panFirst)) this.commands.push(now());
      write(offset, value);
    };
  }

  /** Called when a DMA channel has filled its buffer, with the last word of a frame. */
  compare(dma) {
    for (const channel of dma.channels) {
      if ((dma.intRaw & (1 << channel.index)) === 0) continue;
      const end = channel.writeAddr - RAM;
      const bytes = this.board.mcu.sram.subarray(end - PIXELS, end);
      this.stored.push({ seconds: this.board.seconds, equal: Buffer.compare(bytes, this.camera.sending) === 0 });
    }
    dma.intRaw = 0;
  }

  press(down) {
    this.board.mcu.gpio[BUTTON].setInputValue(!down);
  }

  get led() {
    return this.board.mcu.gpio[LED].value === HIGH;
  }

  note() {
    const seconds = this.board.seconds;
    const [pan, tilt] = [this.scene.pan, this.scene.tilt].map((servo) => servo.pulses[servo.pulses.length - 1]?.microseconds);
    this.frames.push({ seconds, error: this.scene.error(), led: this.led, pan, tilt, pixels: this.camera.sent });
  }

  /** The frames of the camera after `from` and up to `to` seconds. */
  between(from, to = Infinity) {
    return this.frames.filter(({ seconds }) => seconds > from && seconds <= to);
  }

  untilFrame(count) {
    while (this.camera.frames < count) this.board.step();
  }

  /** Runs until the camera sends the middle of a frame that DMA stores. */
  untilMidFrame() {
    const storing = () => this.board.mcu.dma.channels.some((channel) => channel.active && channel.transCount < PIXELS / 8);
    while (!storing()) this.board.step();
  }

  untilSecond(seconds) {
    while (this.board.seconds < seconds) this.board.step();
  }
}

function connect(pin, servo, now) {
  let start = null;
  pin.addListener((value) => {
    if (value === HIGH) start = now();
    else if (start !== null) servo.pulse(start, now());
  });
}
