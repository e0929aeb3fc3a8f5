// The types of smr.js.

/** A rectangle. In pixels; `fineBox` is in 1/256 pixel. */
export interface Rect {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** A frame: an ImageData, or gray bytes. */
export interface Frame {
  /** Row by row. Bytes that make another whole number for each pixel, up to four times as many, are refused: colors given as gray, say. */
  data: Uint8Array | Uint8ClampedArray;
  width: number;
  height: number;
  /** Bytes from a row to the next one. Default: no gaps. */
  stride?: number;
  /** Default: "gray" for a Uint8Array, "rgba" for a Uint8ClampedArray. */
  format?: "gray" | "rgba";
}

/** 8-bit gray pixels, row by row without gaps. */
export interface Picture {
  width: number;
  height: number;
  pixels: Uint8Array;
}

export declare const State: {
  /** The target is in the box. */
  readonly TRACKING: "tracking";
  /** The target is in the box, which is partly outside the frame. Only from the paper's tracker. */
  readonly LEAVING: "leaving";
  /** The target is partly hidden or changes quickly. Only from the robust tracker. */
  readonly UNCERTAIN: "uncertain";
  /** The target is not visible; the search goes on. */
  readonly LOST: "lost";
};
export type State = (typeof State)[keyof typeof State];

/** The answer of an update. Ratios and the confidence are in units of 1/65535. */
export interface Answer {
  box: Rect;
  /** The same in 1/256 pixel. */
  fineBox: Rect;
  state: State;
  /** How sure the tracker is of the box. */
  confidence: number;
  /** How similar the target in the box is to the template. */
  ratio: number;
  /** Of the second best place; null if it was not searched. */
  runnerUpRatio: number | null;
  /** The paper's threshold in gray levels; null from the robust tracker. */
  alpha: number | null;
  /** The target's size compared with the lock, in units of 1/65536. */
  scale: number;
  /** True in the frame in which a lost target was found. */
  foundAgain: boolean;
  /** The work of the update: comparisons of two bytes (paper), about the instructions of a Cortex-M4 (robust). */
  work: number;
}

/** Two numbers: x and y, or numerator and denominator. */
export type Pair = [number, number];

/** The options of smr_paper_config in smr.h. */
export interface PaperOptions {
  preset?: "camera" | "paper";
  k?: Pair;
  firstThreshold?: number;
  leastThreshold?: number;
  padding?: number;
  window?: Pair;
  growth?: number;
  windowLimit?: Pair;
  neighbourhood?: number;
  /** Left, top, right, bottom. */
  updateZone?: [number, number, number, number];
  gateTracking?: Pair;
  gateLeaving?: Pair;
  gateReturning?: Pair;
  gateLost?: Pair;
  gateLead?: number;
  leastRatio?: number;
  runnerUpAlways?: boolean;
  plainLoop?: boolean;
}

/** The options of smr_robust_config in smr.h. */
export interface RobustOptions {
  /** "refined" (the default) has the refiner, "robust" has not. In firmware: smr_config_refined, smr_config_robust. */
  preset?: "refined" | "robust";
  reach?: number;
  size?: boolean;
  sweep?: boolean;
  /** Whether a small learned network corrects the box. */
  refiner?: boolean;
  patience?: number;
  lostBelow?: number;
  uncertainBelow?: number;
  learningRate?: number;
  earlyRate?: number;
  plainLoop?: boolean;
}

/** What a tracker cannot do. The message has the words of the library. */
export declare class SmrError extends Error {
  name: "SmrError";
  /** The name of the status in smr.h: "SMR_ERROR_BOX_EMPTY" and so on. */
  status: string;
  constructor(status: string, words?: string);
}

/** A window and its gray pixels, which are valid during the call only. */
export interface Shown extends Rect {
  pixels: Uint8Array;
}

/** Is told of every call that changes a tracker, after it. */
export interface Observer {
  locked(event: { width: number; height: number; box: Rect; window: Shown }): void;
  updated(event: { width: number; height: number; windows: Shown[]; answer: Answer }): void;
  moved(event: { right: number; down: number }): void;
  restored(event: { saved: Uint8Array }): void;
}

/** Follows one target. A call that throws changes nothing. */
export declare class Tracker<Options = PaperOptions | RobustOptions> {
  private constructor();
  readonly method: "paper" | "robust";
  readonly preset: "camera" | "paper" | "refined" | "robust";
  /** All options, with the numbers of the preset where none was given. */
  readonly options: Required<Omit<Options, "preset">>;
  /** The answer of the last update since the lock; null before it. */
  readonly answer: Answer | null;
  /** The fine box and the state of the last answer, the lock or the saved target; null without a target. */
  readonly last: { fineBox: Rect; state: State } | null;
  /** How distinct the target was at the lock, poor below POOR_QUALITY; null without a target. */
  readonly quality: number | null;
  /** The pixels that the next update reads; null without a target. */
  readonly window: Rect | null;
  /** A second window, in which the robust tracker looks for a lost target; null if there is none. */
  readonly sweepWindow: Rect | null;
  /** The template, of the robust tracker the early one; null without a target. */
  readonly template: Picture | null;
  /** The similarities of two pixels by their difference, in units of 1/65535. */
  readonly table: Uint16Array;
  /** Follows what is in `box`. Returns the quality. */
  lock(frame: Frame, box: Rect): number;
  /** The answer for the next frame. */
  update(frame: Frame): Answer;
  /** The camera turned: the picture has moved by so many 1/256 pixels. */
  moved(right: number, down: number): void;
  /** The target as bytes. */
  save(): Uint8Array;
  /** Continues with a saved target. The options must be those of the tracker that saved it. */
  restore(saved: Uint8Array): void;
  /** The robust tracker's responses as the next update would see them, in units of 1/16384, row by row, one for each cell. May change. */
  responseMap(frame: Frame): { span: number; responses: Int32Array };
  /** Tells `observer` too of every call from now on. */
  observe(observer: Observer): void;
  /** Tells `observer` no longer; others still. */
  unobserve(observer: Observer): void;
  /** Gives the memory back. Later calls throw. */
  free(): void;
}

/** One instance of the library, with a memory of its own. */
export declare class Smr {
  private constructor();
  /** True if it uses SIMD128. */
  readonly simd: boolean;
  /** The version of the library. */
  readonly version: string;
  /** Bytes of its memory. */
  readonly memory: number;
  /** A tracker of the paper. */
  paper(options?: PaperOptions): Tracker<PaperOptions>;
  /** A robust tracker. */
  robust(options?: RobustOptions): Tracker<RobustOptions>;
}

/** A target with a lower quality can hardly be told from its surroundings. */
export declare const POOR_QUALITY: number;

/** True if the engine has SIMD128. */
export declare function hasSimd(): boolean;

/** The library. By default the file beside smr.js that is faster here. */
export declare function load(source?: WebAssembly.Module | ArrayBuffer | ArrayBufferView | Response | string | URL): Promise<Smr>;
