// Playback of a source: plays, steps and jumps through frames, loads their images, and writes the frame number into
// the page's address.

import { Images } from "./image-cache.js";

const AHEAD = 12; // images that are loaded before they are played
const USUAL_RATE = 25; // frames a second, where the source does not say
const ADDRESS_MS = 400; // browsers refuse an address that changes more often
const LEAP = 10; // frames
/** The most frames by which playing goes on between two pictures on the screen; a slow machine plays more slowly. */
export const MAX_STEP = 4;

const clamp = (value, least, most) => Math.min(Math.max(value, least), most);

export class Playback {
  /** Number of the requested frame. */
  frame = null;
  /** Number of the frame on the screen. */
  shown = null;
  first = 1;
  last = 1;
  /** True if the page moves on to each new frame of a live source. */
  followsNewest = true;
  #images;
  #page;
  #playing = null; // since when, and from which frame
  #writing = null;
  #missing = null; // the number of the last image that could not be loaded
  #peeked = null; // the number of a frame that is looked at beside the one that is shown

  /**
   * `page` has: image(number), a promise for the frame's image; isLive(); timeOf(number) in seconds or null;
   * speed(), a factor; isHeld(), true while the image must not change; isAwaited(number), true while playing must not
   * reach that frame; marks(), ascending numbers of frames to jump to. Playback calls changed() when the page must be
   * drawn again; failed(error) when the requested image cannot be loaded; and visited(number), which is optional, when
   * the frame number has been written into the address.
   */
  constructor(page) {
    this.#page = page;
    this.forget(1, 1);
    addEventListener("hashchange", () => this.goTo(addressed() ?? this.frame));
  }

  get image() {
    return this.imageOf(this.shown);
  }

  imageOf(number) {
    return this.#images.get(number);
  }

  get isPlaying() {
    return this.#page.isLive() ? this.followsNewest : this.#playing !== null;
  }

  /** True while the image of the requested frame is loading. */
  get isLoading() {
    return this.frame !== this.shown && this.frame !== this.#missing && !this.#page.isHeld();
  }

  /** True while playing waits for the answer in the next frame. */
  get isWaiting() {
    return this.#playing !== null && this.frame < this.last && !this.#page.isHeld() && this.#page.isAwaited(this.frame + 1);
  }

  /** Starts at the frame in the page's address or, if there is none, at `otherwise`. */
  begin(otherwise) {
    this.goTo(addressed() ?? otherwise);
  }

  reach(first, last) {
    [this.first, this.last] = [first, last];
  }

  /** Drops all images and resets the playback, for another recording with the frames `first` to `last`. */
  forget(first, last) {
    [this.frame, this.shown, this.#playing, this.#missing, this.#peeked, this.followsNewest] = [null, null, null, null, null, true];
    this.#images?.end();
    const isHere = () => images === this.#images;
    const images = new Images(this.#page.image, (number) => isHere() && this.#came(number), (number, error) => isHere() && this.#missed(number, error));
    this.#images = images;
    this.reach(first, last);
  }

  goTo(number) {
    this.frame = clamp(number, this.first, this.last);
    this.#want();
    this.imageOf(this.frame) === undefined ? this.#page.changed() : this.#show(this.frame);
  }

  /** Goes to a frame for the user, and stops playing. */
  visit(number) {
    this.play(false);
    this.goTo(number);
    this.#writeAddress();
  }

  /** Goes to the next mark if `way` is 1, to the one before if it is -1. */
  visitMark(way) {
    const frames = this.#page.marks();
    const next = way > 0 ? frames.find((one) => one > this.frame) : frames.findLast((one) => one < this.frame);
    if (next !== undefined) {
      this.visit(next);
    }
  }

  play(on) {
    if (this.#page.isLive()) {
      this.followsNewest = on;
    } else if (on && this.#playing === null) {
      this.#playing = restarted(this.frame >= this.last ? this.first : this.frame);
      this.goTo(this.#playing.frame);
      requestAnimationFrame((now) => this.#tick(now));
    } else if (!on) {
      this.#playing = null;
    }
    this.#page.changed();
  }

  toggle() {
    this.play(!this.isPlaying);
  }

  /** Restarts the clock of playback at the requested frame, for example after a change of the speed. */
  restart() {
    this.#playing = this.#playing && restarted(this.frame);
  }

  /** Loads the image of a frame for the preview, without showing the frame; null ends the preview. */
  peek(number) {
    this.#peeked = number;
    this.#want();
  }

  /** Performs the action of a key. Returns false if the key has none. */
  key({ key, shiftKey }) {
    const by = shiftKey ? LEAP : 1;
    const act = {
      ArrowLeft: () => this.visit(this.frame - by),
      ArrowRight: () => this.visit(this.frame + by),
      Home: () => this.visit(this.first),
      End: () => this.visit(this.last),
      "[": () => this.visitMark(-1),
      "]": () => this.visitMark(1),
      " ": () => this.toggle(),
    }[key];
    act?.();
    return act !== undefined;
  }

  #want() {
    const count = this.#playing === null ? 1 : AHEAD;
    const ahead = Array.from({ length: count }, (_, by) => this.frame + by + 1).filter((one) => one <= this.last);
    this.#images.want([...new Set([this.frame, ...ahead, this.shown, this.#peeked].filter((number) => number !== null))]);
  }

  // Handles a loaded image. While the requested frame is loading, shows any image that is nearer to it than the
  // shown one. Shows a camera's first loaded image even if a later frame is requested by then.
  #came(number) {
    const isNearer = this.shown === null ? this.#page.isLive() : Math.abs(number - this.frame) < Math.abs(this.shown - this.frame);
    if (number === this.frame || isNearer) {
      this.#show(number);
    } else if (number === this.#peeked) {
      this.#page.changed();
    }
  }

  // Handles an image that failed to load. At a camera's newest frame that is no error: the next image follows soon.
  #missed(number, error) {
    this.#missing = number;
    if (number === this.frame && !(this.#page.isLive() && this.followsNewest)) {
      this.#page.failed(error);
    }
  }

  #show(number) {
    if (!this.#page.isHeld()) {
      this.shown = number;
      this.#page.changed();
    }
  }

  // Shows each frame when it is due. If its image or an awaited answer is late, playback slows down and skips no frame.
  #tick(now) {
    if (this.#playing === null) {
      return;
    }
    requestAnimationFrame((later) => this.#tick(later));
    const isDue = () => now >= this.#playing.since + (1000 * this.#duration(this.#playing.frame, this.frame + 1)) / this.#page.speed();
    const isHeld = this.#page.isHeld();
    for (let step = 0; step < MAX_STEP && !isHeld && this.frame < this.last && isDue() && this.imageOf(this.frame + 1) !== undefined && !this.isWaiting; step++) {
      this.goTo(this.frame + 1);
    }
    if (isHeld || (this.frame < this.last && isDue())) {
      this.restart();
    } else if (this.frame >= this.last) {
      this.play(false);
    }
  }

  #duration(from, to) {
    const [begin, end] = [this.#page.timeOf(from), this.#page.timeOf(to)];
    return begin === null || end === null ? (to - from) / USUAL_RATE : end - begin;
  }

  #writeAddress() {
    this.#writing ??= setTimeout(() => {
      this.#writing = null;
      const words = new URLSearchParams(location.hash.slice(1));
      words.set("frame", this.frame);
      history.replaceState(null, "", `#${words}`);
      this.#page.visited?.(this.frame);
    }, ADDRESS_MS);
  }
}

const restarted = (from) => ({ since: performance.now(), frame: from });

// Returns the frame number in the page's address; null if there is none.
function addressed() {
  const wanted = Math.round(Number(new URLSearchParams(location.hash.slice(1)).get("frame")));
  return wanted > 0 ? wanted : null;
}

/** Returns the frame that `text` names by its number or its time, such as 12.5 or 1:02.5; null if there is none. */
export function frameNamed(text, { first, last }, timeOf) {
  const words = text.trim();
  if (/^\d+$/.test(words)) {
    const number = Number(words);
    return number >= first && number <= last ? number : null;
  }
  if (!/^(\d+:)*\d+(\.\d*)?$/.test(words) || timeOf(first) === null || timeOf(last) === null) {
    return null;
  }
  const seconds = words.split(":").reduce((sum, part) => 60 * sum + Number(part), 0);
  let [from, to] = [first, last];
  while (from < to) {
    const middle = Math.ceil((from + to) / 2);
    [from, to] = timeOf(middle) <= seconds ? [middle, to] : [from, middle - 1];
  }
  return from;
}
