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

const GENUINE = new WeakSet();

/** Records that `object` is no Proxy; for constructors. */
export function genuine(object) {
  GENUINE.add(object);
}

/**
 * Makes the methods and getters of a class, called `name` in messages, refuse a Proxy: it has no private fields, and the
 * engine's message does not say what to do. The tag keeps Vue from making a Proxy by itself.
 */
export function refuseProxies(of, name) {
  const members = Reflect.ownKeys(of.prototype).filter((key) => key !== "constructor");
  for (const key of members) {
    const described = Object.getOwnPropertyDescriptor(of.prototype, key);
    for (const kind of ["value", "get"].filter((kind) => described[kind] !== undefined)) {
      const call = described[kind];
      described[kind] = function (...values) {
        if (!GENUINE.has(this)) {
          throw new TypeError(refusal(this instanceof of, name, kind === "get" ? key : `${String(key)}()`));
        }
        return call.apply(this, values);
      };
    }
    Object.defineProperty(of.prototype, key, described);
  }
  Object.defineProperty(of.prototype, Symbol.toStringTag, { value: `Smr ${name}`, configurable: true });
}

function refusal(isProxy, name, member) {
  return isProxy
    ? `${member} needs the ${name} itself, not a Proxy of it: keep the ${name} in a shallowRef or by markRaw (Vue), or outside of the reactive state`
    : `${member} needs its ${name}: call it as a method, as in ${name}.${member}`;
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
