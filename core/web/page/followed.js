// A target as the page knows it: the place of its lock, and the answers of each tracker.

import { History, median } from "./history.js";
import { METHODS } from "./methods.js";

// The number of locks that are kept to be repeated.
const MOST_LOCKS = 100;

export class Followed {
  id;
  name;
  /** { number, box }, in the order of frames. */
  locks = [];
  /** Locks that are repeated when their frames come. */
  planned = [];
  /** The lock among them that the worker makes now. */
  underWay = null;
  /** The last frame that was followed, or null. */
  last = null;
  /** The last answers by method. */
  histories = {};
  /** The state to show for each method: { state, box, window, ... }, or { error } if it refused the last lock. */
  now = {};

  constructor(id) {
    this.id = id;
    this.name = String(id);
  }

  /** Notes that the worker has locked its trackers. */
  locked(number, box, locked) {
    this.locks = [...this.locks.filter((lock) => lock.number < number), { number, box }].slice(-MOST_LOCKS);
    [this.now, this.underWay, this.last] = [{}, null, number];
    Object.values(this.histories).forEach((history) => history.dropFrom(number));
    for (const [method, { quality, error, window }] of Object.entries(locked)) {
      if (error === undefined) {
        this.histories[method] ??= new History();
        this.histories[method].lock(number, box, quality);
        this.now[method] = { state: "tracking", box, window, quality };
      } else {
        this.now[method] = { error };
      }
    }
  }

  answered(number, answers) {
    this.last = number;
    for (const [method, { answer, ms, window, sweepWindow, pictures }] of Object.entries(answers)) {
      this.histories[method].answer(number, answer, ms);
      const { x, y, width, height } = answer.fineBox;
      const box = { x: x / 256, y: y / 256, width: width / 256, height: height / 256 };
      this.now[method] = { ...answer, box, window, sweepWindow, pictures };
    }
  }

  /** Shows what was answered in a frame before. */
  showAt(number) {
    for (const [method, history] of Object.entries(this.histories)) {
      const row = history.find(number);
      this.now[method] = row === undefined ? { state: "not followed" } : shownOf(row);
    }
  }

  /** The frame to be followed next; null if there is none. */
  get next() {
    return this.last === null ? (this.planned[0]?.number ?? null) : this.last + 1;
  }

  /** Goes back to before the first frame: all locks are planned, `isRepeated` or not. */
  restart(isRepeated) {
    const underWay = this.underWay === null ? [] : [this.underWay];
    this.planned = isRepeated ? [...this.locks, ...underWay, ...this.planned] : [];
    [this.underWay, this.last] = [null, null];
    this.locks = [];
    this.histories = {};
    this.now = {};
  }

  /** The box to lock on in a frame; null if there is none. */
  due(number) {
    if (this.planned.length === 0 || this.planned[0].number !== number) {
      return null;
    }
    this.underWay = this.planned.shift();
    return this.underWay.box;
  }

  /** The median time of an update in milliseconds. */
  time(method) {
    const history = this.histories[method];
    return history === undefined ? NaN : median(history.last("ms", 300));
  }

  /** True if a tracker follows the target. */
  get isFollowed() {
    return METHODS.some((method) => this.histories[method]?.length > 0);
  }
}

const value = (figure) => (Number.isNaN(figure) ? null : figure);

// A row of a history as an answer.
function shownOf({ state, fineX, fineY, fineWidth, fineHeight, confidence, ratio, runnerUpRatio, alpha, scale, work }) {
  const box = { x: fineX / 256, y: fineY / 256, width: fineWidth / 256, height: fineHeight / 256 };
  return {
    state, box, confidence: value(confidence), ratio: value(ratio), runnerUpRatio: value(runnerUpRatio), alpha: value(alpha), scale: value(scale),
    work: Number.isNaN(work) ? undefined : work,
  };
}
