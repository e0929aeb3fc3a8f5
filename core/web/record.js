// A flight recorder: keeps the last frames of a tracker and its answers. `host-sim replay FILE` runs the record again.
//
// The documentation of smr_core::record describes every byte. A record begins with the configuration and the saved
// target, so that old frames can be dropped.

import { whole } from "./errors.js";

const VERSION = 1;
const STATE_CODES = { tracking: 0, leaving: 1, uncertain: 2, lost: 3 };
const DEFAULT_BYTES = 16 << 20;

// The CRC-32 that Ethernet and zip use.
const CRC = Uint32Array.from({ length: 256 }, (_, byte) => {
  let sum = byte;
  for (let bit = 0; bit < 8; bit++) {
    sum = sum & 1 ? (sum >>> 1) ^ 0xedb88320 : sum >>> 1;
  }
  return sum;
});

export class Recorder {
  #tracker;
  #most; // bytes of a segment
  #segments = []; // at most two: of entries, each { tag, parts }
  #bytes = 0; // of the last segment

  /** Records `tracker` from now on. `bytes` is the memory to keep; older frames are dropped. */
  constructor(tracker, { bytes = DEFAULT_BYTES } = {}) {
    this.#tracker = tracker;
    this.#most = whole(bytes, 1, Number.MAX_SAFE_INTEGER, "bytes") / 2;
    this.#begin();
    tracker.observe(this);
  }

  /** The record as bytes. */
  bytes() {
    return joined(this.#segments.flatMap((segment) => segment.flatMap((entry, number) => encoded(entry, number))));
  }

  /** Stops recording. Other recorders of the tracker go on. */
  stop() {
    this.#tracker.unobserve(this);
  }

  // The calls of the tracker to its observer. Pixels are valid during the call only.

  locked({ width, height, box, window }) {
    this.#add("SMRL", numbers([2, [width, height, ...values(box), ...values(window)]]), window.pixels.slice());
  }

  updated({ width, height, windows, answer }) {
    const nothing = { x: 0, y: 0, width: 0, height: 0 };
    const [first, second = nothing] = windows;
    const head = numbers([2, [width, height, ...values(first), ...values(second)]]);
    this.#add("SMRW", head, ...windows.map(({ pixels }) => pixels.slice()));
    this.#add("SMRA", answerBytes(answer));
    if (this.#bytes > this.#most) {
      this.#begin();
    }
  }

  moved({ right, down }) {
    this.#add("SMRM", numbers([4, [right, down]]));
  }

  restored({ saved }) {
    this.#add("SMRS", saved.slice());
  }

  #begin() {
    this.#segments = [...this.#segments.slice(-1), []];
    this.#bytes = 0;
    this.#add("SMRB", configBytes(this.#tracker));
    if (this.#tracker.last !== null) {
      this.#add("SMRS", this.#tracker.save());
    }
  }

  #add(tag, ...parts) {
    this.#segments.at(-1).push({ tag, parts });
    this.#bytes += parts.reduce((sum, part) => sum + part.length, 0);
  }
}

function values({ x, y, width, height }) {
  return [x, y, width, height];
}

function configBytes(tracker) {
  const { method, options: o } = tracker;
  const paper = () => [
    ...o.k, ...o.gateTracking, ...o.gateLeaving, ...o.gateReturning, ...o.gateLost, o.gateLead, o.leastRatio, o.firstThreshold,
    o.leastThreshold, o.padding, ...o.window, o.growth, ...o.windowLimit, o.neighbourhood, Number(o.runnerUpAlways), ...o.updateZone,
  ];
  const robust = () => [
    Number(o.size), Number(o.sweep), 1, 1, 1, 1, o.reach, o.patience, o.lostBelow, o.uncertainBelow, o.learningRate, o.earlyRate,
    // With the refiner an answer has one number more.
    ...(o.refiner ? [1] : []),
  ];
  const letter = (method === "paper" ? "P" : "R").charCodeAt(0);
  return numbers([2, [VERSION, letter, ...tracker.table, ...(method === "paper" ? paper() : robust())]]);
}

function answerBytes({ fineBox, state, foundAgain, runnerUpRatio, alpha, confidence, ratio, scale }) {
  const flags = (foundAgain ? 1 : 0) | (runnerUpRatio === null ? 0 : 2) | (alpha === null ? 0 : 4);
  return numbers(
    [4, values(fineBox)],
    [2, [STATE_CODES[state] | (flags << 8), confidence, ratio, runnerUpRatio ?? 0, alpha ?? 0]],
    [4, [scale]],
  );
}

// Little-endian numbers, each group with its number of bytes.
function numbers(...groups) {
  const bytes = [];
  for (const [size, group] of groups) {
    for (const number of group) {
      for (let byte = 0; byte < size; byte++) {
        bytes.push((number >> (8 * byte)) & 255);
      }
    }
  }
  return Uint8Array.from(bytes);
}

// An entry: its tag, number and length, its content, and the checksum of all these.
function encoded({ tag, parts }, number) {
  const length = parts.reduce((sum, part) => sum + part.length, 0);
  const head = joined([Uint8Array.from(tag, (letter) => letter.charCodeAt(0)), numbers([4, [number, length]])]);
  return [head, ...parts, numbers([4, [checksum([head, ...parts])]])];
}

function checksum(parts) {
  let sum = 0xffffffff;
  for (const part of parts) {
    for (const byte of part) {
      sum = CRC[(sum ^ byte) & 255] ^ (sum >>> 8);
    }
  }
  return ~sum;
}

function joined(parts) {
  const bytes = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}
