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
  #end = 0; // rows ever written

  get length() {
    return Math.min(this.#end, KEPT);
  }

  /** Adds the frame of a lock. It replaces the answer in that frame, if there is one. */
  lock(number, box, quality) {
    const fine = { x: 256 * box.x, y: 256 * box.y, width: 256 * box.width, height: 256 * box.height };
    this.#write({ number, state: "tracking", box, fineBox: fine, quality });
  }

  answer(number, answer, ms) {
    this.#write({ number, ...answer, ms });
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

  #write({ number, state, box, fineBox: fine, foundAgain, ...figures }) {
    const isSame = this.#end > 0 && this.#columns.number[(this.#end - 1) % KEPT] === number;
    const at = (isSame ? this.#end - 1 : this.#end) % KEPT;
    const row = {
      ...figures, number, ...box, state: STATES.indexOf(state), foundAgain: foundAgain === undefined ? NaN : Number(foundAgain),
      fineX: fine.x, fineY: fine.y, fineWidth: fine.width, fineHeight: fine.height,
    };
    for (const name of COLUMNS) {
      this.#columns[name][at] = row[name] ?? NaN;
    }
    this.#end += isSame ? 0 : 1;
  }
}

/** The median; NaN if there are no values. */
export function median(values) {
  const sorted = values.filter((value) => !Number.isNaN(value)).sort((a, b) => a - b);
  return sorted.length === 0 ? NaN : sorted[Math.floor(sorted.length / 2)];
}
