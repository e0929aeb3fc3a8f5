// Errors of calls: the statuses of the C interface with the library's messages, and checks of arguments.

import { WORDS } from "./words.js";

/** An error of a tracker. `status` is the name of the C interface's status. */
export class SmrError extends Error {
  constructor(status, words = WORDS[status] ?? status) {
    super(words);
    this.name = "SmrError";
    this.status = status;
  }
}

/** Returns the error for a saved target whose setting `name` differs from the tracker's. */
export function otherSetting(name) {
  const status = "SMR_ERROR_OTHER_CONFIG";
  return new SmrError(status, WORDS[status].replace("{}", name));
}

/** Returns `value` if it is a whole number from `least` to `most`, else throws. */
export function whole(value, least, most, name) {
  if (typeof value !== "number") {
    throw new TypeError(`${name} must be a number, not ${named(value)}`);
  }
  if (!Number.isInteger(value) || value < least || value > most) {
    throw new RangeError(`${name} must be a whole number from ${least} to ${most}, not ${value}`);
  }
  return value;
}

export function object(value, name, expected) {
  if (typeof value !== "object" || value === null) {
    throw new TypeError(`${name} must be ${expected}, not ${named(value)}`);
  }
  return value;
}

/** Returns the class name of a built-in object. Unlike `instanceof`, it works across realms, such as iframes. */
export function kindOf(value) {
  return Object.prototype.toString.call(value).slice(8, -1);
}

/** Returns the class name of `value` if it is one of `kinds` (byte arrays), else throws. */
export function bytesOf(value, name, kinds) {
  const kind = kindOf(value);
  if (!ArrayBuffer.isView(value) || !kinds.includes(kind)) {
    throw new TypeError(`${name} must be a ${kinds.join(" or a ")}, not ${named(value)}`);
  }
  return kind;
}

/** Formats the type of a value for an error message. */
export function named(value) {
  if (value === null || value === undefined) {
    return String(value);
  }
  const kind = typeof value === "object" ? kindOf(value) : typeof value;
  return `${/^[AEIO]/i.test(kind) ? "an" : "a"} ${kind}`;
}
