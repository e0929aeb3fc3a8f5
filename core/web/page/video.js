// A video file as a source of frames. None is lost: the video pauses while the trackers are behind, and where the browser
// skipped a picture it goes back for it.

import { lacking } from "./codec.js";

// The time from a picture to the next one in seconds, assumed until it is known.
const LIKELY_STEP = 1 / 30;
// A gap of this many steps may hide a picture.
const GAP = 1.5;
// A picture may last so many steps, because their times are rounded.
const SLACK = 1.25;
// Less than files can tell apart.
const HAIR = 0.0005;
// The number of pictures that wait for the trackers before the video pauses.
const MOST_WAITING = 3;
// After a skipped picture the video is slowed down so much, and after so many pictures without one it is as much quicker again.
const SLOWER = 0.8, PATIENCE = 10;
// Less would be slower than to seek each picture.
const LEAST_PART = 0.3;
const SLOWEST = 0.0625, FASTEST = 16; // of browsers
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
  kind = "video";
  #sink;
  #video;
  #file;
  #address;
  #tick = 0; // the handle of the next call for a picture
  #mediaTime = 0; // of the picture that was shown last
  #isTimed = true; // pictures know their times
  #times = []; // of pictures, by number
  #counted = 0; // pictures from the first one on
  #length = null;
  #step = null; // from a picture to the next one, the shortest that was seen
  #isEnding = false;
  #mean = { step: LIKELY_STEP, count: 1 }; // over so many pictures from the first one on
  #last = null; // the picture that was sent last: { number, time }
  #queue = []; // those that wait
  #isSending = false;
  #turn = Promise.resolve(); // seeks, one after the other
  #seeks = 0; // that are not done
  #wanted = null; // the frame that the user wants to see
  #stopped = new AbortController();
  #isPlaying = false;
  #speed = 1;
  #part = 1; // of the speed, so that no picture is skipped
  #unskipped = 0; // pictures since one was skipped

  constructor(sink, video, file) {
    [this.#sink, this.#video, this.#file] = [sink, video, file];
    this.name = file.name;
    this.#address = URL.createObjectURL(file);
  }

  /** Opens the file. If it cannot be played, throws an error that says why in one line. */
  async open() {
    const video = this.#video;
    if (typeof VideoFrame !== "function" || video.requestVideoFrameCallback === undefined) {
      throw new Error("This browser is too old for video files: use a current Firefox, Chrome, Edge or Safari.");
    }
    const isLoaded = await this.#load();
    [this.width, this.height] = [video.videoWidth, video.videoHeight];
    if (!isLoaded || this.width === 0) {
      this.stop();
      throw new Error(await this.#whyNot(isLoaded));
    }
    video.onended = () => this.#roll();
    this.#nextTick();
    const isBroken = new Promise((resolve) => (video.onerror = () => resolve(true)));
    if (await Promise.race([isBroken, this.#measure()])) {
      await this.#reload();
    }
    video.onerror = () => this.#ends();
    this.seek(1);
  }

  /** The number of frames; an estimate until all were seen. */
  get length() {
    const { duration } = this.#video;
    const passed = duration - (this.#times[1] ?? 0);
    return this.#length ?? (Number.isFinite(passed) ? Math.max(Math.round(passed / this.#pace), this.#counted) : null);
  }

  /** The time of a frame in seconds; an estimate where no frame was seen. */
  timeOf(number) {
    return this.#times[number] ?? this.#times[this.#counted] + (number - this.#counted) * this.#pace;
  }

  play() {
    [this.#isPlaying, this.#isEnding] = [true, false];
    this.#alone(async () => {
      const { currentTime } = this.#video;
      const { time } = this.#ahead;
      if (this.#isPlaying && (currentTime < time || currentTime >= time + (this.#step ?? 0) || this.#video.ended)) {
        (await this.#pictureAt(time + HAIR)).close();
      }
    });
  }

  pause() {
    this.#isPlaying = false;
    this.#video.pause();
    this.#queue.splice(0).forEach(({ picture }) => picture.close());
  }

  step() {
    this.#alone(async () => {
      const next = await this.#after(this.#ahead.time);
      next === null ? this.#end() : this.#add(next, this.#ahead.number + 1);
    });
  }

  /** Shows a frame. */
  seek(number) {
    const isPlaying = this.#isPlaying;
    this.pause();
    [this.#isPlaying, this.#isEnding] = [isPlaying, false];
    this.#wanted = number;
    this.#alone(async () => {
      const wanted = this.#wanted;
      this.#wanted = null;
      if (wanted !== null) {
        await this.#show(wanted);
      }
    });
  }

  restart() {
    this.seek(1);
  }

  set speed(speed) {
    this.#speed = speed;
    this.#video.playbackRate = Math.min(Math.max(speed * this.#part, SLOWEST), FASTEST);
  }

  stop() {
    this.pause();
    this.#stopped.abort();
    const video = this.#video;
    video.cancelVideoFrameCallback?.(this.#tick);
    video.onerror = video.onended = video.onloadeddata = null;
    video.removeAttribute("src");
    video.load();
    URL.revokeObjectURL(this.#address);
  }

  async #whyNot(hasSound) {
    const codec = await lacking(this.#file, this.#video);
    if (codec !== null) {
      return `${this.name} is ${codec}, which this browser does not play: host-sim view ${this.name} does${codec.startsWith("HEVC") ? ", or a current Safari or Edge" : ""}.`;
    }
    return hasSound ? `${this.name} has no pictures.` : `${this.name} is damaged or no video: expected MP4, WebM or another that this browser knows.`;
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
    this.#sink.failed(`${this.name} is damaged: it ends here.`);
    this.#length = this.#counted;
    await this.#reload();
    this.#video.onerror = () => this.#ends();
  }

  // ---- pictures

  // The last picture that was sent or waits.
  get #ahead() {
    return this.#queue.at(-1) ?? this.#last;
  }

  // The mean time from a picture to the next one.
  get #pace() {
    const { step, count } = this.#mean;
    return this.#counted <= count ? step : (this.#times[this.#counted] - this.#times[1]) / (this.#counted - 1);
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
      this.#isTimed = middle.picture.timestamp > duration * 1e5;
      middle.close();
      const first = await this.#pictureAt(0);
      this.#last = { number: 0, time: first.time - 1 };
      first.close();
      const second = await this.#after(first.time);
      second?.close();
      if (second !== null) {
        this.#step = second.time - first.time;
        await this.#average(first.time);
      }
    });
  }

  // A file may round its times to milliseconds: so the mean step is taken over more and more pictures, as far as the one
  // before tells how many they are.
  async #average(start) {
    this.#mean = { step: this.#step, count: 1 };
    for (let count = 4; start + count * this.#mean.step < this.#video.duration; count *= 4) {
      const { step } = this.#mean;
      const { time, close } = await this.#pictureAt(start + (count + 0.5) * step);
      close();
      const passed = Math.round((time - start) / step);
      this.#mean = { step: (time - start) / passed, count: passed };
    }
  }

  // Does something that seeks, after all that does so. Then the video plays on.
  #alone(seek) {
    const { signal } = this.#stopped;
    const failed = (error) => signal.aborted || this.#sink.failed(`${this.name} cannot be played: ${error.message}`);
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
    if (!this.#isPlaying || this.#seeks > 0 || this.#queue.length >= MOST_WAITING || this.#isEnding) {
      return;
    }
    if (video.ended) {
      // To play would begin again.
      this.#goBack(Infinity);
      return;
    }
    this.speed = this.#speed;
    video.play().catch((error) => {
      // A pause soon after is no error.
      if (error.name !== "AbortError") {
        this.#sink.failed(`${this.name} cannot be played: ${error.message}`);
      }
    });
  }

  async #show(number) {
    const before = this.#times[number] === undefined ? this.#times[number - 1] : undefined;
    const found = before === undefined ? await this.#pictureAt(number === 1 ? 0 : this.timeOf(number) + HAIR) : await this.#after(before);
    if (found === null) {
      this.#end();
    } else if (this.#wanted !== null) {
      found.close();
    } else {
      this.#add(found, number);
    }
  }

  /** The picture at a time: { picture, time, close() }. */
  async #pictureAt(time) {
    const video = this.#video;
    video.pause();
    const before = this.#mediaTime;
    // If another source takes the video, or after an error, this seek has no end, and what waits for it has none.
    const how = { once: true, signal: this.#stopped.signal };
    const seeked = new Promise((resolve) => video.addEventListener("seeked", resolve, how));
    video.currentTime = time;
    await seeked;
    let found = await this.#next();
    for (let waits = 0; waits < WAITS && this.#isLate(found, before, time); waits++) {
      found.close();
      await this.#soon();
      found = await this.#next();
    }
    return found;
  }

  // The picture that is shown. On a busy machine a seek may end before its picture is there.
  async #next() {
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
    const step = this.#step ?? LIKELY_STEP;
    const isThere = found.time <= time + HAIR && time < found.time + SLACK * step;
    return !this.#isTimed || (!isThere && Math.abs(found.time - before) < GAP * step);
  }

  // The picture that is there; null if there is none yet.
  #shown() {
    const picture = pictureOf(this.#video);
    if (picture === null) {
      return null;
    }
    if (this.#isTimed) {
      this.#mediaTime = picture.timestamp / 1e6;
    }
    return { picture, time: this.#mediaTime, close: () => picture.close() };
  }

  // The picture after the one at `time`; null if there is none.
  async #after(time) {
    const end = Math.min(this.#video.duration, time + 60);
    let reach = GAP * (this.#step ?? LIKELY_STEP);
    let next = await this.#pictureAt(time + reach);
    while (next.time <= time + HAIR && time + reach < end) {
      next.close();
      reach *= 2;
      next = await this.#pictureAt(time + reach);
    }
    // A picture between them would be the one just before it.
    while (next.time - time > GAP * (this.#step ?? 0)) {
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
      const found = this.#isPlaying && this.#seeks === 0 ? this.#shown() : null;
      if (found !== null) {
        this.#played(found);
      }
    });
  }

  // Takes the picture that the browser shows while it plays.
  #played(found) {
    const passed = found.time - this.#ahead.time;
    if (passed > HAIR && passed <= GAP * (this.#step ?? 0)) {
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
      const next = this.#isPlaying ? await this.#after(this.#ahead.time) : null;
      if (!this.#isPlaying || this.#wanted !== null) {
        next?.close();
      } else if (next === null) {
        this.#end();
      } else {
        if (next.time < time - HAIR) {
          [this.#part, this.#unskipped] = [Math.max(this.#part * SLOWER, LEAST_PART), 0];
        }
        this.#add(next, this.#ahead.number + 1);
      }
    });
  }

  async #end() {
    this.#isEnding = true;
    if (this.#ahead.number === this.#counted) {
      this.#length = this.#counted;
    }
    const { signal } = this.#stopped;
    while (this.#queue.length > 0) {
      await wait(10);
    }
    if (!signal.aborted) {
      this.#sink.ended();
    }
  }

  // ---- to the trackers

  #add({ picture, time }, number) {
    if (this.#times[number - 1] !== undefined) {
      this.#step = Math.min(this.#step ?? Infinity, Math.max(time - this.#times[number - 1], 2 * HAIR));
    }
    this.#times[number] = time;
    if (number === this.#counted + 1) {
      this.#counted = number;
    }
    this.#queue.push({ picture, time, number });
    if (this.#queue.length >= MOST_WAITING) {
      this.#video.pause();
    }
    this.#send();
  }

  async #send() {
    if (this.#isSending) {
      return;
    }
    this.#isSending = true;
    while (this.#queue.length > 0) {
      await this.#sink.room();
      const next = this.#queue.shift();
      if (next !== undefined) {
        this.#last = { number: next.number, time: next.time };
        this.#sink.send({ number: next.number, picture: next.picture });
      }
      if (this.#video.paused && this.#queue.length < MOST_WAITING - 1) {
        this.#roll();
      }
    }
    this.#isSending = false;
  }
}
