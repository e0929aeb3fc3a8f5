// Storage of the trackers' answers by target and frame number, compact enough for long videos.

const STATES = ["tracking", "leaving", "uncertain", "lost"];
// Each column's factor from received to stored values: the integer that stands for 1.0 in the trackers and figures.js.
const UNITS = { x: 1, y: 1, width: 1, height: 1, confidence: 65535, alpha: 1, ratio: 65535, scale: 65536, work: 1, runnerUpRatio: 65535, identity: 65535 };
const COLUMNS = Object.keys(UNITS);
const MIN = 1024;

export class Answers {
  #targets = new Map(); // the rows by id

  /** Stores rows [id, frame, state, x, y, ...] as host-sim sends them. Each replaces a row of the same id and frame. */
  take(rows) {
    for (const [id, number, state, ...values] of rows) {
      if (!this.#targets.has(id)) {
        this.#targets.set(id, new Rows(number));
      }
      this.#targets.get(id).write(number, STATES.indexOf(state), values);
    }
  }

  /** Removes ranges of answers, each [id, first frame, last frame]. */
  clear(parts) {
    for (const [id, first, last] of parts) {
      this.#targets.get(id)?.clear(first, last);
    }
  }

  keep(ids) {
    for (const id of [...this.#targets.keys()].filter((id) => !ids.includes(id))) {
      this.#targets.delete(id);
    }
  }

  /** Removes each target's answers before frame `before` once they span more than MIN frames. */
  forget(before) {
    this.#targets.forEach((rows) => rows.forget(before));
  }

  /** Returns a value that changes with a target's answers. */
  version(id) {
    return this.#targets.get(id)?.version ?? 0;
  }

  state(id, number) {
    return STATES[this.#targets.get(id)?.state(number)];
  }

  /** Returns an answer { number, state, box, ... } with all values that are known; undefined if there is no answer. */
  at(id, number) {
    return this.#targets.get(id)?.row(number);
  }

  /** Returns the last answer in the frames from `first` to `end - 1`; undefined if there is none. */
  last(id, first, end) {
    for (let number = end - 1; number >= first; number--) {
      if (this.state(id, number) !== undefined) {
        return this.at(id, number);
      }
    }
    return undefined;
  }

  /** Yields { number, state } of all answers by ascending frame number. */
  *states(id) {
    const rows = this.#targets.get(id);
    for (let number = rows?.first ?? 1; number <= (rows?.last ?? 0); number++) {
      const state = rows.state(number);
      if (state !== undefined) {
        yield { number, state: STATES[state] };
      }
    }
  }

  /** Returns an object whose method `last("ratio")` lists the ratios of all answers in frames `first` to `last`. */
  around(id, first, last) {
    const rows = this.#targets.get(id);
    const numbers = Array.from({ length: Math.max(last - first + 1, 0) }, (_, at) => first + at).filter((number) => rows?.state(number) !== undefined);
    const read = { number: (number) => number, state: (number) => rows.state(number) };
    return { last: (name) => numbers.map(read[name] ?? ((number) => rows.value(name, number))) };
  }
}

// The answers of one target from the frame `first` on, in typed arrays that grow.
class Rows {
  version = 0;
  first;
  last = 0;
  #states = new Uint8Array(MIN); // 0: no answer, else the state + 1
  #columns = Object.fromEntries(COLUMNS.map((name) => [name, new Float32Array(MIN)]));

  constructor(first) {
    this.first = first;
  }

  state(number) {
    const state = this.#states[number - this.first];
    return state > 0 ? state - 1 : undefined;
  }

  value(name, number) {
    return this.#columns[name]?.[number - this.first] ?? NaN;
  }

  row(number) {
    const state = this.state(number);
    if (state === undefined) {
      return undefined;
    }
    const { x, y, width, height, ...figures } = Object.fromEntries(COLUMNS.map((name) => [name, this.value(name, number)]));
    const known = Object.entries(figures).filter(([, value]) => !Number.isNaN(value));
    return { number, state: STATES[state], box: { x, y, width, height }, ...Object.fromEntries(known) };
  }

  write(number, state, values) {
    this.#reach(number);
    const at = number - this.first;
    this.#states[at] = state + 1;
    COLUMNS.forEach((name, column) => {
      this.#columns[name][at] = (values[column] ?? NaN) * UNITS[name];
    });
    // A row without confidence comes from a lock: its work is missing, because a lock is not an update.
    if (Number.isNaN(this.#columns.confidence[at])) {
      this.#columns.work[at] = NaN;
    }
    this.last = Math.max(this.last, number);
    this.version += 1;
  }

  clear(first, last) {
    this.#states.fill(0, Math.max(first - this.first, 0), Math.max(last - this.first + 1, 0));
    this.version += 1;
  }

  // Does nothing unless more than MIN frames can be removed, because a removal moves all arrays.
  forget(before) {
    if (before - this.first > MIN) {
      this.#move(before, this.#states.length);
    }
  }

  #reach(number) {
    if (number < this.first) {
      this.#move(number, this.#states.length + this.first - number);
    } else if (number - this.first >= this.#states.length) {
      this.#move(this.first, 2 * (number - this.first));
    }
  }

  // Reallocates all columns to begin with the frame `first` and have `length` entries.
  #move(first, length) {
    const moved = (old) => {
      const made = new old.constructor(length);
      const from = Math.max(first - this.first, 0);
      made.set(old.subarray(from, from + length), Math.max(this.first - first, 0));
      return made;
    };
    this.#states = moved(this.#states);
    COLUMNS.forEach((name) => {
      this.#columns[name] = moved(this.#columns[name]);
    });
    this.first = first;
    this.version += 1;
  }
}
