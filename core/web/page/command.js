// The command line of host-sim that repeats what the page does.

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

/** `targets`: a list of { name, locks }, each lock { number, box }. `source`: what frames come from, { kind, name }. */
export function commandLine(method, settings, targets, source) {
  const words = typed(optionsOf(method, settings));
  const inits = initsOf(targets);
  if (source.kind === "camera") {
    const first = targets.map(({ name, locks }) => `--init ${targets.length > 1 ? `${name}=` : ""}${placed({ ...locks.at(-1), number: 1 })}`);
    const film = `ffmpeg -v error -f v4l2 -video_size ${source.width}x${source.height} -i /dev/video0 -pix_fmt gray -f yuv4mpegpipe -strict -1 -`;
    return `${film} | ${["host-sim track -", ...first, `--method ${method}`, ...words].join(" ")}`;
  }
  return ["host-sim track", quoted(source.name), ...inits, `--method ${method}`, ...words].join(" ");
}

/** Where targets are locked, as options. */
export function initsOf(targets, isNamed = targets.length > 1) {
  return targets.flatMap(({ name, locks }) => locks.map((lock) => `--init ${isNamed ? `${name}=` : ""}${placed(lock)}`));
}

function placed({ number, box }) {
  const place = box === null ? "gone" : `${box.x},${box.y},${box.width},${box.height}`;
  return number === 1 ? place : `${place}@${number}`;
}

// For a shell.
function quoted(name) {
  return /^[\w./-]+$/.test(name) && !name.startsWith("-") ? name : `'${name.replaceAll("'", "'\\''")}'`;
}
