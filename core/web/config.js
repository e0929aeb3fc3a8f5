// The options of a tracker, and their places in the C interface's `smr_config`.

import { object, whole } from "./errors.js";

/** The size of `smr_config` in bytes. */
export const CONFIG_SIZE = 80;
/** The place of the address of the paper's table. */
export const TABLE = 8;
/** The scale of the table that is built in. */
export const PAPER_SCALE = 255;

const switched = (at) => ({ at, bytes: 1, count: 1, most: 1 });
const u8 = (at) => ({ at, bytes: 1, count: 1, most: 255 });
const u16 = (at, count = 1) => ({ at, bytes: 2, count, most: 65535 });

// The names are those of smr.h in camel case. The name of the gate precedes those of its fields, except for
// `leastRatio`.
const BOTH = { plainLoop: switched(4) };
const OPTIONS = {
  paper: {
    ...BOTH,
    k: u16(12, 2),
    firstThreshold: u8(16),
    leastThreshold: u8(17),
    padding: u16(18),
    window: u16(20, 2),
    growth: u16(24),
    windowLimit: u16(26, 2),
    neighbourhood: u16(30),
    updateZone: u16(32, 4),
    gateTracking: u16(40, 2),
    gateLeaving: u16(44, 2),
    gateReturning: u16(48, 2),
    gateLost: u16(52, 2),
    gateLead: u16(56),
    leastRatio: u16(58),
    runnerUpAlways: switched(60),
  },
  robust: {
    ...BOTH,
    reach: u8(64),
    size: switched(65),
    sweep: switched(66),
    refiner: switched(67),
    patience: u8(68),
    lostBelow: u16(70),
    uncertainBelow: u16(72),
    learningRate: u16(74),
    earlyRate: u16(76),
  },
};

/** Checks `options`: an object, or nothing. */
export function checkOptions(options = {}) {
  return object(options, "the options", "an object");
}

/**
 * Writes `options` over the numbers of a preset at `at`. An option that is undefined keeps the number of the preset.
 */
export function writeOptions(view, at, method, options) {
  for (const [name, value] of Object.entries(options)) {
    if (value !== undefined) {
      write(view, at, placeOf(method, name), value, name);
    }
  }
}

/** All options of a configuration, by name. */
export function readOptions(view, at, method) {
  return Object.fromEntries(Object.entries(OPTIONS[method]).map(([name, place]) => [name, read(view, at, place)]));
}

function placeOf(method, name) {
  if (!Object.hasOwn(OPTIONS[method], name)) {
    throw new TypeError(`the ${method} tracker has no option ${name}: expected ${Object.keys(OPTIONS[method]).join(", ")}`);
  }
  return OPTIONS[method][name];
}

function write(view, at, { at: offset, bytes, count, most }, value, name) {
  const values = count === 1 ? [value] : value;
  if (count > 1 && !(Array.isArray(value) && value.length === count)) {
    throw new TypeError(`${name} must be an array of ${count} numbers`);
  }
  const numbers = values.map((number) => whole(most === 1 && typeof number === "boolean" ? Number(number) : number, 0, most, name));
  numbers.forEach((number, i) => {
    const to = at + offset + i * bytes;
    bytes === 1 ? view.setUint8(to, number) : view.setUint16(to, number, true);
  });
}

function read(view, at, { at: offset, bytes, count, most }) {
  const numbers = Array.from({ length: count }, (_, i) => {
    const from = at + offset + i * bytes;
    return bytes === 1 ? view.getUint8(from) : view.getUint16(from, true);
  });
  if (most === 1) {
    return numbers[0] !== 0;
  }
  return count === 1 ? numbers[0] : numbers;
}
