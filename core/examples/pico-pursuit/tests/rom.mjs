// A boot ROM written here, because the maker's is not in this repository: a look-up, and a stub for each function that
// the firmware's HAL looks up (`rp2040-hal`, `rom_data.rs`). A stub is `bkpt N; bx lr`; JavaScript does its work.

const SIZE = 16 * 1024;
const FLOAT_TABLE = 0x1000;
/** The ROM's float functions that have an address in `FLOAT_TABLE`: 32 of 4 bytes. */
const FLOAT_TABLE_SIZE = 0x80;

/** Cycles that a call is charged: estimates of those that the maker's ROM takes. */
const FLOAT_CYCLES = 75;
const BITS_CYCLES = 20;
const copyCycles = (bytes) => 30 + bytes;

const scratch = new DataView(new ArrayBuffer(4));
function toFloat(bits) {
  scratch.setUint32(0, bits);
  return scratch.getFloat32(0);
}
function toBits(float) {
  scratch.setFloat32(0, float);
  return scratch.getUint32(0);
}
const clamp = (value, low, high) => Math.max(low, Math.min(high, Number.isNaN(value) ? 0 : value));

/**
 * Writes the ROM into `mcu` and answers its calls. `charge` is told the cycles of each call.
 */
export function installRom(mcu, charge) {
  const view = new DataView(new ArrayBuffer(SIZE));
  const calls = new Map();
  let end = 0x200;

  /** A stub at `address` whose work is `call`; returns the address to branch to. */
  function stub(call, address = end) {
    const number = calls.size;
    calls.set(number, call);
    view.setUint16(address, 0xbe00 | number, true); // bkpt
    view.setUint16(address + 2, 0x4770, true); // bx lr
    if (address === end) end += 4;
    return address | 1;
  }

  const argument = (number) => mcu.core.registers[number];
  /** A stub that returns `work` of the first three arguments, for `cycles` (a number, or a function of them). */
  const returns = (cycles, work) =>
    stub(() => {
      const given = [argument(0), argument(1), argument(2)];
      charge(typeof cycles === "number" ? cycles : cycles(...given));
      mcu.core.registers[0] = work(...given) >>> 0;
    });
  const float = (work) => returns(FLOAT_CYCLES, (a, b) => toBits(work(toFloat(a), toFloat(b))));

  const floats = new Map([
    [0x00, float((a, b) => a + b)],
    [0x04, float((a, b) => a - b)],
    [0x08, float((a, b) => a * b)],
    [0x0c, float((a, b) => a / b)],
    [0x18, float(Math.sqrt)],
    [0x1c, returns(FLOAT_CYCLES, (a) => clamp(Math.floor(toFloat(a)), -(2 ** 31), 2 ** 31 - 1))],
    [0x24, returns(FLOAT_CYCLES, (a) => clamp(Math.floor(toFloat(a)), 0, 2 ** 32 - 1))],
    [0x2c, returns(FLOAT_CYCLES, (a) => toBits(a | 0))],
    [0x34, returns(FLOAT_CYCLES, toBits)],
    [0x54, returns(FLOAT_CYCLES, (a, b) => Math.sign(toFloat(a) - toFloat(b)))],
  ]);
  for (let offset = 0; offset < FLOAT_TABLE_SIZE; offset += 4) {
    const missing = () => {
      throw new Error(`the firmware calls the ROM's float function at 0x${offset.toString(16)}, which rom.mjs lacks`);
    };
    view.setUint32(FLOAT_TABLE + offset, floats.get(offset) ?? stub(missing), true);
  }

  const copy = returns((to, from, bytes) => copyCycles(bytes), (to, from, bytes) => {
    for (let at = 0; at < bytes; at++) mcu.writeUint8(to + at, mcu.readUint8(from + at));
    return to;
  });
  const fill = returns((to, byte, bytes) => copyCycles(bytes), (to, byte, bytes) => {
    for (let at = 0; at < bytes; at++) mcu.writeUint8(to + at, byte & 255);
    return to;
  });
  const ones = (x) => x.toString(2).replaceAll("0", "").length;
  const reversed = (x) => parseInt(x.toString(2).padStart(32, "0").split("").reverse().join(""), 2);
  const table = {
    SF: FLOAT_TABLE,
    MC: copy,
    C4: copy,
    MS: fill,
    S4: fill,
    L3: returns(BITS_CYCLES, Math.clz32),
    T3: returns(BITS_CYCLES, (x) => (x === 0 ? 32 : 31 - Math.clz32(x & -x))),
    P3: returns(BITS_CYCLES, ones),
    R3: returns(BITS_CYCLES, reversed),
  };
  const lookUp = returns(BITS_CYCLES * 3, (where, code) => {
    const name = String.fromCharCode(code & 255, (code >> 8) & 255);
    if (!(name in table)) throw new Error(`the firmware looks up ${JSON.stringify(name)} in the ROM, which rom.mjs lacks`);
    return table[name];
  });

  // The first entries that `rom_data.rs` reads: version 1, the two tables and the look-up, each as 16 bits.
  view.setUint8(0x13, 1);
  view.setUint16(0x14, FLOAT_TABLE, true);
  view.setUint16(0x16, FLOAT_TABLE, true);
  view.setUint16(0x18, lookUp, true);

  mcu.onBreak = (number) => {
    mcu.core.breakRewind = 0;
    const call = calls.get(number);
    if (call === undefined) throw new Error(`the firmware stops at a breakpoint, ${number}, at 0x${mcu.core.PC.toString(16)}`);
    call();
  };
  mcu.loadBootrom(new Uint32Array(view.buffer));
}
