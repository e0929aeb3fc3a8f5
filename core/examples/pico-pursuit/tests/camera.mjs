// The camera module: an HM01B0 that answers on I2C, and clocks a picture into the pins, one bit for each pulse of PCLK.

export const WIDTH = 162;
export const HEIGHT = 122;
export const PIXELS = WIDTH * HEIGHT;
const ADDRESS = 0x24;
const PINS = { d0: 6, pclk: 14, href: 15, vsync: 16 };
/** Frames per second of the module's oscillator, with the registers that the firmware writes. */
export const FRAMES_PER_SECOND = 60;
const BITS = 8;
const STREAM = 0x0100;

export class Camera {
  /** `scene.row(y)` gives the bytes of a row when the sensor reads it: a rolling shutter. */
  constructor(mcu, scene) {
    this.scene = scene;
    this.pins = Object.fromEntries(Object.entries(PINS).map(([name, number]) => [name, mcu.gpio[number]]));
    /** What was written to the sensor: [register, value], in order. */
    this.written = [];
    /** The bytes of the frame that is clocked out, and of the last whole one. */
    this.sending = new Uint8Array(PIXELS);
    this.sent = null;
    this.frames = 0;
    this.onFrame = () => {};
    this.connect(mcu.i2c[0]);
    this.row = this.column = this.bit = 0;
    this.high = false;
    /** Cycles until the next edge of PCLK. */
    this.cycles = Infinity;
    this.cyclesPerSecond = () => mcu.clkSys;
  }

  connect(bus) {
    let bytes = [];
    bus.onStart = () => {
      bytes = [];
      bus.completeStart();
    };
    bus.onConnect = (address) => bus.completeConnect(address === ADDRESS);
    bus.onWriteByte = (byte) => {
      bytes.push(byte);
      bus.completeWrite(true);
    };
    bus.onStop = () => {
      if (bytes.length > 0) this.write(bytes);
      bus.completeStop();
    };
  }

  write([high, low, value]) {
    const register = (high << 8) | low;
    this.written.push([register, value]);
    if (register === STREAM && value === 1) this.start();
  }

  register(address) {
    return this.written.filter(([register]) => register === address).pop()?.[1] ?? 0;
  }

  /** Begins to stream: rows and clocks of a frame are those of the registers. */
  start() {
    this.rows = (this.register(0x0340) << 8) | this.register(0x0341);
    this.columns = (this.register(0x0342) << 8) | this.register(0x0343);
    if (this.rows < HEIGHT || this.columns < WIDTH) throw new Error(`a frame of ${this.columns}x${this.rows} clocks is too small`);
    this.halfBit = this.cyclesPerSecond() / (FRAMES_PER_SECOND * this.rows * this.columns * BITS * 2);
    this.row = HEIGHT; // a blanking first
    this.cycles = this.remainder = this.halfBit;
    this.settle();
  }

  /** Edges come at whole cycles; what is cut off is kept. */
  settle() {
    this.cycles = Math.max(1, Math.round(this.remainder));
    this.remainder -= this.cycles;
  }

  pass(cycles) {
    this.cycles -= cycles;
    if (this.cycles > 0) return;
    if (this.high) this.fall();
    else this.pins.pclk.setInputValue(true);
    this.high = !this.high;
    this.remainder += this.halfBit;
    this.settle();
  }

  /** The falling edge of PCLK: the next bit, HREF and VSYNC. */
  fall() {
    if (++this.bit === BITS) {
      this.bit = 0;
      if (++this.column === this.columns) {
        this.column = 0;
        this.row = (this.row + 1) % this.rows;
        this.beginRow();
      }
      if (this.column === WIDTH && this.row < HEIGHT) this.pins.href.setInputValue(false);
    }
    const seen = this.column < WIDTH && this.row < HEIGHT;
    if (seen) this.pins.d0.rawInputValue = ((this.sending[this.row * WIDTH + this.column] >> this.bit) & 1) === 1;
    this.pins.pclk.setInputValue(false);
  }

  beginRow() {
    const { vsync, href } = this.pins;
    if (this.row === HEIGHT) {
      vsync.setInputValue(false);
      this.sent = this.sending.slice();
      this.frames++;
      this.onFrame();
    }
    // VSYNC rises a row before the first one.
    if (this.row === this.rows - 1) vsync.setInputValue(true);
    if (this.row >= HEIGHT) return;
    this.sending.set(this.scene.row(this.row), this.row * WIDTH);
    href.setInputValue(true);
  }

  /** The clock stops, as with a loose wire. */
  stop() {
    this.cycles = Infinity;
  }

  /** The clock comes back: the sensor begins with a new frame. */
  resume() {
    this.row = this.rows - 1;
    this.column = this.columns - 1;
    this.bit = 0;
    this.pins.href.setInputValue(false);
    this.pins.vsync.setInputValue(false);
    this.remainder = this.halfBit;
    this.settle();
  }
}
