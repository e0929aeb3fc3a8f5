// The trackers of smr in JavaScript: conversions over the C interface (smr.h), which is compiled to WebAssembly.
// README.md describes them.

import { CONFIG_SIZE, PAPER_SCALE, TABLE, checkOptions, readOptions, writeOptions } from "./config.js";
import { SmrError, named, object, otherSetting, whole } from "./errors.js";
import { copyWindow, frameOf } from "./frame.js";
import { Memory } from "./memory.js";

export { SmrError } from "./errors.js";

/** The names of the states in an answer. */
export const State = Object.freeze({ TRACKING: "tracking", LEAVING: "leaving", UNCERTAIN: "uncertain", LOST: "lost" });

/** A target with a lower quality can hardly be told from its surroundings. */
export const POOR_QUALITY = 1023;

// The states by their numbers in `smr_state`.
const STATES = [State.TRACKING, State.LEAVING, State.UNCERTAIN, State.LOST];
const CONFIGS = { paper: { camera: "smr_config_camera", paper: "smr_config_paper" }, robust: { refined: "smr_config_refined", robust: "smr_config_robust" } };

// The memory of a call, and the places of its parts. Sizes are those of smr.h on 32 bits.
const FRAME = 0; // smr_frame, 44 bytes: width, height, two parts
const PARTS = [4, 24]; // smr_part: pixels, size, stride, width, height, x, y
const ANSWER = 48; // smr_answer, 48 bytes
const WINDOWS = [96, 112]; // smr_rect, 12 bytes: x, y, width, height
const BOX = 128; // smr_rect
const FINE = 144; // smr_fine_rect, 16 bytes
const NUMBER = 160; // 4 bytes
const IMAGE = 168; // smr_image, 8 bytes: pixels, width, height
const CONFIG = 176; // smr_config
const RESPONSES = 256; // 17 * 17 numbers of 4 bytes
const RESPONSE_SPAN = 17;
const SCRATCH_SIZE = RESPONSES + 4 * RESPONSE_SPAN * RESPONSE_SPAN;
const TABLE_ENTRIES = 256;
const EARLY_PIXELS = 1600; // SMR_ROBUST_PIXELS
// Memory for windows is taken in steps, so that windows of changing size do not scatter the memory.
const PIXELS_STEP = 65536;
const MOST_I32 = 2 ** 31 - 1;

// A module with one instruction of SIMD128. An engine that cannot run it says that it is not valid.
const SIMD_PROBE = [0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11];

/** True if the engine has SIMD128. */
export function hasSimd() {
  return WebAssembly.validate(new Uint8Array(SIMD_PROBE));
}

/**
 * The library, from a WebAssembly.Module, its bytes, a Response, or an address. By default: the file beside this one
 * that is faster here.
 */
export async function load(source) {
  const file = source ?? new URL(hasSimd() ? "./smr-simd.wasm" : "./smr.wasm", import.meta.url);
  return new Smr(await WebAssembly.instantiate(await moduleOf(file), {}));
}

async function moduleOf(source) {
  if (source instanceof WebAssembly.Module) {
    return source;
  }
  return WebAssembly.compile(await bytesOf(source));
}

async function bytesOf(source) {
  if (source instanceof ArrayBuffer || ArrayBuffer.isView(source)) {
    return source;
  }
  if (typeof source === "string" || source instanceof URL) {
    return fetched(source);
  }
  if (typeof Response === "function" && source instanceof Response) {
    return responded(source);
  }
  throw new TypeError(`load takes a WebAssembly.Module, bytes, a Response or an address, not ${named(source)}`);
}

// Node fetches no files.
async function fetched(address) {
  if (typeof process !== "undefined" && process.versions?.node !== undefined && !/^https?:/.test(address)) {
    const { readFile } = await import("node:fs/promises");
    return readFile(address);
  }
  return responded(await fetch(address));
}

async function responded(response) {
  if (!response.ok) {
    throw new Error(`cannot load ${response.url}: ${response.status} ${response.statusText}`);
  }
  return response.arrayBuffer();
}

/** One instance of the library, with a memory of its own. */
export class Smr {
  /** True if the library uses SIMD128. */
  simd;
  #library;

  constructor(instance) {
    this.#library = new Library(instance.exports);
    this.simd = instance.exports.smr_simd() !== 0;
  }

  /** The version of the library. */
  get version() {
    return this.#library.memory.text(this.#library.exports.smr_version());
  }

  /** Bytes of the library's memory. It grows only with the number of trackers and the largest window. */
  get memory() {
    return this.#library.memory.bytes.length;
  }

  /** Makes a tracker of the paper. */
  paper(options) {
    const { preset = "camera", scale, ...numbers } = checkOptions(options);
    return new Tracker(this.#library, "paper", preset, scale, numbers);
  }

  /** Makes a robust tracker. */
  robust(options) {
    const { preset = "refined", ...numbers } = checkOptions(options);
    return new Tracker(this.#library, "robust", preset, undefined, numbers);
  }

  /** The similarities of two pixels by their difference, in units of 1/65535. */
  table(scale = PAPER_SCALE) {
    return this.#library.similarities(scale);
  }
}

// The calls and the memory of the module, for all trackers of an instance.
class Library {
  exports;
  memory;
  scratch;
  #workspaces = {}; // by method
  #pixels = { at: 0, size: 0 };

  constructor(exports) {
    if (exports.smr_update === undefined || exports.memory === undefined) {
      throw new TypeError("the WebAssembly module is not smr's");
    }
    this.exports = exports;
    this.memory = new Memory(exports.memory, exports.__heap_base.value);
    this.scratch = this.memory.take(SCRATCH_SIZE);
  }

  /** Calls smr_`name` and throws unless it returns SMR_OK. */
  call(name, ...values) {
    const status = this.exports[name](...values);
    if (status !== 0) {
      throw new SmrError(this.memory.text(this.exports.smr_status_name(status)));
    }
  }

  /** The address of a block with the table of `scale`. */
  table(scale) {
    whole(scale, 0, 65535, "scale");
    const at = this.memory.take(2 * TABLE_ENTRIES);
    try {
      this.call("smr_table_init", at, scale);
    } catch (error) {
      this.memory.give(at);
      throw error;
    }
    return at;
  }

  /** The entries of the table of `scale`. */
  similarities(scale) {
    const at = this.table(scale);
    const { buffer } = this.memory.copy(at, 2 * TABLE_ENTRIES);
    this.memory.give(at);
    return new Uint16Array(buffer);
  }

  /** The workspace that all trackers of a method share. */
  workspace(method, size) {
    this.#workspaces[method] ??= { at: this.memory.take(size), size };
    return this.#workspaces[method];
  }

  /** The address of memory for `size` pixels, valid until the next call. */
  pixels(size) {
    if (this.#pixels.size < size) {
      this.memory.give(this.#pixels.at);
      this.#pixels = { at: 0, size: 0 };
      const room = Math.ceil(size / PIXELS_STEP) * PIXELS_STEP;
      this.#pixels = { at: this.memory.take(room), size: room };
    }
    return this.#pixels.at;
  }

  rect(at) {
    const { view } = this.memory;
    return {
      x: view.getInt32(at, true),
      y: view.getInt32(at + 4, true),
      width: view.getUint16(at + 8, true),
      height: view.getUint16(at + 10, true),
    };
  }

  fineRect(at) {
    const { view } = this.memory;
    return {
      x: view.getInt32(at, true),
      y: view.getInt32(at + 4, true),
      width: view.getUint32(at + 8, true),
      height: view.getUint32(at + 12, true),
    };
  }

  image() {
    const at = this.scratch + IMAGE;
    const { view } = this.memory;
    const [width, height] = [view.getUint16(at + 4, true), view.getUint16(at + 6, true)];
    return { width, height, pixels: this.memory.copy(view.getUint32(at, true), width * height) };
  }
}

/** Follows one target. The methods `paper` and `robust` of the library make it. */
export class Tracker {
  /** "paper" or "robust". */
  method;
  /** "camera" or "paper"; "refined" or "robust" for a robust tracker. */
  preset;
  /** All options, with the numbers of the preset where none was given. */
  options;
  /** The answer of the last update; null before it. */
  answer = null;
  #library;
  #storage = 0;
  #table = 0;
  #at = 0;
  #observers = new Set();

  constructor(library, method, preset, scale, options) {
    if (!(library instanceof Library)) {
      throw new TypeError("make a tracker with paper() or robust() of what load() returns");
    }
    this.#library = library;
    this.method = method;
    this.preset = preset;
    try {
      this.#make(scale, options);
    } catch (error) {
      this.free();
      throw error;
    }
  }

  #make(scale, options) {
    const { memory, exports, scratch } = this.#library;
    const config = scratch + CONFIG;
    if (!Object.hasOwn(CONFIGS[this.method], this.preset)) {
      throw new TypeError(`preset must be ${Object.keys(CONFIGS[this.method]).join(" or ")}, not ${String(this.preset)}`);
    }
    memory.bytes.fill(0, config, config + CONFIG_SIZE);
    this.#library.call(CONFIGS[this.method][this.preset], config);
    writeOptions(memory.view, config, this.method, options);
    this.options = readOptions(memory.view, config, this.method);
    if (this.method === "paper") {
      this.options.scale = scale ?? PAPER_SCALE;
    }
    if (scale !== undefined && scale !== PAPER_SCALE) {
      this.#table = this.#library.table(scale);
      memory.view.setUint32(config + TABLE, this.#table, true);
    }
    const size = exports.smr_target_size(config);
    const workspace = this.#library.workspace(this.method, exports.smr_workspace_size(config));
    this.#storage = memory.take(size);
    const pointer = scratch + NUMBER;
    this.#library.call("smr_init", this.#storage, size, workspace.at, workspace.size, config, pointer);
    this.#at = memory.view.getUint32(pointer, true);
  }

  /** Locks on the target in `box`. Returns the quality, which is poor below POOR_QUALITY. */
  lock(frame, box) {
    this.#live();
    const given = frameOf(frame);
    const { scratch } = this.#library;
    this.#writeBox(box);
    this.#library.call("smr_lock_window", this.#at, given.width, given.height, scratch + BOX, scratch + WINDOWS[0]);
    const windows = this.#show(given, [this.#library.rect(scratch + WINDOWS[0])]);
    this.#library.call("smr_lock", this.#at, scratch + FRAME, scratch + BOX);
    this.answer = null;
    this.#tell("locked", { width: given.width, height: given.height, box: this.#library.rect(scratch + BOX), window: windows[0] });
    return this.quality;
  }

  /** The answer for the next frame. */
  update(frame) {
    this.#live();
    const given = frameOf(frame);
    const { scratch } = this.#library;
    const windows = this.#showWindows(given);
    this.#library.call("smr_update", this.#at, scratch + FRAME, scratch + ANSWER);
    this.answer = this.#readAnswer();
    this.#tell("updated", { width: given.width, height: given.height, windows, answer: this.answer });
    return this.answer;
  }

  /** Tells the tracker that the camera turned: the picture has moved by this many 1/256 pixels. */
  moved(right, down) {
    this.#live();
    whole(right, -MOST_I32, MOST_I32, "right");
    whole(down, -MOST_I32, MOST_I32, "down");
    this.#library.call("smr_moved", this.#at, right, down);
    this.#tell("moved", { right, down });
  }

  /** Saves the target as bytes. */
  save() {
    this.#live();
    const { memory, scratch } = this.#library;
    this.#library.call("smr_saved_size", this.#at, scratch + NUMBER);
    const size = memory.view.getUint32(scratch + NUMBER, true);
    const bytes = memory.take(size);
    try {
      this.#library.call("smr_save", this.#at, bytes, size, scratch + NUMBER);
      return memory.copy(bytes, memory.view.getUint32(scratch + NUMBER, true));
    } finally {
      memory.give(bytes);
    }
  }

  /** Continues with a saved target. */
  restore(saved) {
    this.#live();
    if (!(saved instanceof Uint8Array)) {
      throw new TypeError(`a saved target is a Uint8Array, not ${named(saved)}`);
    }
    const { memory } = this.#library;
    const bytes = memory.take(saved.length);
    try {
      memory.bytes.set(saved, bytes);
      this.#library.call("smr_restore", this.#at, bytes, saved.length);
    } catch (error) {
      throw error.status === "SMR_ERROR_OTHER_CONFIG" ? otherSetting(this.#otherSetting(bytes, saved.length)) : error;
    } finally {
      memory.give(bytes);
    }
    this.answer = null;
    this.#tell("restored", { saved });
  }

  // The name of the first setting that differs from those of a saved target.
  #otherSetting(bytes, size) {
    const { memory, scratch } = this.#library;
    this.#library.call("smr_other_setting", this.#at, bytes, size, scratch + NUMBER);
    return memory.text(memory.view.getUint32(scratch + NUMBER, true));
  }

  /** The box and the state of the target: of the last answer, the lock or the saved target. null without a target. */
  get last() {
    const { memory, scratch } = this.#library;
    if (!this.#ask("smr_last", scratch + FINE, scratch + NUMBER)) {
      return null;
    }
    return { fineBox: this.#library.fineRect(scratch + FINE), state: STATES[memory.view.getInt32(scratch + NUMBER, true)] };
  }

  /** How distinct the target was from its surroundings at the lock; null without a target. */
  get quality() {
    const { memory, scratch } = this.#library;
    return this.#ask("smr_quality", scratch + NUMBER) ? memory.view.getUint16(scratch + NUMBER, true) : null;
  }

  /** The pixels that the next update reads; null without a target. */
  get window() {
    const { scratch } = this.#library;
    return this.#ask("smr_window", scratch + WINDOWS[0]) ? this.#library.rect(scratch + WINDOWS[0]) : null;
  }

  /** A second window, in which the robust tracker looks for a lost target; null if there is none. */
  get sweepWindow() {
    const { scratch } = this.#library;
    const window = this.#ask("smr_sweep_window", scratch + WINDOWS[1]) ? this.#library.rect(scratch + WINDOWS[1]) : null;
    return window !== null && window.width * window.height > 0 ? window : null;
  }

  /** The paper's template: { width, height, pixels }; null without a target. */
  get template() {
    return this.#ask("smr_template", this.#library.scratch + IMAGE) ? this.#library.image() : null;
  }

  /** The robust tracker's early template: { width, height, pixels }; null without a target. */
  get earlyTemplate() {
    const pixels = this.#library.pixels(EARLY_PIXELS);
    const { scratch } = this.#library;
    return this.#ask("smr_early_template", pixels, EARLY_PIXELS, scratch + IMAGE) ? this.#library.image() : null;
  }

  /**
   * The robust tracker's responses as the next update would see them in `frame`, in units of 1/16384: { span, responses
   * }, row by row, one for each cell.
   */
  responseMap(frame) {
    this.#live();
    const { memory, scratch } = this.#library;
    this.#showWindows(frameOf(frame));
    this.#library.call("smr_response_map", this.#at, scratch + FRAME, scratch + RESPONSES);
    const span = 2 * this.options.reach + 1;
    const at = (i) => scratch + RESPONSES + 4 * (Math.floor(i / span) * RESPONSE_SPAN + (i % span));
    return { span, responses: Int32Array.from({ length: span * span }, (_, i) => memory.view.getInt32(at(i), true)) };
  }

  /** Calls `observer`, too, at every lock, update, move and restored target from now on: see record.js. */
  observe(observer) {
    this.#live();
    this.#observers.add(object(observer, "observer", "an object with the calls of Observer"));
  }

  /** Stops calling `observer`. */
  unobserve(observer) {
    this.#observers.delete(observer);
  }

  #tell(call, event) {
    for (const observer of this.#observers) {
      observer[call](event);
    }
  }

  /** The similarities of two pixels by their difference, in units of 1/65535. */
  get table() {
    this.#live();
    return this.#library.similarities(this.options.scale ?? PAPER_SCALE);
  }

  /** Gives the tracker's memory back. Later calls throw. */
  free() {
    this.#library.memory.give(this.#storage);
    this.#library.memory.give(this.#table);
    this.#storage = this.#table = this.#at = 0;
    this.#observers.clear();
  }

  #live() {
    if (this.#at === 0) {
      throw new SmrError("SMR_ERROR_NOT_INITIALISED", "the tracker was freed");
    }
  }

  // False without a target.
  #ask(name, ...values) {
    this.#live();
    try {
      this.#library.call(name, this.#at, ...values);
      return true;
    } catch (error) {
      if (error instanceof SmrError && error.status === "SMR_ERROR_NOT_LOCKED") {
        return false;
      }
      throw error;
    }
  }

  #writeBox(box) {
    const { x, y, width, height } = object(box, "the box", "an object with x, y, width and height");
    whole(x, -MOST_I32, MOST_I32, "the box's x");
    whole(y, -MOST_I32, MOST_I32, "the box's y");
    whole(width, 0, 65535, "the box's width");
    whole(height, 0, 65535, "the box's height");
    const { view } = this.#library.memory;
    const at = this.#library.scratch + BOX;
    view.setInt32(at, x, true);
    view.setInt32(at + 4, y, true);
    view.setUint16(at + 8, width, true);
    view.setUint16(at + 10, height, true);
  }

  #showWindows(given) {
    const { scratch } = this.#library;
    this.#library.call("smr_window", this.#at, scratch + WINDOWS[0]);
    this.#library.call("smr_sweep_window", this.#at, scratch + WINDOWS[1]);
    return this.#show(given, WINDOWS.map((at) => this.#library.rect(scratch + at)));
  }

  // Copies the gray pixels of the windows into the library's memory, and writes the frame that has them as its parts.
  // Returns the windows with their pixels, which are valid until the next call.
  #show(given, windows) {
    const { memory, scratch } = this.#library;
    const shown = windows.filter(({ width, height }) => width * height > 0);
    // A frame that lacks these pixels is smaller than the one of the lock.
    if (shown.some(({ x, y, width, height }) => x + width > given.width || y + height > given.height)) {
      throw new SmrError("SMR_ERROR_FRAME_SIZE_CHANGED");
    }
    let pixels = this.#library.pixels(shown.reduce((sum, { width, height }) => sum + width * height, 0));
    const { bytes, view } = memory;
    view.setUint16(scratch + FRAME, given.width, true);
    view.setUint16(scratch + FRAME + 2, given.height, true);
    view.setUint32(scratch + PARTS[1], 0, true);
    return shown.map((window, i) => {
      const size = window.width * window.height;
      const to = bytes.subarray(pixels, pixels + size);
      copyWindow(given, window, to);
      writePart(view, scratch + PARTS[i], pixels, window);
      pixels += size;
      return { ...window, pixels: to };
    });
  }

  #readAnswer() {
    const { memory, scratch } = this.#library;
    this.#library.call("smr_work", this.#at, scratch + NUMBER);
    const { view } = memory;
    const at = scratch + ANSWER;
    const alpha = view.getUint16(at + 42, true);
    return {
      box: this.#library.rect(at),
      fineBox: this.#library.fineRect(at + 12),
      state: STATES[view.getInt32(at + 28, true)],
      confidence: view.getUint16(at + 36, true),
      ratio: view.getUint16(at + 38, true),
      runnerUpRatio: view.getUint8(at + 44) === 0 ? null : view.getUint16(at + 40, true),
      alpha: alpha === 0 ? null : alpha,
      scale: view.getUint32(at + 32, true),
      foundAgain: view.getUint8(at + 45) !== 0,
      work: view.getUint32(scratch + NUMBER, true),
    };
  }
}

function writePart(view, at, pixels, { x, y, width, height }) {
  view.setUint32(at, pixels, true);
  view.setUint32(at + 4, width * height, true);
  view.setUint32(at + 8, width, true);
  view.setUint16(at + 12, width, true);
  view.setUint16(at + 14, height, true);
  view.setUint16(at + 16, x, true);
  view.setUint16(at + 18, y, true);
}
