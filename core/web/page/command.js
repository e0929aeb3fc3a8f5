// The words of host-sim's command line that repeat what the page does.

import { SETTINGS } from "./methods.js";

const PARTS = ["size", "sweep", "refiner"];

/** The options of `host-sim track` that differ from its defaults, by name. */
export function optionsOf(method, settings) {
  if (method === "smr") {
    const { config } = settings.smr;
    return config === "paper" ? {} : { config };
  }
  const { reach } = settings.robust;
  const set = PARTS.filter((part) => !settings.robust[part]).map((part) => `${part}=off`);
  const all = reach === SETTINGS.robust.reach ? set : [`reach=${reach}`, ...set];
  return all.length === 0 ? {} : { set: all };
}

/** Options as they are typed. */
export function typed(options) {
  return Object.entries(options).flatMap(([name, value]) => [value].flat().map((one) => `--${name} ${one}`));
}

/** Where targets, { name, locks } each, are locked, as options. */
export function initsOf(targets, isNamed = targets.length > 1) {
  return targets.flatMap(({ name, locks }) => locks.map((lock) => `--init ${isNamed ? `${name}=` : ""}${placed(lock)}`));
}

function placed({ number, box }) {
  const place = box === null ? "gone" : `${box.x},${box.y},${box.width},${box.height}`;
  return number === 1 ? place : `${place}@${number}`;
}

/** A name as a shell takes it. */
export const quoted = (name) => (/^[\w./-]+$/.test(name) && !name.startsWith("-") ? name : `'${name.replaceAll("'", "'\\''")}'`);
