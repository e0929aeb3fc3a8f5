// The errors of a call: the statuses of the C interface, with the texts of the library's errors.

import { WORDS } from "./words.js";

/** An error of a tracker. `status` is the name of the C interface's status. */
export class SmrError extends Error {
  constructor(status, words = WORDS[status] ?? status) {
    super(words);
    this.name = "SmrError";
    this.status = status;
  }
}

/** The error of a saved target that was refused because of a setting. */
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

/** Returns `value` if it is an object, else throws. */
export function object(value, name, expected) {
  if (typeof value !== "object" || value === null) {
    throw new TypeError(`${name} must be ${expected}, not ${named(value)}`);
  }
  return value;
}

/** The name of the class of a built-in object. Unlike `instanceof` it knows those of another realm: a frame, a context of Node. */
export function kindOf(value) {
  return Object.prototype.toString.call(value).slice(8, -1);
}

/** Returns the kind of `value` if it is one of these arrays of bytes, else throws. */
export function bytesOf(value, name, kinds) {
  const kind = kindOf(value);
  if (!ArrayBuffer.isView(value) || !kinds.includes(kind)) {
    throw new TypeError(`${name} must be a ${kinds.join(" or a ")}, not ${named(value)}`);
  }
  return kind;
}

/** The text of a value in the message of an error. */
export function named(value) {
  if (value === null || value === undefined) {
    return String(value);
  }
  const kind = typeof value === "object" ? kindOf(value) : typeof value;
  return `${/^[AEIO]/i.test(kind) ? "an" : "a"} ${kind}`;
}
