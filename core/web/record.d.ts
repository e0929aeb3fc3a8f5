// The types of record.js.

import type { Tracker } from "./smr.js";

/** A flight recorder: keeps all that a tracker saw and answered in its last frames, for `host-sim replay`. */
export declare class Recorder {
  /** Records `tracker` from now on. `bytes`: memory to keep, a whole number, 16 MiB by default; older frames are dropped. */
  constructor(tracker: Tracker, options?: { bytes?: number });
  /** The record, as a file for `host-sim replay`. */
  bytes(): Uint8Array;
  /** Records no longer. Other recorders of the tracker go on. */
  stop(): void;
  readonly [Symbol.toStringTag]: string;
}
