// The trackers of smr in JavaScript: a wrapper of the C interface (smr.h), compiled to WebAssembly. See README.md.

import { CONFIG, SETTING, checkOptions, useOptions } from "./config.js";
import { SmrError, bytesOf, genuine, kindOf, named, otherSetting, refuseProxies, whole } from "./errors.js";
import { copyWindow, frameOf } from "./frame.js";
import { array, flag, i32, struct, u16, u32, u8 } from "./layout.js";
import { Memory } from "./memory.js";

export { SmrError } from "./errors.js";

/** The names of the states in an answer. */
export const State = Object.freeze({ TRACKING: "tracking", LEAVING: "leaving", UNCERTAIN: "uncertain", LOST: "lost" });

/** Minimum `quality` of a good target, in units of 1/65535: a poorer one may slip along its own texture unnoticed. */
export const POOR_QUALITY = 1023;

// The states by their values in the C enum `smr_state`.
const STATES = Object.values(State);
const CONFIGS = {
  paper: { camera: "smr_config_camera", paper: "smr_config_paper" },
  robust: { refined: "smr_config_refined", robust: "smr_config_robust", small: "smr_config_small", smallRefined: "smr_config_small_refined" },
};

const RECT = struct({ x: i32, y: i32, width: u16, height: u16 });
const FINE_RECT = struct({ x: i32, y: i32, width: u32, height: u32 });
const PART = struct({ pixels: u32, size: u32, stride: u32, width: u16, height: u16, x: u16, y: u16 });
const NO_PART = { pixels: 0, size: 0, stride: 0, width: 0, height: 0, x: 0, y: 0 };
const ANSWER = struct({
  bbox: RECT,
  fine: FINE_RECT,
  state: i32,
  scale: u32,
  confidence: u16,
  ratio: u16,
  runnerUpRatio: u16,
  alpha: u16,
  identity: u16,
  hasRunnerUp: flag,
  hasIdentity: flag,
  foundAgain: flag,
});
const RESPONSE_SPAN = 17;
const SAVED_HEAD = 14;
// Scratch memory for the arguments and results of a call.
const CALL = struct({
  frame: struct({ width: u16, height: u16, parts: array(PART, 2) }),
  answer: ANSWER,
  windows: array(RECT, 2),
  box: RECT,
  fine: FINE_RECT,
  number: u32,
  short: u16,
  state: i32,
  image: struct({ pixels: u32, width: u16, height: u16 }),
  config: CONFIG,
  setting: SETTING,
  values: array(u16, 4),
  head: array(u8, SAVED_HEAD),
  responses: array(array(i32, RESPONSE_SPAN), RESPONSE_SPAN),
});
// Memory for a flight record; the first five fields belong to the library.
const SINK = struct({ write: u32, context: u32, entries: u32, flags: u32, tracker: u32, bytes: u32, size: u32, used: u32 });
// Upper bound in bytes of a flight record's first entry; also of what one update adds to the record besides pixels.
const MAX_AROUND = 1024;
// Granularity in bytes of memory for windows, so that windows of changing size do not fragment the memory.
const PIXELS_STEP = 65536;
const MAX_I32 = 2 ** 31 - 1;
// Largest saved target of any build, in bytes: SMR_PAPER_SAVED_SIZE with the largest SMR_PIXELS.
const MAX_SAVED = 65537 + 94;
const NODE_FILES = ["node:fs", "promises"];
// Address of the enclosing script, if a bundler has turned this module into a classic script; empty for one in the page.
const SCRIPT = globalThis.document?.currentScript?.src;
const WHAT_TO_GIVE = "give load() the bytes or the address of smr.wasm";

// A module with one instruction of SIMD128, which is invalid for an engine without SIMD128.
const SIMD_PROBE = [0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11];

/** True if the JavaScript engine supports WebAssembly's SIMD128. */
export function hasSimd() {
  return WebAssembly.validate(new Uint8Array(SIMD_PROBE));
}

/** Loads the library from a WebAssembly.Module, bytes, a Response or a URL; by default from a file beside this one. */
export async function load(source) {
  return new Smr(await WebAssembly.instantiate(await moduleOf(source ?? ownModule()), {}));
}

// Rounds the sides of a box, because mouse coordinates have fractions.
const rounded = (box) => Object.fromEntries(Object.keys(RECT.fields).map((side) => [side, typeof box?.[side] === "number" ? Math.round(box[side]) : box?.[side]]));
const pixelsOf = (windows) => windows.reduce((sum, { width, height }) => sum + width * height, 0);

// Nothing lies beside the code of a blob, of a data: URL or in a page: such an address is no base of another one.
function ownModule() {
  try {
    if (import.meta.url !== undefined) {
      // Each URL is a literal, because bundlers search for `new URL("...")` and cannot evaluate a condition in it.
      return hasSimd() ? new URL("./smr-simd.wasm", import.meta.url) : new URL("./smr.wasm", import.meta.url);
    }
    return new URL(hasSimd() ? "smr-simd.wasm" : "smr.wasm", SCRIPT);
  } catch {
    throw new TypeError(`this code does not know an address beside which smr.wasm lies: ${WHAT_TO_GIVE}`);
  }
}

// A worker made of a blob, for example, has no base for a relative address.
function absolute(address) {
  try {
    return new URL(address, globalThis.document?.baseURI ?? globalThis.location?.href).href;
  } catch {
    throw new TypeError(`${address} is a relative address, which leads nowhere from here: expected one like https://example.org/smr.wasm`);
  }
}

async function moduleOf(source) {
  return kindOf(source) === "WebAssembly.Module" ? source : WebAssembly.compile(await moduleBytes(source));
}

async function moduleBytes(source) {
  const kind = kindOf(source);
  if (ArrayBuffer.isView(source) || kind === "ArrayBuffer") {
    return source;
  }
  if (kind === "Response") {
    return responded(source);
  }
  if (kind !== "String" && kind !== "URL") {
    throw new TypeError(`load takes a WebAssembly.Module, bytes, a Response or an address, not ${named(source)}`);
  }
  return fetched(String(source));
}

// Loads the bytes at an address; files are read by `node:fs`, because Node's `fetch` does not load them.
async function fetched(address) {
  if (typeof process !== "undefined" && process.versions?.node !== undefined && !/^(https?|data|blob):/.test(address)) {
    // The module's name is joined at run time, because bundlers resolve literal names and lack `node:fs/promises`.
    const { readFile } = await import(/* webpackIgnore: true */ /* @vite-ignore */ NODE_FILES.join("/"));
    return readFile(address.startsWith("file:") ? new URL(address) : address);
  }
  return responded(await fetch(absolute(address)));
}

async function responded(response) {
  if (!response.ok) {
    throw new Error(`cannot load ${response.url}: ${response.status} ${response.statusText}`);
  }
  // A development server replies with its HTML page for a file that does not exist.
  const kind = response.headers.get("content-type") ?? "";
  if (kind.startsWith("text/html")) {
    throw new Error(`cannot load ${response.url}: expected WebAssembly, found ${kind}: see "Loading" in the README of smr-tracker`);
  }
  return response.arrayBuffer();
}

/** One instance of the library, with its own memory. */
export class Smr {
  /** True if the library uses SIMD128. */
  simd;
  #library;

  constructor(instance) {
    genuine(this);
    this.#library = new Library(instance.exports);
    this.simd = instance.exports.smr_simd() !== 0;
  }

  get version() {
    return this.#library.memory.text(this.#library.exports.smr_version());
  }

  /** Bytes of the library's memory. It grows only with more trackers, larger windows or larger saved targets. */
  get memory() {
    return this.#library.memory.bytes.length;
  }

  /** Creates a tracker of the paper. */
  paper(options) {
    const { preset = "camera", ...numbers } = checkOptions(options);
    return new Tracker(this.#library, "paper", preset, numbers);
  }

  /** Creates a robust tracker. */
  robust(options) {
    const { preset = "refined", ...numbers } = checkOptions(options);
    return new Tracker(this.#library, "robust", preset, numbers);
  }
}
refuseProxies(Smr, "library");

// Calls and memory of the WebAssembly module, shared by all trackers of an instance.
class Library {
  exports;
  memory;
  #scratch;
  /** Frees the memory of a tracker that was garbage-collected without a call of `free`. */
  left = new FinalizationRegistry((own) => this.give(own));
  #workspaces = {}; // by size in bytes, which tells the methods and their sizes apart
  #pixels = { at: 0, size: 0 };

  constructor(exports) {
    if (exports.smr_update === undefined || exports.memory === undefined) {
      throw new TypeError("the WebAssembly module is not smr's");
    }
    this.exports = exports;
    this.memory = new Memory(exports.memory, exports.__heap_base.value);
    this.#scratch = this.memory.take(CALL.size);
  }

  /** Calls the C function `name` and throws unless it returns SMR_OK. */
  call(name, ...values) {
    const status = this.exports[name](...values);
    if (status !== 0) {
      throw new SmrError(this.memory.text(this.exports.smr_status_name(status)));
    }
  }

  give(own) {
    [own.storage, own.sink, own.bytes].forEach((at) => this.memory.give(at));
    Object.assign(own, { storage: 0, sink: 0, bytes: 0, size: 0 });
  }

  /** Returns the address of the workspace that all trackers with workspaces of this size share. */
  workspace(size) {
    this.#workspaces[size] ??= this.memory.take(size);
    return this.#workspaces[size];
  }

  /** Returns the address of memory for `size` pixels, valid until the next call of this method. */
  pixels(size) {
    if (this.#pixels.size < size) {
      this.memory.give(this.#pixels.at);
      this.#pixels = { at: 0, size: 0 };
      const room = Math.ceil(size / PIXELS_STEP) * PIXELS_STEP;
      this.#pixels = { at: this.memory.take(room), size: room };
    }
    return this.#pixels.at;
  }

  at(name) {
    return this.#scratch + CALL.places[name];
  }

  /** Reads a field of CALL after a call. */
  read(name) {
    return CALL.fields[name].read(this.memory.view, this.at(name));
  }

  /** Writes a field of CALL before a call. `called` is its name in an error message. */
  write(name, value, called = `the ${name}`) {
    CALL.fields[name].write(this.memory.view, this.at(name), value, called);
  }
}

/** A tracker of one target, created by `paper()` or `robust()` of `Smr`. */
export class Tracker {
  /** "paper" or "robust". */
  method;
  /** "camera" or "paper" for a tracker of the paper; "refined", "robust", "small" or "smallRefined" for a robust one. */
  preset;
  /** All options, with the values of the preset for those not given. */
  options;
  /** Answer of the last update; null before the first update and after a lock. */
  answer = null;
  #library;
  #at = 0;
  #takers = new Set(); // of the record
  #own = { storage: 0, sink: 0, bytes: 0, size: 0 }; // memory: the tracker's, and that for a record
  #head = null; // what the record begins with, as long as nothing follows

  constructor(library, method, preset, options) {
    if (!(library instanceof Library)) {
      throw new TypeError("make a tracker with paper() or robust() of what load() returns");
    }
    genuine(this);
    this.#library = library;
    this.method = method;
    this.preset = preset;
    if (!Object.hasOwn(CONFIGS[method], preset)) {
      throw new TypeError(`preset must be ${Object.keys(CONFIGS[method]).join(" or ")}, not ${String(preset)}`);
    }
    const { memory, exports } = library;
    const config = library.at("config");
    library.call(CONFIGS[method][preset], config);
    this.options = useOptions(library, config, method, options);
    const size = exports.smr_target_size(config);
    const room = exports.smr_workspace_size(config);
    const workspace = library.workspace(room);
    this.#own.storage = memory.take(size);
    library.left.register(this, this.#own, this);
    try {
      library.call("smr_init", this.#own.storage, size, workspace, room, config, library.at("number"));
    } catch (error) {
      this.free();
      throw error;
    }
    this.#at = library.read("number");
  }

  /** Locks on the target in `box`, rounded to whole pixels. Returns the quality, which is poor below POOR_QUALITY. */
  lock(frame, box) {
    this.#live();
    const given = frameOf(frame);
    const { width, height } = given;
    const library = this.#library;
    library.write("box", rounded(box));
    const lock = () => library.call("smr_lock", this.#at, library.at("frame"), library.at("box"));
    const [window] = this.#get("smr_lock_window", "windows", width, height, library.at("box"));
    try {
      // First tries to lock with one pixel of the frame, to refuse invalid arguments before memory is allocated.
      library.write("frame", { width, height, parts: [{ ...NO_PART, pixels: library.at("head"), size: 1, stride: 1, width: 1, height: 1 }, NO_PART] });
      if (window.width * window.height > 1) {
        lock();
      }
    } catch (error) {
      if (error.status !== "SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY") {
        throw error;
      }
    }
    const windows = this.#show(given, [window]);
    this.#recorded(pixelsOf(windows), lock);
    this.answer = null;
    return this.quality;
  }

  /** Tracks the target in the next frame and returns the answer. */
  update(frame) {
    this.#live();
    const given = frameOf(frame);
    const windows = this.#showWindows(given);
    const update = () => this.#get("smr_update", "answer", this.#library.at("frame"));
    this.answer = this.#answerOf(this.#recorded(pixelsOf(windows), update));
    return this.answer;
  }

  /** Informs the tracker of a camera motion that moved the picture by this many 1/256 pixels. */
  moved(right, down) {
    this.#live();
    whole(right, -MAX_I32, MAX_I32, "right");
    whole(down, -MAX_I32, MAX_I32, "down");
    this.#recorded(0, () => this.#library.call("smr_moved", this.#at, right, down));
  }

  /** Saves the target as bytes. */
  save() {
    this.#live();
    const size = this.#get("smr_saved_size", "number");
    const bytes = this.#library.pixels(size);
    return this.#library.memory.copy(bytes, this.#get("smr_save", "number", bytes, size));
  }

  /** Continues with a saved target. */
  restore(saved) {
    this.#live();
    bytesOf(saved, "a saved target", ["Uint8Array"]);
    try {
      // Bytes that are not a saved target are refused by their header, before memory is allocated.
      this.#restore(saved.subarray(0, SAVED_HEAD), this.#library.at("head"));
    } catch (error) {
      if (error.status !== "SMR_ERROR_TRUNCATED") {
        throw error;
      }
    }
    const all = saved.subarray(0, MAX_SAVED);
    this.#recorded(all.length, () => this.#restore(all, this.#library.pixels(all.length)));
    this.answer = null;
  }

  #restore(saved, at) {
    const { memory } = this.#library;
    memory.bytes.set(saved, at);
    try {
      this.#library.call("smr_restore", this.#at, at, saved.length);
    } catch (error) {
      throw error.status === "SMR_ERROR_OTHER_CONFIG" ? otherSetting(memory.text(this.#get("smr_other_setting", "number", at, saved.length))) : error;
    }
  }

  /** Box and state of the target from the last answer, the lock or the saved target; null without a target. */
  get last() {
    const state = this.#ask("smr_last", "state", this.#library.at("fine"));
    return state === null ? null : { fineBox: this.#library.read("fine"), state: STATES[state] };
  }

  /** Distinctness of the target from shifted copies at the lock, in units of 1/65535; null without a target. */
  get quality() {
    return this.#ask("smr_quality", "short");
  }

  /** The rectangle of pixels that the next update reads; null without a target. */
  get window() {
    return this.#ask("smr_windows", "windows")?.[0] ?? null;
  }

  /** A second window, in which the robust tracker searches for a lost target; null if there is none. */
  get sweepWindow() {
    const window = this.#ask("smr_windows", "windows")?.[1];
    return window?.width > 0 ? window : null;
  }

  /** Template { width, height, pixels } (robust tracker: its slowly learned early template); null without a target. */
  get template() {
    this.#live();
    // A buffer of a saved target's size has room for the template, which a saved target contains.
    const size = this.#get("smr_saved_size", "number");
    const image = this.#ask("smr_template", "image", this.#library.pixels(size), size);
    return image === null ? null : { ...image, pixels: this.#library.memory.copy(image.pixels, image.width * image.height) };
  }

  /**
   * Returns the robust tracker's responses in `frame` as the next update would compute them, in units of 1/16384:
   * { span, responses }, `span` by `span` values row by row, one for each cell of the search.
   */
  responseMap(frame) {
    this.#live();
    this.#showWindows(frameOf(frame));
    const span = 2 * this.options.reach + 1;
    const rows = this.#get("smr_response_map", "responses", this.#library.at("frame")).slice(0, span);
    return { span, responses: Int32Array.from(rows.flatMap((row) => row.slice(0, span))) };
  }

  /** Calls `take(bytes, begins)` with each piece of the flight record; `begins` is true for a record's first piece. */
  record(take) {
    this.#live();
    if (typeof take !== "function") {
      throw new TypeError(`take must be a function, not ${named(take)}`);
    }
    this.#takers.add(take);
    if (this.#head === null) {
      this.beginRecord();
    } else {
      take(this.#head, true);
    }
  }

  /** Stops calling `take` with pieces of the flight record. */
  unrecord(take) {
    this.#takers.delete(take);
    if (this.#takers.size === 0 && this.#at !== 0) {
      this.#library.call("smr_record", this.#at, 0);
      this.#head = null;
    }
  }

  /** Restarts the flight record with the current target, so that later pieces do not depend on earlier ones. */
  beginRecord() {
    this.#live();
    const saved = this.last === null ? null : this.save();
    this.#room(saved === null ? 0 : saved.length);
    this.#library.call("smr_record_to_memory", this.#at, this.#own.sink);
    if (saved !== null) {
      this.#restore(saved, this.#library.pixels(saved.length));
    }
    this.#head = this.#written();
    [...this.#takers].forEach((take) => take(this.#head, true));
  }

  // Performs `call`, which adds at most `size` + MAX_AROUND bytes to the flight record, and passes the added bytes to
  // all functions given to `record`.
  #recorded(size, call) {
    if (this.#takers.size === 0) {
      return call();
    }
    this.#room(size);
    try {
      return call();
    } finally {
      const piece = this.#written();
      if (piece.length > 0) {
        this.#head = null;
        [...this.#takers].forEach((take) => take(piece, false));
      }
    }
  }

  #written() {
    const { memory } = this.#library;
    return memory.copy(this.#own.bytes, SINK.fields.used.read(memory.view, this.#own.sink + SINK.places.used));
  }

  // Clears the memory of the flight record, and enlarges it if it is smaller than `size` + MAX_AROUND bytes.
  #room(size) {
    const { memory } = this.#library;
    const own = this.#own;
    if (own.sink === 0) {
      own.sink = memory.take(SINK.size);
      memory.bytes.fill(0, own.sink, own.sink + SINK.size);
    }
    if (own.size < size + MAX_AROUND) {
      memory.give(own.bytes);
      own.size = Math.ceil((size + MAX_AROUND) / PIXELS_STEP) * PIXELS_STEP;
      own.bytes = memory.take(own.size);
    }
    for (const [name, value] of Object.entries({ bytes: own.bytes, size: own.size, used: 0 })) {
      SINK.fields[name].write(memory.view, own.sink + SINK.places[name], value, name);
    }
  }

  /** Frees the tracker's memory. Later calls throw. */
  free() {
    this.#library.left.unregister(this);
    this.#library.give(this.#own);
    this.#at = 0;
    this.#takers.clear();
  }

  /** Supports `using tracker = smr.robust()`, which frees the tracker at the end of the block. */
  [Symbol.dispose ?? Symbol.for("dispose")]() {
    this.free();
  }

  #live() {
    if (this.#at === 0) {
      throw new SmrError("SMR_ERROR_NOT_INITIALISED", "the tracker was freed");
    }
  }

  // Calls the C function `name` with the address of the field `part` of CALL as its last argument, and reads that
  // field.
  #get(name, part, ...values) {
    this.#library.call(name, this.#at, ...values, this.#library.at(part));
    return this.#library.read(part);
  }

  // Returns the same as `#get`, but null if no target is locked.
  #ask(...of) {
    this.#live();
    try {
      return this.#get(...of);
    } catch (error) {
      if (error instanceof SmrError && error.status === "SMR_ERROR_NOT_LOCKED") {
        return null;
      }
      throw error;
    }
  }

  #showWindows(given) {
    return this.#show(given, this.#get("smr_windows", "windows"));
  }

  // Copies the gray pixels of the windows into the library's memory, and writes a frame that consists of them. Returns
  // the windows with their pixels, which are valid until the next call.
  #show(given, windows) {
    const shown = windows.filter(({ width, height }) => width * height > 0);
    // Windows lie within the frame of the lock, so a frame that does not contain them is smaller than that frame.
    if (shown.some(({ x, y, width, height }) => x + width > given.width || y + height > given.height)) {
      throw new SmrError("SMR_ERROR_FRAME_SIZE_CHANGED");
    }
    let pixels = this.#library.pixels(shown.reduce((sum, { width, height }) => sum + width * height, 0));
    const { bytes } = this.#library.memory;
    const parts = [NO_PART, NO_PART];
    shown.forEach((window, i) => {
      parts[i] = { ...window, pixels, size: window.width * window.height, stride: window.width };
      pixels += parts[i].size;
    });
    this.#library.write("frame", { width: given.width, height: given.height, parts });
    return shown.map((window, i) => {
      const to = bytes.subarray(parts[i].pixels, parts[i].pixels + parts[i].size);
      copyWindow(given, window, to);
      return { ...window, pixels: to };
    });
  }

  #answerOf({ bbox, fine, state, confidence, ratio, runnerUpRatio, alpha, identity, scale, hasRunnerUp, hasIdentity, foundAgain }) {
    return {
      box: bbox,
      fineBox: fine,
      state: STATES[state],
      confidence,
      ratio,
      runnerUpRatio: hasRunnerUp ? runnerUpRatio : null,
      alpha: alpha === 0 ? null : alpha,
      identity: hasIdentity ? identity : null,
      scale,
      foundAgain,
      work: this.#get("smr_work", "number"),
    };
  }
}
refuseProxies(Tracker, "tracker");
