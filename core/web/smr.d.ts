// The types of smr.js.

declare global { interface SymbolConstructor { readonly dispose: unique symbol } }

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
  /** The target is in the box, which is partly outside the frame. Only from the paper tracker. */
  readonly LEAVING: "leaving";
  /** The target is partly hidden or changes quickly. Only from the robust tracker. */
  readonly UNCERTAIN: "uncertain";
  /** The target is not visible; the search goes on. */
  readonly LOST: "lost";
};
export type State = (typeof State)[keyof typeof State];

/** The answer of an update. Ratios, the confidence and the identity are in units of 1/65535. */
export interface Answer {
  box: Rect;
  /** The box in units of 1/256 pixel. */
  fineBox: Rect;
  state: State;
  /** The confidence in the box. */
  confidence: number;
  /** The similarity of the box to the template. */
  ratio: number;
  /** The ratio of the second best place; null if it was not searched. */
  runnerUpRatio: number | null;
  /** The paper's threshold in gray levels; null from the robust tracker. */
  alpha: number | null;
  /**
   * The judgement of the refiner's network that the box shows the target of the lock, a running mean over about four frames: 65535 is certain,
   * 32768 undecided, 0 certain that it shows something else. Below 38229 the state is "uncertain" or "lost". Null without the refiner.
   */
  identity: number | null;
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
  /** The factor of alpha: the next alpha is `k` times the largest change of a pixel in an update of the template. 1 to 65535. */
  k?: Pair;
  /** The ratio of peak and runner-up that is needed while the target stays inside the frame. Below 1 every peak above 0 is accepted. 0 to 65535. */
  gateTracking?: Pair;
  /** The ratio of peak and runner-up that is needed if the box at the peak is partly outside the frame. 0 to 65535. */
  gateLeaving?: Pair;
  /** The ratio of peak and runner-up that is needed after a box was partly outside the frame, until a lost target is found again. 0 to 65535. */
  gateReturning?: Pair;
  /** The ratio of peak and runner-up that is needed to find a lost target again. 0 to 65535. */
  gateLost?: Pair;
  /** The lead of the peak over the runner-up that is enough whatever their ratio is, in fully similar pixels. 0 to 65535. */
  gateLead?: number;
  /** The least similarity matching ratio of an accepted peak, in units of 1/65535. 0, the paper's value, also turns off the check for a covered lens: a patch inside the frame needs a quarter of the template's contrast (mean absolute deviation), and its pixels at 0 or 255 may exceed those of the template by at most half of all pixels. 0 to 65535. */
  leastRatio?: number;
  /** alpha of the first update, in gray levels. Pixels that differ by less are similar. 1 to 255. */
  firstThreshold?: number;
  /** The least alpha of later updates, in gray levels. 0 (the paper's value) and 1 set no bound, so that after a still scene a change of light leaves no pixel that matches. 0 to 255. */
  leastThreshold?: number;
  /** The width of the black border around the frame, in pixels: how far a box may leave the frame. 0 to 65535. */
  padding?: number;
  /** The radius of the search window around the last position, in pixels. 0 to 65535. */
  window?: Pair;
  /** The growth of the window in each frame while the target is lost, in pixels on each side. 0 to 65535. */
  growth?: number;
  /** The largest radius while the target is lost, in pixels; at least `window`. The padded frame always bounds it. 0 to 65535. */
  windowLimit?: Pair;
  /** The runner-up is the best score more than this many pixels from the peak, in x or in y. 0 to 65535. */
  neighbourhood?: number;
  /** The runner-up is searched in every frame, which takes several times as long, not only if the gate needs it. */
  runnerUpAlways?: boolean;
  /** The distances that a box must keep from the edges of the frame for the tracker to learn from it, in pixels. 0 to 65535. */
  updateZone?: [number, number, number, number];
  plainLoop?: boolean;
}

/** The options of smr_robust_config in smr.h. */
export interface RobustOptions {
  /**
   * "refined" (the default) has the refiner, "robust" has not. "smallRefined" and "small" take less memory and time, and have a `reach` of at most 7.
   * In firmware: smr_config_refined, smr_config_robust, smr_config_small_refined, smr_config_small.
   */
  preset?: "refined" | "robust" | "small" | "smallRefined";
  /** The box follows the size of the target. */
  size?: boolean;
  /** Windows in which each frame is searched for a lost target, besides the one around its last place. From frame to frame they sweep the whole picture. Each takes about as much work as the search of a frame. 0: no sweep. 0 to 255. */
  sweep?: number;
  /** The radius of the search in cells. The side of a cell is a tenth of the root of the target's area. The work of an update grows with the square of 2 `reach` + 1. At most 7 in a tracker of the small size. 4 to 8. */
  reach?: number;
  /** The part of its value that the confidence keeps in each frame, in units of 1/256. A higher one holds on to the target for longer: through short occlusions, but also through errors. 0 to 255. */
  patience?: number;
  /** The target is lost while the confidence is below this, in units of 1/65535. 0 to 65535. */
  lostBelow?: number;
  /** The target is uncertain while the confidence is below this, in units of 1/65535; at least `lost_below`. 0 to 65535. */
  uncertainBelow?: number;
  /** The learning rate of the filter, in units of 1/256: 0 keeps the filter of the first frame, 256 takes the exact step for the present frame. 0 to 256. */
  learningRate?: number;
  /** The learning rate of the early template, in units of 1/1024. 0 to 1024. */
  earlyRate?: number;
  /** A small learned network corrects the box. It keeps the box to a target that comes nearer, turns or changes its shape, reads more of the frame, and can make the state *uncertain* or *lost*. In firmware a build without the feature `refiner` refuses it. */
  refiner?: boolean;
  plainLoop?: boolean;
}

/** A call that a tracker cannot do. The message has the words of the library. */
export declare class SmrError extends Error {
  name: "SmrError";
  /** The name of the status in smr.h: "SMR_ERROR_BOX_EMPTY" and so on. */
  status: string;
  constructor(status: string, words?: string);
}

/** Follows one target. A call that throws changes nothing. A Proxy of it (reactive state) throws a TypeError that says what to do. */
export declare class Tracker<Options = PaperOptions | RobustOptions> {
  private constructor();
  readonly method: "paper" | "robust";
  readonly preset: "camera" | "paper" | "refined" | "robust" | "small" | "smallRefined";
  /** All options, with the numbers of the preset where none was given. */
  readonly options: Required<Omit<Options, "preset">>;
  /** The answer of the last update since the lock; null before it. */
  readonly answer: Answer | null;
  /** The fine box and the state of the last answer, the lock or the saved target; null without a target. */
  readonly last: { fineBox: Rect; state: State } | null;
  /** The quality of the target at the lock, poor below POOR_QUALITY; null without a target. */
  readonly quality: number | null;
  /** The pixels that the next update reads; null without a target. */
  readonly window: Rect | null;
  /** A second window, in which the robust tracker looks for a lost target; null if there is none. */
  readonly sweepWindow: Rect | null;
  /** The template, of the robust tracker the early one; null without a target. */
  readonly template: Picture | null;
  /** Follows what is in `box`, whose numbers are rounded to whole pixels. Returns the quality. */
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
  /** Gives `take` each piece of a flight record from now on; `begins`: the record begins with this piece. */
  record(take: (piece: Uint8Array, begins: boolean) => void): void;
  /** Gives `take` no more pieces. */
  unrecord(take: (piece: Uint8Array, begins: boolean) => void): void;
  /** Begins the record anew, with the configuration and the target as it is. */
  beginRecord(): void;
  /** Gives the memory back. Later calls throw. */
  free(): void;
  /** Gives the memory back at the end of a block with `using`. */
  [Symbol.dispose](): void;
  readonly [Symbol.toStringTag]: string;
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
  readonly [Symbol.toStringTag]: string;
}

/** A target with a lower quality may slip along its own texture unnoticed. */
export declare const POOR_QUALITY: number;

/** True if the engine has SIMD128. */
export declare function hasSimd(): boolean;

/** The library. By default the file beside smr.js that is faster here; code without an address, such as a worker made of a blob, must give one. */
export declare function load(source?: WebAssembly.Module | ArrayBuffer | ArrayBufferView | Response | string | URL): Promise<Smr>;
