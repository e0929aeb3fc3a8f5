// Tracks the targets of the stand-alone page by the worker: each from its first box on, frame by frame.

import { lockIn } from "./edits.js";
import { TITLES } from "./methods.js";
import { saidOf } from "./rows.js";

const POOR_QUALITY = 1023; // of smr.js
const KEPT = 9000; // answers of a camera, for each target

export class Following {
  /** Method and its options, by host-sim's names. */
  using = { method: "robust", options: {} };
  #follower;
  #tell;
  #source = null;
  #wanted = [];
  #targets = new Map(); // see Target, by id
  #asked = null; // the box that `targets` waits for: { id, number, resolve, reject }
  #isBusy = false;
  #began = null; // { time, count } of the frames that are followed now

  /** `tell` is called with news, in the form that `heard` in application.js takes. */
  constructor(follower, tell) {
    [this.#follower, this.#tell] = [follower, tell];
  }

  /** Switches to another source of frames and drops all targets. */
  use(source) {
    [this.#source, this.#wanted] = [source, []];
    this.#targets.clear();
    this.#follower.ask("restart", { using: this.using });
    this.#asked?.resolve();
    this.#asked = null;
  }

  /** Tracks all targets again by another method. */
  method(using) {
    this.using = using;
    this.#follower.ask("restart", { using });
    const wanted = this.#wanted;
    this.#apply([]);
    this.#apply(wanted);
    if ([...this.#targets.values()].some(({ next }) => next === Infinity)) {
      this.#tell({ said: "Draw the boxes again: their frames are not kept any more." });
    }
  }

  /**
   * Replaces the targets and waits for the lock on the first new box: if it is refused, throws the reason and restores
   * the former targets. Also throws if a target would have to be tracked again from a frame that is not kept any more.
   */
  async targets(wanted) {
    const lost = wanted.map(({ id, locks }) => this.#targets.get(id)?.anew(locks) ?? locks[0].number).find((number) => number < this.#oldest);
    if (lost !== undefined) {
      throw new Error(`Frame ${lost} is not kept any more: draw a box in a later one.`);
    }
    const before = this.#wanted;
    const known = new Set(before.flatMap(({ locks }) => locks));
    const [fresh] = wanted.flatMap(({ id, locks }) => locks.filter((lock) => lock.box !== null && !known.has(lock)).map(({ number }) => ({ id, number })));
    this.#asked?.resolve();
    this.#asked = null;
    const answer = fresh && new Promise((resolve, reject) => (this.#asked = { ...fresh, resolve, reject }));
    this.#apply(wanted);
    try {
      await answer;
    } catch (error) {
      if (this.#wanted === wanted) {
        this.#apply(before);
      }
      throw error;
    }
  }

  /** Returns [name, rows by ascending frame] of each target; a row is an answer, or what the user says instead. */
  rows(nameOf) {
    return this.#wanted.map((target) => [nameOf(target), [...this.#targets.get(target.id).rows.values()].map((row) => saidOf(target, row))]);
  }

  /** Ends of answers before that of the recording: [id, frame of its lock, first frame without an answer]. */
  get silent() {
    return [...this.#targets.values()].flatMap((target) => target.silent);
  }

  /** Last frame up to which all targets are tracked; Infinity if all are gone and the last frame is unknown. */
  get followed() {
    return Math.min(this.#source.last, ...[...this.#targets.values()].map(({ next }) => next - 1));
  }

  /** Tracks all targets in all available frames. Returns at once if an earlier call is still running. */
  async run() {
    if (this.#isBusy) {
      return;
    }
    this.#isBusy = true;
    try {
      for (let due = this.#due(); due <= this.#source.last && Number.isFinite(due); due = this.#due()) {
        this.#began ??= { time: performance.now(), count: 0 };
        this.#began.count += 1;
        await this.#follow(due);
      }
    } catch (error) {
      this.#tell({ said: `The trackers stopped: ${error.message}.` });
    }
    [this.#isBusy, this.#began] = [false, null];
    this.#told([]);
  }

  get #oldest() {
    return this.#source.oldest ?? 1;
  }

  #due() {
    return Math.min(...[...this.#targets.values()].map(({ next }) => next));
  }

  #apply(wanted) {
    this.#wanted = wanted;
    const clear = [];
    const ids = wanted.map(({ id }) => id);
    for (const id of [...this.#targets.keys()].filter((id) => !ids.includes(id))) {
      this.#targets.delete(id);
      this.#follower.ask("remove", { id });
      clear.push([id, 0, Infinity]);
    }
    for (const { id, locks } of wanted) {
      const target = this.#targets.get(id);
      const from = target?.anew(locks) ?? this.#oldest;
      if (from === Infinity) {
        target.locks = locks;
      } else {
        this.#targets.set(id, new Target(id, locks, from, target));
        clear.push([id, from, Infinity]);
      }
    }
    this.#tell({ clear, rows: [], followed: this.followed });
    this.run();
  }

  async #follow(number) {
    const source = this.#source;
    const frame = await source.frame(number);
    const isDue = (target) => target.next === number;
    const due = source === this.#source && frame !== null ? [...this.#targets.values()].filter(isDue) : [];
    const jobs = due.map((target) => ({ id: target.id, box: lockIn(target, number)?.box })).filter(({ box }) => box !== null);
    if (jobs.length === 0) {
      frame?.image?.close();
    }
    const refuse = ({ message }) => jobs.map(({ id }) => [id, { error: message }]);
    const answers = new Map(jobs.length === 0 ? [] : await this.#follower.ask("follow", { number, ...frame, jobs }).catch(refuse));
    // Answers for targets that were changed meanwhile are dropped; those targets are tracked again.
    const rows = due.filter((target) => this.#targets.get(target.id) === target).flatMap((target) => this.#took(target, number, answers.get(target.id)));
    this.#told(rows);
  }

  #took(target, number, answer = {}) {
    const row = target.took(number, answer, this.#source.live ? KEPT : Infinity);
    const isAsked = this.#asked?.id === target.id && this.#asked.number === number;
    const { error, quality } = answer;
    if (error !== undefined) {
      const text = `${TITLES[this.using.method]} ${lockIn(target, number) ? "did not lock" : "stopped"}: ${error}.`;
      isAsked ? this.#asked.reject(new Error(text)) : this.#tell({ said: text });
    } else if (isAsked) {
      this.#asked.resolve();
    }
    if (isAsked) {
      this.#asked = null;
    }
    if (quality < POOR_QUALITY) {
      this.#tell({ said: "The tracker can hardly tell this from what is around it: try a box with more in it." });
    }
    return row === undefined ? [] : [shown(target.id, row)];
  }

  #told(rows) {
    const { time, count } = this.#began ?? {};
    const progress = count && { frame: this.followed, rate: (1000 * count) / (performance.now() - time) };
    this.#tell({ rows, followed: this.followed, progress, ...this.#source.news(this.followed) });
  }
}

// The progress of a target: it is tracked up to the frame `at`.
export class Target {
  rows = new Map(); // by the number of the frame
  #isActive = false;
  #stopped = null; // the frame in which tracking stopped

  /** Copies the answers before frame `from` from the target's former state `before`. Tracking restarts at `from`. */
  constructor(id, locks, from, before) {
    [this.id, this.locks] = [id, locks];
    this.at = from - 1;
    for (const [number, row] of before?.rows ?? []) {
      if (number < from) {
        this.rows.set(number, row);
      }
    }
  }

  /** The next frame to track; Infinity if there is none. */
  get next() {
    return this.#isActive ? this.at + 1 : (this.locks.find(({ number }) => number > this.at)?.number ?? Infinity);
  }

  /** Frames that a tracker refused, after which it gives no answer: [[id, frame of the lock, first frame without an answer]]. */
  get silent() {
    const lock = this.locks.findLast(({ number }) => number <= this.#stopped);
    return lock?.box ? [[this.id, lock.number, this.#stopped]] : [];
  }

  /** Returns the frame at which tracking must restart if the locks change to `locks`; Infinity if it can continue. */
  anew(locks) {
    const has = (all, { number, box }) => all.some((one) => one.number === number && one.box === box);
    const changed = [...locks.filter((lock) => !has(this.locks, lock)), ...this.locks.filter((lock) => !has(locks, lock))];
    const first = Math.min(...changed.map(({ number }) => number));
    // A change in the frame after `at` needs a restart, too: the worker may be processing it with the former locks.
    if (first > this.at + 1) {
      return Infinity;
    }
    // If there is no lock in frame `first`, the tracker must start at the lock before it, unless the target was gone.
    const before = locks.findLast(({ number }) => number <= first);
    return before === undefined || before.box === null ? first : before.number;
  }

  /** Stores and returns a frame's row from an `answer` or a lock's `quality`; undefined if both are missing. */
  took(number, { answer, quality }, kept) {
    this.at = number;
    this.#isActive = answer !== undefined || quality !== undefined;
    this.#stopped = this.#isActive ? null : number;
    if (!this.#isActive) {
      return undefined;
    }
    const row = answer === undefined ? locked(number, lockIn(this, number).box, quality) : { number, ...answer };
    this.rows.set(number, row);
    this.rows.delete(number - kept);
    return row;
  }
}

const locked = (number, box, quality) => {
  const { x, y, width, height } = box;
  return { number, state: "tracking", box, fineBox: { x: 256 * x, y: 256 * y, width: 256 * width, height: 256 * height }, quality };
};

// Converts an answer of the worker to the array that answers.js reads.
function shown(id, { number, state, fineBox: { x, y, width, height }, confidence, alpha, ratio, scale, work, runnerUpRatio, identity }) {
  const part = (value, unit) => (value === undefined || value === null ? undefined : value / unit);
  return [
    id, number, state, x / 256, y / 256, width / 256, height / 256, part(confidence, 65535), alpha ?? undefined, part(ratio, 65535), part(scale, 65536), work,
    part(runnerUpRatio, 65535), part(identity, 65535),
  ];
}
