// Decodes the images of a video file by number. If the browser skips an image, the decoder seeks back to it.

import { lacking } from "./codec.js";
import { quoted } from "./command.js";
import { htmlNode } from "./dom.js";

// Assumed time in seconds from an image to the next, until it is measured.
const LIKELY_STEP = 1 / 30;
// Time between two images, as a multiple of the usual time, above which an image may have been skipped.
const GAP = 1.5;
// Longest time for which an image is shown, as a multiple of the usual time; more than 1, because times are rounded.
const SLACK = 1.25;
// Ratio of the mean to the shortest time between images, above which a video's frames count as uneven.
const UNEVEN = 1.2;
// Tolerance in seconds when times are compared: less than the resolution of times in files.
const TIME_EPSILON = 0.0005;
// Count of decoded images in the queue at which the video pauses.
const MAX_WAITING = 3;
// Playback rate, while images are taken from the queue fast enough.
const SPEED = 2;
// Factor by which a skipped image slows the playback, and count of images without a skip that undo one slowing.
const SLOWER = 0.8, PATIENCE = 10;
// Lower bound of the product of all `SLOWER` factors: at a lower playback rate, seeking to each image is faster.
const MIN_PART = 0.3;
// Longest wait for an image after a seek (ms), and the largest numbers of such waits: `WAITS` while the old image
// may still be shown, `WAITS_FOR_ANY` while no image is available.
const LATE_MS = 150, WAITS = 2, WAITS_FOR_ANY = 100;

function imageOf(video) {
  try {
    return new VideoFrame(video);
  } catch (error) {
    if (error.name === "InvalidStateError") {
      return null;
    }
    throw error;
  }
}

const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

export class Video {
  #video;
  #file;
  #failed;
  #address;
  #known; // about the file, also to another decoder of it
  #tick = 0; // the handle of the next call for an image
  #mediaTime = 0; // of the image that was shown last
  #isEnding = true; // to play on gives no image: before the first one that is asked for, and at the end
  #last = null; // the image that was taken last: { number, time }
  #queue = []; // those that wait
  #asked = null; // who waits for an image: { number, resolve }
  #taking = Promise.resolve(); // images, one after the other
  #turn = Promise.resolve(); // seeks, one after the other
  #seeks = 0; // that are not done
  #stopped = new AbortController();
  #part = 1; // of the speed, so that no image is skipped
  #unskipped = 0; // images since one was skipped

  /** Calls `failed(text)` with the reason if the file ends early. Shares the data of `like`, a decoder of this file. */
  constructor(file, failed, like = null) {
    [this.#file, this.#failed] = [file, failed];
    this.#video = htmlNode("video", { class: "decoder", playsinline: "" });
    this.#video.muted = true;
    document.body.append(this.#video);
    this.#address = URL.createObjectURL(file);
    this.#known = like?.#known ?? {
      isTimed: true, // images know their times
      times: [], // of images, by number
      counted: 0, // images from the first one on
      length: null,
      start: null, // the time of the first image
      step: null, // from an image to the next one, the shortest that was seen
      mean: { step: LIKELY_STEP, count: 1 }, // over so many images from the first one on
    };
  }

  /** Opens the file. Throws an error with the reason in one line if it cannot be played. */
  async open() {
    const video = this.#video;
    if (typeof VideoFrame !== "function" || video.requestVideoFrameCallback === undefined) {
      throw new Error("This browser is too old for video files: use a current one.");
    }
    const isLoaded = await this.#load();
    [this.width, this.height] = [video.videoWidth, video.videoHeight];
    if (!isLoaded || this.width === 0) {
      this.close();
      throw new Error(await this.#whyNot(isLoaded));
    }
    video.onended = () => this.#roll();
    this.#nextTick();
    if (this.#known.start === null) {
      const isBroken = new Promise((resolve) => (video.onerror = () => resolve(true)));
      if (await Promise.race([isBroken, this.#measure()])) {
        await this.#reload();
      }
    }
    this.#last = { number: 0, time: this.#known.start - 1 };
    video.onerror = () => this.#ends();
  }

  /** Count of frames; an estimate until all were decoded; null if unknown. */
  get length() {
    const { duration } = this.#video;
    const passed = duration - this.#known.start;
    return this.#known.length ?? (Number.isFinite(passed) ? Math.max(Math.round(passed / this.#pace), this.#known.counted) : null);
  }

  /** True if frames have uneven intervals: their numbers are estimates unless all before them were decoded. */
  get isUneven() {
    const { mean, step } = this.#known;
    return mean.step > UNEVEN * step;
  }

  /** True if `length` is exact. */
  get isCounted() {
    return this.#known.length !== null;
  }

  /** Returns the time of a frame in seconds; an estimate if the frame was not decoded yet. */
  timeOf(number) {
    const { times, counted } = this.#known;
    return times[number] ?? (times[counted] ?? this.#known.start - this.#pace) + (number - counted) * this.#pace;
  }

  /** Returns the image of a frame, a VideoFrame; null if the file ends before it. Frames in order need no seek. */
  take(number) {
    this.#taking = this.#taking.then(() => {
      if (number > (this.#known.length ?? Infinity) || this.#stopped.signal.aborted) {
        return null;
      }
      return new Promise((resolve) => {
        this.#asked = { number, resolve };
        number === this.#next ? this.#send() : this.#seek(number);
      });
    });
    return this.#taking;
  }

  close() {
    this.#isEnding = true;
    this.#drop();
    this.#answer(null);
    this.#stopped.abort();
    const video = this.#video;
    video.cancelVideoFrameCallback?.(this.#tick);
    video.onerror = video.onended = video.onloadeddata = null;
    video.removeAttribute("src");
    video.load();
    video.remove();
    URL.revokeObjectURL(this.#address);
  }

  // Number of the image that comes next without a seek; null at the end.
  get #next() {
    return this.#queue[0]?.number ?? (this.#isEnding ? null : this.#last.number + 1);
  }

  #drop() {
    this.#video.pause();
    this.#queue.splice(0).forEach(({ image }) => image.close());
  }

  #seek(number) {
    this.#drop();
    this.#isEnding = false;
    this.#alone(() => this.#show(number));
  }

  #answer(image) {
    this.#asked?.resolve(image);
    this.#asked = null;
  }

  async #whyNot(hasSound) {
    const codec = await lacking(this.#file, this.#video);
    if (codec !== null) {
      return `${this.#file.name} is ${codec}, which this browser does not play: host-sim view ${quoted(this.#file.name)} does${codec.startsWith("HEVC") ? ", or a current Safari or Edge" : ""}.`;
    }
    return hasSound ? `${this.#file.name} has no pictures.` : `${this.#file.name} is damaged or no video: expected MP4, WebM or another that this browser knows.`;
  }

  #load() {
    const video = this.#video;
    return new Promise((resolve) => {
      video.onloadeddata = () => resolve(true);
      video.onerror = () => resolve(false);
      video.src = this.#address;
    });
  }

  // Loads the file again, because after an error a browser neither plays it further nor completes a seek.
  #reload() {
    [this.#turn, this.#seeks] = [Promise.resolve(), 0];
    this.#stopped.abort();
    this.#stopped = new AbortController();
    return this.#load();
  }

  // Ends a damaged file at the last frame that could be decoded.
  async #ends() {
    this.#failed(`${this.#file.name} is damaged: it ends here.`);
    this.#known.length = this.#known.counted;
    await this.#reload();
    this.#video.onerror = () => this.#ends();
    this.#isEnding = true;
    this.#answer(null);
  }

  // ---- images

  // The last image in the queue or, if it is empty, the last one taken.
  get #ahead() {
    return this.#queue.at(-1) ?? this.#last;
  }

  // Mean time in seconds from an image to the next.
  get #pace() {
    const { step, count } = this.#known.mean;
    return this.#known.counted <= count ? step : (this.#known.times[this.#known.counted] - this.#known.times[1]) / (this.#known.counted - 1);
  }

  // Measures the start of the video and the time between its first two images.
  async #measure() {
    await this.#alone(async () => {
      // The length of some files is known only after a seek to their end.
      if (this.#video.duration === Infinity) {
        (await this.#imageAt(1e9)).close();
      }
      const { duration } = this.#video;
      const middle = await this.#imageAt(duration / 2);
      // Timestamps should be in microseconds, but Firefox writes seconds.
      this.#known.isTimed = middle.image.timestamp > duration * 1e5;
      middle.close();
      const first = await this.#imageAt(0);
      this.#known.start = first.time;
      first.close();
      const second = await this.#after(first.time);
      second?.close();
      if (second !== null) {
        this.#known.step = second.time - first.time;
        await this.#average(first.time);
      }
    });
  }

  // Measures the mean time between images over longer and longer spans, because a file may round times to
  // milliseconds. Each mean is precise enough to count the images of the next span.
  async #average(start) {
    this.#known.mean = { step: this.#known.step, count: 1 };
    for (let count = 4; start + count * this.#known.mean.step < this.#video.duration; count *= 4) {
      const { step } = this.#known.mean;
      const { time, close } = await this.#imageAt(start + (count + 0.5) * step);
      close();
      const passed = Math.round((time - start) / step);
      this.#known.mean = { step: (time - start) / passed, count: passed };
    }
  }

  // Runs `seek`, an action that seeks, after all earlier ones. Then the video plays on.
  #alone(seek) {
    const { signal } = this.#stopped;
    const failed = (error) => signal.aborted || this.#fail(error);
    this.#seeks += 1;
    this.#turn = this.#turn.then(seek).catch(failed);
    this.#turn = this.#turn.then(() => {
      this.#seeks -= 1;
      this.#roll();
    });
    return this.#turn;
  }

  #roll() {
    const video = this.#video;
    if (this.#seeks > 0 || this.#queue.length >= MAX_WAITING || this.#isEnding) {
      return;
    }
    if (video.ended) {
      // At the end, play() would start at the beginning.
      this.#goBack(Infinity);
      return;
    }
    video.playbackRate = SPEED * this.#part;
    video.play().catch((error) => {
      // A pause before playback has started is no error.
      if (error.name !== "AbortError") {
        this.#fail(error);
      }
    });
  }

  #fail({ message }) {
    this.#failed(`${this.#file.name} cannot be played: ${message}`);
    this.#answer(null);
  }

  async #show(number) {
    const before = this.#known.times[number] === undefined ? this.#known.times[number - 1] : undefined;
    const found = before === undefined ? await this.#imageAt(number === 1 ? 0 : this.timeOf(number) + TIME_EPSILON) : await this.#after(before);
    this.#isEnding = false;
    found === null ? this.#end(number) : this.#add(found, number);
  }

  /** Seeks to a time. Returns the image there: { image, time, close() }. */
  async #imageAt(time) {
    const video = this.#video;
    video.pause();
    const before = this.#mediaTime;
    // After an error the seek never ends, so the listener is removed by `#stopped`.
    const how = { once: true, signal: this.#stopped.signal };
    const seeked = new Promise((resolve) => video.addEventListener("seeked", resolve, how));
    video.currentTime = time;
    await seeked;
    let found = await this.#there();
    for (let waits = 0; waits < WAITS && this.#isLate(found, before, time); waits++) {
      found.close();
      await this.#soon();
      found = await this.#there();
    }
    return found;
  }

  // Waits for the shown image and returns it: on a busy machine, a seek may end before the image is available.
  async #there() {
    for (let waits = 0; waits < WAITS_FOR_ANY && !this.#stopped.signal.aborted; waits++) {
      const found = this.#shown();
      if (found !== null) {
        return found;
      }
      await this.#soon();
    }
    throw new Error("no picture comes");
  }

  #soon() {
    return Promise.race([new Promise((resolve) => this.#video.requestVideoFrameCallback(resolve)), wait(LATE_MS)]);
  }

  // True if `found` may still be from before the seek to `time`: not the image at `time`, but the one at `before` or,
  // as the browser may have played on, a neighbour. Always true if timestamps are not in microseconds.
  #isLate(found, before, time) {
    const step = this.#known.step ?? LIKELY_STEP;
    const isThere = found.time <= time + TIME_EPSILON && time < found.time + SLACK * step;
    return !this.#known.isTimed || (!isThere && Math.abs(found.time - before) < GAP * step);
  }

  // Returns the image that the video element shows, and its time; null if there is none yet.
  #shown() {
    const image = imageOf(this.#video);
    if (image === null) {
      return null;
    }
    if (this.#known.isTimed) {
      this.#mediaTime = image.timestamp / 1e6;
    }
    return { image, time: this.#mediaTime, close: () => image.close() };
  }

  // Seeks to the image after the one at `time`, and returns it; null if none is within reach (60 to 120 seconds).
  async #after(time) {
    const end = Math.min(this.#video.duration, time + 60);
    let reach = GAP * (this.#known.step ?? LIKELY_STEP);
    let next = await this.#imageAt(time + reach);
    while (next.time <= time + TIME_EPSILON && time + reach < end) {
      next.close();
      reach *= 2;
      next = await this.#imageAt(time + reach);
    }
    // If there is an image between `time` and `next`, a seek to just before `next` finds it.
    while (next.time - time > GAP * (this.#known.step ?? 0)) {
      const before = await this.#imageAt(next.time - TIME_EPSILON);
      const isNext = before.time <= time + TIME_EPSILON;
      (isNext ? before : next).close();
      if (isNext) {
        return next;
      }
      next = before;
    }
    if (next.time > time + TIME_EPSILON) {
      return next;
    }
    next.close();
    return null;
  }

  #nextTick() {
    this.#tick = this.#video.requestVideoFrameCallback((_, { mediaTime }) => {
      this.#mediaTime = mediaTime;
      this.#nextTick();
      const found = !this.#isEnding && this.#seeks === 0 ? this.#shown() : null;
      if (found !== null) {
        this.#played(found);
      }
    });
  }

  // Queues the image that the browser shows during playback, or goes back if one was skipped.
  #played(found) {
    const passed = found.time - this.#ahead.time;
    if (passed > TIME_EPSILON && passed <= GAP * (this.#known.step ?? 0)) {
      this.#add(found, this.#ahead.number + 1);
      this.#unskipped += 1;
      if (this.#unskipped % PATIENCE === 0) {
        this.#part = Math.min(this.#part / SLOWER, 1);
      }
      return;
    }
    found.close();
    if (passed > TIME_EPSILON) {
      this.#goBack(found.time);
    }
  }

  // Seeks back to the image after the last queued one, because the browser has already reached `time`.
  #goBack(time) {
    this.#video.pause();
    this.#alone(async () => {
      const { number, time: before } = this.#ahead;
      const next = await this.#after(before);
      if (next === null) {
        this.#end(number + 1);
        return;
      }
      if (next.time < time - TIME_EPSILON) {
        [this.#part, this.#unskipped] = [Math.max(this.#part * SLOWER, MIN_PART), 0];
      }
      this.#add(next, number + 1);
    });
  }

  // Handles a frame `number` that does not exist. Another frame may have been requested meanwhile.
  #end(number) {
    this.#isEnding = true;
    if (number === this.#known.counted + 1) {
      this.#known.length = this.#known.counted;
    }
    if (this.#asked?.number === number) {
      this.#answer(null);
    }
  }

  // ---- delivery

  #add({ image, time }, number) {
    if (this.#known.times[number - 1] !== undefined) {
      this.#known.step = Math.min(this.#known.step ?? Infinity, Math.max(time - this.#known.times[number - 1], 2 * TIME_EPSILON));
    }
    this.#known.times[number] = time;
    if (number === this.#known.counted + 1) {
      this.#known.counted = number;
    }
    this.#queue.push({ image, time, number });
    if (this.#queue.length >= MAX_WAITING) {
      this.#video.pause();
    }
    this.#send();
  }

  // Delivers the requested image. Closes any queued before it, which come from an earlier seek.
  #send() {
    while (this.#asked !== null && this.#queue.length > 0) {
      const { number, image, time } = this.#queue.shift();
      this.#last = { number, time };
      number === this.#asked.number ? this.#answer(image) : image.close();
    }
    if (this.#video.paused && this.#queue.length < MAX_WAITING - 1) {
      this.#roll();
    }
  }
}
