// The session of a recording, as `host-sim view` keeps it beside the recording: the user's targets and the method.

import { plainName, targetOf, toldOf } from "./edits.js";
import { METHODS } from "./methods.js";

const VERSION = 1;

/** Returns the name that a session calls its recording by: that of the file, without its extension. */
export const stemOf = (name) => name.replace(/(.)\.[^.]*$/, "$1");

/**
 * Formats a session. `checked` are the ranges of frames in which the user has looked at a target, by its id; `madeBy` is
 * the program whose boxes these were; `length` is the known length in the picture, or null.
 */
export function session({ name, using, targets, ids, checked, madeBy, length }) {
  const told = targets.map((target) => toldOf(target, checked.get(target.id)));
  const work = { smr_session: VERSION, recording: stemOf(name), ...using, targets: told, ids, made_by: madeBy, frame: null, ...(length ? { length } : {}) };
  return `${JSON.stringify(work, null, 2)}\n`;
}

/**
 * Parses a session of the recording `name`, whose frames are `width` by `height`. Returns { using, targets, ids, madeBy,
 * length }, or null if the text is something else. Throws the reason if the session cannot be used.
 */
export function parsed(text, { name, width, height }) {
  let work;
  try {
    work = JSON.parse(text);
  } catch {
    return null;
  }
  const { smr_session: version, recording, method, options, targets, ids = 0, made_by: madeBy, length = null } = work ?? {};
  if (version === undefined) {
    return null;
  }
  if (!isSession(work, { width, height })) {
    throw new Error("it is damaged, or of another version: expected a session of host-sim view or this page.");
  }
  if (recording !== stemOf(name)) {
    throw new Error(`it is of ${recording}: open that recording first.`);
  }
  if (!METHODS.includes(method)) {
    throw new Error(`this page has no tracker ${method}: open it in host-sim view.`);
  }
  return { using: { method, options }, targets: targets.map(targetOf).map((target) => ({ ...target, name: plainName(target.name) })), ids, madeBy, length };
}

function isSession({ smr_session: version, method, options, targets, ids = 0, length = null }, size) {
  const isIn = ([x, y, width, height]) => Math.min(x, y) >= 0 && Math.min(width, height) > 0 && x + width <= size.width && y + height <= size.height;
  const isBox = (box) => box === null || (box.length === 4 && box.every(Number.isInteger) && isIn(box));
  const isLock = ({ frame, box }) => isCount(frame) && isBox(box);
  const isTarget = ({ id, name, locks, hidden = [], checked = [] }) =>
    isCount(id) && typeof name === "string" && locks[0].box !== null && locks.every(isLock) && isEach(locks.map(({ frame }) => frame)) && [...hidden, ...checked].every(isRange);
  const isEnd = (x, y) => x >= 0 && y >= 0 && x <= size.width && y <= size.height;
  const isLine = ([x1, y1, x2, y2, ...more]) => [x1, y1, x2, y2].every(Number.isInteger) && isEnd(x1, y1) && isEnd(x2, y2) && more.length === 0;
  const isLength = ({ pixels_per_metre: pixels, line }) => typeof pixels === "number" && pixels >= 1e-6 && pixels <= 1e6 && (line === null || isLine(line));
  try {
    return (
      version === VERSION && typeof method === "string" && isOptions(options) && targets.every(isTarget) && isEach(targets.map(({ id }) => id)) &&
      (ids === 0 || isCount(ids)) && (length === null || isLength(length))
    );
  } catch {
    return false;
  }
}

// True for options that command.js writes.
function isOptions({ set = [], config = "", ...others }) {
  const isWord = (word) => /^[\w.-]*$/.test(word);
  return [...set].every((one) => one.split("=").every(isWord)) && isWord(config) && Object.keys(others).length === 0;
}

const isEach = (values) => new Set(values).size === values.length;

// Numbers of frames and targets end here in host-sim.
const isCount = (value) => Number.isInteger(value) && value > 0 && value < 2 ** 31;

const isRange = ([from, to, ...more]) => isCount(from) && isCount(to) && from <= to && more.length === 0;
