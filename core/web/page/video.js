// A video file as a source of frames. It plays at its own time: a frame that comes while the trackers are behind is
// dropped, and counted.

import { eachPicture } from "./pictures.js";

// The time of a picture in seconds, assumed until the video has played.
const LIKELY_STEP = 1 / 30;

export class Video {
  kind = "video";
  #sink;
  #video;
  #address;
  #end = () => {};
  #step = Infinity; // seconds from a picture to the next one, the shortest that was seen
  #time = null; // of the last picture
  #number = 0;
  #isPlaying = false;
  #isSeeking = false; // back to the first picture

  constructor(sink, video, file) {
    this.#sink = sink;
    this.#video = video;
    this.name = file.name;
    this.#address = URL.createObjectURL(file);
  }

  /** Opens the file. If it cannot be played, throws an error that says why in one line. */
  async open() {
    const video = this.#video;
    const loaded = new Promise((resolve, reject) => {
      video.onloadeddata = resolve;
      video.onerror = reject;
    });
    // The first picture comes before the video plays.
    this.#end = eachPicture(video, (picture) => this.#seen(picture));
    video.src = this.#address;
    try {
      await loaded;
    } catch {
      this.stop();
      throw new Error(`${this.name} is no video that this browser plays: expected MP4, WebM or another that it knows.`);
    }
    [this.width, this.height] = [video.videoWidth, video.videoHeight];
    if (this.width === 0) {
      this.stop();
      throw new Error(`${this.name} has no pictures.`);
    }
    video.onerror = () => this.#sink.failed(`${this.name} is damaged: it ends here.`);
    video.onended = () => this.#sink.ended();
  }

  get length() {
    return this.#step === Infinity ? null : Math.round(this.#video.duration / this.#step);
  }

  play() {
    this.#isPlaying = true;
    this.#video.play().catch((error) => {
      // A pause soon after is no error.
      if (error.name !== "AbortError") {
        this.#sink.failed(`${this.name} cannot be played: ${error.message}`);
      }
    });
  }

  pause() {
    this.#isPlaying = false;
    this.#video.pause();
  }

  step() {
    if (this.#video.ended) {
      this.#sink.ended();
    } else {
      // Seeks to the middle of the next picture, because its edges are rounded.
      this.#video.currentTime = (this.#time ?? 0) + 1.5 * (this.#step === Infinity ? LIKELY_STEP : this.#step);
    }
  }

  restart() {
    [this.#time, this.#number] = [null, 0];
    this.#isSeeking = true;
    this.#video.onseeked = () => {
      [this.#isSeeking, this.#video.onseeked] = [false, null];
      this.#seen({ time: this.#video.currentTime, missed: 0 });
    };
    this.#video.currentTime = 0;
  }

  set speed(speed) {
    this.#video.playbackRate = speed;
  }

  stop() {
    this.#end();
    const video = this.#video;
    video.onerror = video.onended = video.onloadeddata = video.onseeked = null;
    this.#video.removeAttribute("src");
    this.#video.load();
    URL.revokeObjectURL(this.#address);
  }

  async #seen({ time, missed }) {
    if (this.#isSeeking) {
      return;
    }
    if (this.#isPlaying) {
      this.#sink.missed(missed);
    }
    if (time !== this.#time) {
      const number = this.#count(time);
      await this.#sink.show(this.#video, () => number);
    }
  }

  // The number of the picture at `time`. It is computed from the time, so that dropped pictures are counted, too.
  #count(time) {
    const passed = this.#time === null ? 0 : time - this.#time;
    if (passed > 0.001) {
      this.#step = Math.min(this.#step, passed);
    }
    const byTime = this.#step === Infinity ? 1 : Math.round(time / this.#step) + 1;
    this.#time = time;
    this.#number = Math.max(this.#number + (passed > 0 ? 1 : 0), byTime);
    return this.#number;
  }
}
