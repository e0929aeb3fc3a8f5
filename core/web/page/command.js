// Builds arguments of host-sim's command line from the state of the page.

import { SETTINGS } from "./methods.js";

/** Returns the options of `host-sim track` that differ from its defaults, by name. */
export function optionsOf(method, settings) {
  if (method === "paper") {
    const { config } = settings.paper;
    return config === "paper" ? {} : { config };
  }
  const changed = Object.entries(SETTINGS.robust).map(([name, usual]) => [name, settings.robust[name], usual]).filter(([, is, usual]) => is !== usual);
  return changed.length === 0 ? {} : { set: changed.map(([name, is]) => `${name}=${is === false ? "off" : is}`) };
}

/** Formats options as arguments: `--name value`. */
export function typed(options) {
  return Object.entries(options).flatMap(([name, value]) => [value].flat().map((one) => `--${name} ${one}`));
}

/** Formats the locks of targets { name, locks } as options `--init`. */
export function initsOf(targets, isNamed = targets.length > 1) {
  return targets.flatMap(({ name, locks }) => locks.map((lock) => `--init ${isNamed ? `${name}=` : ""}${placed(lock)}`));
}

function placed({ number, box }) {
  const place = box === null ? "gone" : `${box.x},${box.y},${box.width},${box.height}`;
  return number === 1 ? place : `${place}@${number}`;
}

export const quoted = (name) => (/^[\w./-]+$/.test(name) && !name.startsWith("-") ? name : `'${name.replaceAll("'", "'\\''")}'`);
