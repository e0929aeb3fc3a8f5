// The settings in the words of host-sim: as a TOML file for `--settings`, and as the command line that does the same as
// the page.

import { SETTINGS } from "./methods.js";

const PARTS = ["size", "sweep", "refiner"];

/** The options of `host-sim track` that differ from its defaults, by name. */
export function optionsOf(method, settings) {
  if (method === "smr") {
    const { config } = settings.smr;
    return config === "paper" ? {} : { config };
  }
  const { reach } = settings.robust;
  const without = PARTS.filter((part) => !settings.robust[part]);
  return { ...(reach === SETTINGS.robust.reach ? {} : { reach }), ...(without.length === 0 ? {} : { without }) };
}

export function toml(method, settings) {
  const lines = Object.entries({ method, ...optionsOf(method, settings) }).map(([name, value]) => `${name} = ${JSON.stringify(value)}\n`);
  return lines.join("");
}

/**
 * The command line. `targets`: a list of { name, locks }, each lock { number, box }. `source`: where the frames come
 * from, { kind, name }.
 */
export function commandLine(method, settings, targets, source) {
  const words = Object.entries(optionsOf(method, settings)).map(([name, value]) => `--${name} ${value}`);
  const inits = targets.flatMap(({ name, locks }) => locks.map((lock) => `--init ${targets.length > 1 ? `${name}=` : ""}${placed(lock)}`));
  if (source.kind === "camera") {
    const first = targets.map(({ name, locks }) => `--init ${targets.length > 1 ? `${name}=` : ""}${placed({ ...locks.at(-1), number: 1 })}`);
    const film = `ffmpeg -v error -f v4l2 -video_size ${source.width}x${source.height} -i /dev/video0 -pix_fmt gray -f yuv4mpegpipe -strict -1 -`;
    return `${film} | ${["host-sim track -", ...first, `--method ${method}`, ...words].join(" ")}`;
  }
  return ["host-sim track", quoted(source.name), ...inits, `--method ${method}`, ...words].join(" ");
}

function placed({ number, box: { x, y, width, height } }) {
  return `${x},${y},${width},${height}${number === 1 ? "" : `@${number}`}`;
}

// Quotes a word for a shell.
function quoted(name) {
  return /^[\w./-]+$/.test(name) && !name.startsWith("-") ? name : `'${name.replaceAll("'", "'\\''")}'`;
}
