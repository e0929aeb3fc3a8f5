// Options of a tracker: the settings of the C interface, with names in camel case.

import { object, whole } from "./errors.js";
import { array, flag, struct, u16, u32, u8 } from "./layout.js";

/** Layout of the C interface's `smr_setting`. */
export const SETTING = struct({ name: u32, shape: u8, count: u8, lowest: u16, highest: u16, values: array(u16, 4) });
/** Memory for an `smr_config`. */
export const CONFIG = array(u32, 32);
const [SWITCH, FRACTION] = [1, 2]; // shapes
const PLAIN_LOOP = 4; // its place in an `smr_config`

export function checkOptions(options = {}) {
  return object(options, "the options", "an object");
}

/** Changes the preset at `config` by the options that are not undefined. Returns all options of the result by name. */
export function useOptions(library, config, method, options) {
  const [given, known] = [Object.entries(options).filter(([, value]) => value !== undefined), settingsOf(library, config)];
  for (const [name, value] of given) {
    if (name === "plainLoop") {
      flag.write(library.memory.view, config + PLAIN_LOOP, value, name);
    } else if (Object.hasOwn(known, name)) {
      library.write("values", [...numbersOf(known[name], value, name), 0, 0, 0, 0].slice(0, 4));
      library.call("smr_set", config, known[name].name, library.at("values"), known[name].count);
    } else {
      throw new TypeError(`the ${method} tracker has no option ${name}: expected ${["plainLoop", ...Object.keys(known)].join(", ")}`);
    }
  }
  const all = Object.entries(settingsOf(library, config)).map(([name, { shape, count, values }]) => {
    const [first] = values;
    return [name, shape === SWITCH ? first !== 0 : count === 1 ? first : values.slice(0, count)];
  });
  return Object.fromEntries([["plainLoop", flag.read(library.memory.view, config + PLAIN_LOOP)], ...all]);
}

function settingsOf(library, config) {
  const settings = {};
  for (let index = 0; library.exports.smr_setting_at(config, index, library.at("setting")) === 0; index++) {
    const setting = library.read("setting");
    settings[library.memory.text(setting.name).replace(/_(.)/g, (_, letter) => letter.toUpperCase())] = setting;
  }
  return settings;
}

function numbersOf({ shape, count, lowest, highest }, value, name) {
  if (count > 1 && (!Array.isArray(value) || value.length !== count)) {
    throw new TypeError(`${name} must be an array of ${count} numbers`);
  }
  const values = count > 1 ? value : [shape === SWITCH && typeof value === "boolean" ? Number(value) : value];
  return values.map((one, i) => whole(one, shape === FRACTION && i === 1 ? Math.max(lowest, 1) : lowest, highest, name));
}
