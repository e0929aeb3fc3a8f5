// The answers of one tracker in the last frames: a ring, so that a page that is open for days takes no more memory.

/** The number of frames that are kept: five minutes of 30 a second. */
export const KEPT = 9000;

const STATES = ["tracking", "leaving", "uncertain", "lost"];
const COLUMNS = [
  "number", "state", "x", "y", "width", "height", "fineX", "fineY", "fineWidth", "fineHeight", "confidence", "ratio", "runnerUpRatio", "alpha",
  "scale", "foundAgain", "work", "quality", "ms",
];

export class History {
  #columns = Object.fromEntries(COLUMNS.map((name) => [name, new Float64Array(KEPT)]));
  #start = 0; // the oldest row that is there
  #end = 0; // the row that is written next

  get length() {
    return this.#end - this.#start;
  }

  /** Adds the frame of a lock. It replaces the answers from that frame on. */
  lock(number, box, quality) {
    this.dropFrom(number);
    const fine = { x: 256 * box.x, y: 256 * box.y, width: 256 * box.width, height: 256 * box.height };
    this.#write({ number, state: "tracking", box, fineBox: fine, quality });
  }

  answer(number, answer, ms) {
    this.#write({ number, ...answer, ms });
  }

  /** Forgets the answers from a frame on. */
  dropFrom(number) {
    this.#end = this.#place(number);
  }

  /** The row of a frame; undefined if there is none. */
  find(number) {
    const at = this.#place(number);
    return at < this.#end && this.#number(at) === number ? this.row(this.#end - 1 - at) : undefined;
  }

  /** The state in a frame; undefined if there is no answer. */
  stateAt(number) {
    const at = this.#place(number);
    return at < this.#end && this.#number(at) === number ? STATES[this.#columns.state[at % KEPT]] : undefined;
  }

  /** { number, state } of all rows, the oldest first. */
  *states() {
    for (let at = this.#start; at < this.#end; at++) {
      yield { number: this.#number(at), state: STATES[this.#columns.state[at % KEPT]] };
    }
  }

  /** The row `back` rows before the last one. Missing values are NaN. */
  row(back = 0) {
    const at = (this.#end - 1 - back) % KEPT;
    const row = Object.fromEntries(COLUMNS.map((name) => [name, this.#columns[name][at]]));
    return { ...row, state: STATES[row.state] };
  }

  /** All rows, the oldest first. */
  *rows() {
    for (let back = this.length - 1; back >= 0; back--) {
      yield this.row(back);
    }
  }

  /** The values of a column in the last `count` rows, the oldest first. */
  last(name, count) {
    const used = Math.min(count, this.length);
    return Array.from({ length: used }, (_, at) => this.#columns[name][(this.#end - used + at) % KEPT]);
  }

  #number(at) {
    return this.#columns.number[at % KEPT];
  }

  // The first row whose frame is not before `number`. Rows mostly lie at the distance of their frames.
  #place(number) {
    if (this.length === 0) {
      return this.#end;
    }
    let [from, to] = [this.#start, this.#end];
    const likely = this.#start + number - this.#number(this.#start);
    if (likely >= from && likely < to && this.#number(likely) === number) {
      return likely;
    }
    while (from < to) {
      const middle = Math.floor((from + to) / 2);
      this.#number(middle) < number ? (from = middle + 1) : (to = middle);
    }
    return from;
  }

  #write({ number, state, box, fineBox: fine, foundAgain, ...figures }) {
    const row = {
      ...figures, number, ...box, state: STATES.indexOf(state), foundAgain: foundAgain === undefined ? NaN : Number(foundAgain),
      fineX: fine.x, fineY: fine.y, fineWidth: fine.width, fineHeight: fine.height,
    };
    for (const name of COLUMNS) {
      this.#columns[name][this.#end % KEPT] = row[name] ?? NaN;
    }
    this.#end += 1;
    this.#start = Math.max(this.#start, this.#end - KEPT);
  }
}

/** The median; NaN if there are no values. */
export function median(values) {
  const sorted = values.filter((value) => !Number.isNaN(value)).sort((a, b) => a - b);
  return sorted.length === 0 ? NaN : sorted[Math.floor(sorted.length / 2)];
}
