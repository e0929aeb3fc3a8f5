// The targets in the worker. Each is followed by those of the two trackers that are switched on.

import { Recorder } from "../record.js";
import { METHODS, trackerOf } from "./methods.js";
import { picturesBefore, picturesAfter } from "./compared.js";

// The memory of a flight record: some seconds of a window.
const RECORD_BYTES = 6 << 20;

export class Targets {
  #library;
  #settings;
  #targets = new Map(); // by id: the trackers by method, each { tracker, recorder }
  #last = new Map(); // by id: the last frame that was followed

  constructor(library, settings) {
    this.#library = library;
    this.#settings = settings;
  }

  /** Locks each tracker on `box`. Returns by method { quality } or { error }. */
  lock(id, frame, box) {
    const followers = this.#targets.get(id) ?? {};
    this.#targets.set(id, followers);
    const isHere = (this.#last.get(id) ?? frame.number) === frame.number;
    this.#last.set(id, frame.number);
    const locked = {};
    for (const method of METHODS.filter((method) => this.#settings.on[method])) {
      followers[method] ??= this.#make(method);
      const { tracker } = followers[method];
      try {
        locked[method] = { quality: tracker.lock(frame, box), window: tracker.window };
      } catch (error) {
        locked[method] = { error: error.message };
        if (!isHere) {
          // It stands in another frame and cannot go on from this one.
          tracker.free();
          delete followers[method];
        }
      }
    }
    return locked;
  }

  remove(id) {
    for (const { tracker } of Object.values(this.#targets.get(id) ?? {})) {
      tracker.free();
    }
    this.#targets.delete(id);
    this.#last.delete(id);
  }

  /** Removes all targets. Later ones are made with `settings`. */
  restart(settings = this.#settings) {
    for (const id of [...this.#targets.keys()]) {
      this.remove(id);
    }
    this.#settings = settings;
  }

  /**
   * The answers for a frame, of the targets that it is the next one for: by id and method { answer, ms, window, sweepWindow }.
   * The target `shown` also has the pictures.
   */
  update(frame, shown) {
    const due = [...this.#targets].filter(([id]) => this.#last.get(id) === frame.number - 1);
    return due.map(([id, followers]) => {
      this.#last.set(id, frame.number);
      const methods = Object.entries(followers).filter(([, { tracker }]) => tracker.last !== null);
      return [id, Object.fromEntries(methods.map(([method, { tracker }]) => [method, updated(tracker, frame, id === shown)]))];
    });
  }

  /** The flight record of a tracker; null if there is none. */
  record(id, method) {
    return this.#targets.get(id)?.[method]?.recorder.bytes() ?? null;
  }

  #make(method) {
    const tracker = trackerOf(this.#library, method, this.#settings);
    return { tracker, recorder: new Recorder(tracker, { bytes: RECORD_BYTES }) };
  }
}

function updated(tracker, frame, isShown) {
  const { window, sweepWindow } = tracker;
  const before = isShown ? picturesBefore(tracker, frame) : null;
  const start = performance.now();
  const answer = tracker.update(frame);
  const ms = performance.now() - start;
  return { answer, ms, window, sweepWindow, pictures: before && picturesAfter(before, frame, answer) };
}
