// The pictures of a video file by their numbers. None is lost: where the browser skipped a picture, this goes back for it.

import { lacking } from "./codec.js";
import { quoted } from "./command.js";
import { htmlNode } from "./dom.js";

// The time from a picture to the next one in seconds, assumed until it is known.
const LIKELY_STEP = 1 / 30;
// A gap between pictures of more than this many steps may hide a skipped one.
const GAP = 1.5;
// A picture may last so many steps, because their times are rounded.
const SLACK = 1.25;
// A mean step that is so much longer than the shortest one.
const UNEVEN = 1.2;
// Less than files can tell apart.
const HAIR = 0.0005;
// The number of pictures that wait to be taken before the video pauses.
const MOST_WAITING = 3;
// As quick as it plays, while pictures are taken that quickly.
const SPEED = 2;
// After a skipped picture the video is slowed down so much, and after so many pictures without one it is as much quicker again.
const SLOWER = 0.8, PATIENCE = 10;
// Less would be slower than to seek each picture.
const LEAST_PART = 0.3;
// The longest wait for a picture after its seek (ms), and the most waits: for an old picture, and for any.
const LATE_MS = 150, WAITS = 2, WAITS_FOR_ANY = 100;

// The picture that a video shows; null if there is none yet.
function pictureOf(video) {
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
  #tick = 0; // the handle of the next call for a picture
  #mediaTime = 0; // of the picture that was shown last
  #isEnding = true; // to play on gives no picture: before the first one that is asked for, and at the end
  #last = null; // the picture that was taken last: { number, time }
  #queue = []; // those that wait
  #asked = null; // who waits for a picture: { number, resolve }
  #taking = Promise.resolve(); // pictures, one after the other
  #turn = Promise.resolve(); // seeks, one after the other
  #seeks = 0; // that are not done
  #stopped = new AbortController();
  #part = 1; // of the speed, so that no picture is skipped
  #unskipped = 0; // pictures since one was skipped

  /** `failed(text)` is told why the file ends early. `like`: another decoder of this file, which is open. */
  constructor(file, failed, like = null) {
    [this.#file, this.#failed] = [file, failed];
    this.#video = htmlNode("video", { class: "decoder", playsinline: "" });
    this.#video.muted = true;
    document.body.append(this.#video);
    this.#address = URL.createObjectURL(file);
    this.#known = like?.#known ?? {
      isTimed: true, // pictures know their times
      times: [], // of pictures, by number
      counted: 0, // pictures from the first one on
      length: null,
      start: null, // the time of the first picture
      step: null, // from a picture to the next one, the shortest that was seen
      mean: { step: LIKELY_STEP, count: 1 }, // over so many pictures from the first one on
    };
  }

  /** Opens the file. If it cannot be played, throws an error that says why in one line. */
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

  /** The number of frames; an estimate until all were seen. */
  get length() {
    const { duration } = this.#video;
    const passed = duration - this.#known.start;
    return this.#known.length ?? (Number.isFinite(passed) ? Math.max(Math.round(passed / this.#pace), this.#known.counted) : null);
  }

  /** True if frames come at uneven times: then those that were not played from the first one on have estimated numbers. */
  get isUneven() {
    const { mean, step } = this.#known;
    return mean.step > UNEVEN * step;
  }

  /** True if the number of frames is no estimate. */
  get isCounted() {
    return this.#known.length !== null;
  }

  /** The time of a frame in seconds; an estimate where no frame was seen. */
  timeOf(number) {
    const { times, counted } = this.#known;
    return times[number] ?? (times[counted] ?? this.#known.start - this.#pace) + (number - counted) * this.#pace;
  }

  /** The picture of a frame, a VideoFrame; null if the file ends before it. Those that are taken in order come without seeking. */
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

  // The number of the picture that comes without seeking; null at the end.
  get #next() {
    return this.#queue[0]?.number ?? (this.#isEnding ? null : this.#last.number + 1);
  }

  // Forgets the pictures that wait.
  #drop() {
    this.#video.pause();
    this.#queue.splice(0).forEach(({ picture }) => picture.close());
  }

  #seek(number) {
    this.#drop();
    this.#isEnding = false;
    this.#alone(() => this.#show(number));
  }

  #answer(picture) {
    this.#asked?.resolve(picture);
    this.#asked = null;
  }

  async #whyNot(hasSound) {
    const codec = await lacking(this.#file, this.#video);
    if (codec !== null) {
      return `${this.#file.name} is ${codec}, which this browser does not play: host-sim view ${quoted(this.#file.name)} does${codec.startsWith("HEVC") ? ", or a current Safari or Edge" : ""}.`;
    }
    return hasSound ? `${this.#file.name} has no pictures.` : `${this.#file.name} is damaged or no video: expected MP4, WebM or another that this browser knows.`;
  }

  /** Returns whether the browser can play it. */
  #load() {
    const video = this.#video;
    return new Promise((resolve) => {
      video.onloadeddata = () => resolve(true);
      video.onerror = () => resolve(false);
      video.src = this.#address;
    });
  }

  // After an error a browser plays nothing of the file any more, and no seek ends.
  #reload() {
    [this.#turn, this.#seeks] = [Promise.resolve(), 0];
    this.#stopped.abort();
    this.#stopped = new AbortController();
    return this.#load();
  }

  // A damaged file is as long as it can be read.
  async #ends() {
    this.#failed(`${this.#file.name} is damaged: it ends here.`);
    this.#known.length = this.#known.counted;
    await this.#reload();
    this.#video.onerror = () => this.#ends();
    this.#isEnding = true;
    this.#answer(null);
  }

  // ---- pictures

  // The last picture that was taken or waits.
  get #ahead() {
    return this.#queue.at(-1) ?? this.#last;
  }

  // The mean time from a picture to the next one.
  get #pace() {
    const { step, count } = this.#known.mean;
    return this.#known.counted <= count ? step : (this.#known.times[this.#known.counted] - this.#known.times[1]) / (this.#known.counted - 1);
  }

  // The first two pictures tell how long one takes.
  async #measure() {
    await this.#alone(async () => {
      // Of some files the length is known at their end.
      if (this.#video.duration === Infinity) {
        (await this.#pictureAt(1e9)).close();
      }
      const { duration } = this.#video;
      const middle = await this.#pictureAt(duration / 2);
      // In Firefox they count seconds as microseconds.
      this.#known.isTimed = middle.picture.timestamp > duration * 1e5;
      middle.close();
      const first = await this.#pictureAt(0);
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

  // A file may round its times to milliseconds: so the mean step is taken over more and more pictures, as far as the one
  // before tells how many they are.
  async #average(start) {
    this.#known.mean = { step: this.#known.step, count: 1 };
    for (let count = 4; start + count * this.#known.mean.step < this.#video.duration; count *= 4) {
      const { step } = this.#known.mean;
      const { time, close } = await this.#pictureAt(start + (count + 0.5) * step);
      close();
      const passed = Math.round((time - start) / step);
      this.#known.mean = { step: (time - start) / passed, count: passed };
    }
  }

  // Does something that seeks, after all that does so. Then the video plays on.
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
    if (this.#seeks > 0 || this.#queue.length >= MOST_WAITING || this.#isEnding) {
      return;
    }
    if (video.ended) {
      // To play would begin again.
      this.#goBack(Infinity);
      return;
    }
    video.playbackRate = SPEED * this.#part;
    video.play().catch((error) => {
      // A pause soon after is no error.
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
    const found = before === undefined ? await this.#pictureAt(number === 1 ? 0 : this.timeOf(number) + HAIR) : await this.#after(before);
    this.#isEnding = false;
    found === null ? this.#end(number) : this.#add(found, number);
  }

  /** The picture at a time: { picture, time, close() }. */
  async #pictureAt(time) {
    const video = this.#video;
    video.pause();
    const before = this.#mediaTime;
    // After an error this seek has no end, and what waits for it has none.
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

  // The picture that is shown. On a busy machine a seek may end before its picture is there.
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

  // True if this may still be the picture of before the seek to `time`, or the one that came while it paused.
  #isLate(found, before, time) {
    const step = this.#known.step ?? LIKELY_STEP;
    const isThere = found.time <= time + HAIR && time < found.time + SLACK * step;
    return !this.#known.isTimed || (!isThere && Math.abs(found.time - before) < GAP * step);
  }

  // The picture that the video element shows now, and its time; null if there is none yet.
  #shown() {
    const picture = pictureOf(this.#video);
    if (picture === null) {
      return null;
    }
    if (this.#known.isTimed) {
      this.#mediaTime = picture.timestamp / 1e6;
    }
    return { picture, time: this.#mediaTime, close: () => picture.close() };
  }

  // The picture after the one at `time`; null if there is none.
  async #after(time) {
    const end = Math.min(this.#video.duration, time + 60);
    let reach = GAP * (this.#known.step ?? LIKELY_STEP);
    let next = await this.#pictureAt(time + reach);
    while (next.time <= time + HAIR && time + reach < end) {
      next.close();
      reach *= 2;
      next = await this.#pictureAt(time + reach);
    }
    // A picture between them would be the one just before it.
    while (next.time - time > GAP * (this.#known.step ?? 0)) {
      const before = await this.#pictureAt(next.time - HAIR);
      const isNext = before.time <= time + HAIR;
      (isNext ? before : next).close();
      if (isNext) {
        return next;
      }
      next = before;
    }
    if (next.time > time + HAIR) {
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

  // Takes the picture that the browser shows while it plays.
  #played(found) {
    const passed = found.time - this.#ahead.time;
    if (passed > HAIR && passed <= GAP * (this.#known.step ?? 0)) {
      this.#add(found, this.#ahead.number + 1);
      this.#unskipped += 1;
      if (this.#unskipped % PATIENCE === 0) {
        this.#part = Math.min(this.#part / SLOWER, 1);
      }
      return;
    }
    found.close();
    if (passed > HAIR) {
      this.#goBack(found.time);
    }
  }

  // Goes back for the picture after the last one, because the browser shows the one at `time`.
  #goBack(time) {
    this.#video.pause();
    this.#alone(async () => {
      const { number, time: before } = this.#ahead;
      const next = await this.#after(before);
      if (next === null) {
        this.#end(number + 1);
        return;
      }
      if (next.time < time - HAIR) {
        [this.#part, this.#unskipped] = [Math.max(this.#part * SLOWER, LEAST_PART), 0];
      }
      this.#add(next, number + 1);
    });
  }

  // There is no frame of this number. Another one may have been asked for meanwhile.
  #end(number) {
    this.#isEnding = true;
    if (number === this.#known.counted + 1) {
      this.#known.length = this.#known.counted;
    }
    if (this.#asked?.number === number) {
      this.#answer(null);
    }
  }

  // ---- to who asked

  #add({ picture, time }, number) {
    if (this.#known.times[number - 1] !== undefined) {
      this.#known.step = Math.min(this.#known.step ?? Infinity, Math.max(time - this.#known.times[number - 1], 2 * HAIR));
    }
    this.#known.times[number] = time;
    if (number === this.#known.counted + 1) {
      this.#known.counted = number;
    }
    this.#queue.push({ picture, time, number });
    if (this.#queue.length >= MOST_WAITING) {
      this.#video.pause();
    }
    this.#send();
  }

  // Pictures that wait before the requested one came by playing, before a seek went past them.
  #send() {
    while (this.#asked !== null && this.#queue.length > 0) {
      const { number, picture, time } = this.#queue.shift();
      this.#last = { number, time };
      number === this.#asked.number ? this.#answer(picture) : picture.close();
    }
    if (this.#video.paused && this.#queue.length < MOST_WAITING - 1) {
      this.#roll();
    }
  }
}
