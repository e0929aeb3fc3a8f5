// The built-in recording as a source of frames. No frame of it is ever dropped: it waits until the trackers are ready.

import { BUILT_IN } from "./synthetic.js";

export class Recording {
  kind = "recording";
  name = BUILT_IN.name;
  width = BUILT_IN.width;
  height = BUILT_IN.height;
  #sink;
  #next = 0;
  #timer = null;
  #speed = 1;

  /** `sink`: { offer(frame) returns true if the frame was taken, ended() }. */
  constructor(sink) {
    this.#sink = sink;
  }

  get length() {
    return BUILT_IN.length;
  }

  play() {
    clearInterval(this.#timer);
    this.#timer = setInterval(() => this.step(), 1000 / (BUILT_IN.rate * this.#speed));
  }

  pause() {
    clearInterval(this.#timer);
    this.#timer = null;
  }

  step() {
    if (this.#next === BUILT_IN.length) {
      this.#sink.ended();
    } else if (this.#sink.offer({ number: this.#next + 1, index: this.#next })) {
      this.#next += 1;
    }
  }

  restart() {
    this.#next = 0;
    if (this.#timer === null) {
      this.step();
    }
  }

  set speed(speed) {
    this.#speed = speed;
    if (this.#timer !== null) {
      this.play();
    }
  }

  stop() {
    this.pause();
  }
}
