// A flight recorder: keeps the last frames of a tracker and its answers. `host-sim replay FILE` runs the record again.
// The library writes the record (smr_record in smr.h) in segments. Each segment begins with the configuration and the
// saved target, so that older ones can be dropped.

import { genuine, refuseProxies, whole } from "./errors.js";

const DEFAULT_BYTES = 16 << 20;

export class Recorder {
  #tracker;
  #most; // bytes of a segment
  #segments = []; // at most two: of pieces
  #bytes = 0; // of the last segment

  /** Records `tracker` from now on, in about `bytes` of memory; older frames are dropped. */
  constructor(tracker, { bytes = DEFAULT_BYTES } = {}) {
    genuine(this);
    this.#tracker = tracker;
    this.#most = whole(bytes, 1, Number.MAX_SAFE_INTEGER, "bytes") / 2;
    tracker.record(this.#take);
  }

  bytes() {
    const pieces = this.#segments.flat();
    const bytes = new Uint8Array(pieces.reduce((sum, piece) => sum + piece.length, 0));
    pieces.reduce((at, piece) => (bytes.set(piece, at), at + piece.length), 0);
    return bytes;
  }

  stop() {
    this.#tracker.unrecord(this.#take);
  }

  #take = (piece, begins) => {
    if (begins && (this.#segments.length === 0 || this.#bytes > this.#most)) {
      this.#segments = [...this.#segments.slice(-1), []];
      this.#bytes = 0;
    }
    this.#segments.at(-1).push(piece);
    this.#bytes += piece.length;
    if (!begins && this.#bytes > this.#most) {
      this.#tracker.beginRecord();
    }
  };
}
refuseProxies(Recorder, "recorder");
