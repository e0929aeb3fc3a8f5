// The options of a tracker, and their places in the C interface's `smr_config`.

import { object } from "./errors.js";
import { array, flag, struct, u16, u32, u8 } from "./layout.js";

const pair = array(u16, 2);

// The names are those of smr.h in camel case. The name of the gate precedes those of its fields, except for
// `leastRatio`.
const PAPER = {
  k: pair,
  firstThreshold: u8,
  leastThreshold: u8,
  padding: u16,
  window: pair,
  growth: u16,
  windowLimit: pair,
  neighbourhood: u16,
  updateZone: array(u16, 4),
  gateTracking: pair,
  gateLeaving: pair,
  gateReturning: pair,
  gateLost: pair,
  gateLead: u16,
  leastRatio: u16,
  runnerUpAlways: flag,
};
const ROBUST = {
  reach: u8,
  size: flag,
  sweep: flag,
  refiner: flag,
  patience: u8,
  lostBelow: u16,
  uncertainBelow: u16,
  learningRate: u16,
  earlyRate: u16,
};
const METHODS = { paper: struct(PAPER), robust: struct(ROBUST) };
export const CONFIG = struct({ method: u32, plainLoop: flag, ...METHODS });

/** Checks `options`: an object, or nothing. */
export function checkOptions(options = {}) {
  return object(options, "the options", "an object");
}

/**
 * Writes `options` over the numbers of a preset at `at`. An option that is undefined keeps the number of the preset.
 */
export function writeOptions(view, at, method, options) {
  const known = optionsOf(method);
  for (const [name, value] of Object.entries(options).filter(([, value]) => value !== undefined)) {
    if (!Object.hasOwn(known, name)) {
      throw new TypeError(`the ${method} tracker has no option ${name}: expected ${Object.keys(known).join(", ")}`);
    }
    known[name].type.write(view, at + known[name].place, value, name);
  }
}

/** All options of a configuration, by name. */
export function readOptions(view, at, method) {
  return Object.fromEntries(Object.entries(optionsOf(method)).map(([name, { type, place }]) => [name, type.read(view, at + place)]));
}

// The types and places of a tracker's options, by name.
function optionsOf(method) {
  const { plainLoop, [method]: start } = CONFIG.places;
  const { fields, places } = METHODS[method];
  const own = Object.entries(fields).map(([name, type]) => [name, { type, place: start + places[name] }]);
  return Object.fromEntries([["plainLoop", { type: flag, place: plainLoop }], ...own]);
}
