// The built-in recording as a source of frames. No frame of it is ever dropped: it waits until the trackers are ready.

export const BUILT_IN = { name: "street", length: 300, rate: 25, box: { x: 268, y: 101, width: 39, height: 14 } };

export class Recording {
  kind = "recording";
  name = BUILT_IN.name;
  length = BUILT_IN.length;
  rate = BUILT_IN.rate;
  #sink;
  #last = 0; // the number of the frame that was sent last
  #wanted = null; // the frame that is sent as soon as there is room
  #isWaiting = false;
  #timer = null;
  #speed = 1;

  /** `sink`: { room() a promise for room for a frame, send(frame), ended() }. */
  constructor(sink) {
    this.#sink = sink;
  }

  /** Nobody knows when it was taken. */
  timeOf() {
    return null;
  }

  play() {
    clearInterval(this.#timer);
    this.#timer = setInterval(() => {
      if (this.#wanted === null) {
        this.step();
      }
    }, 1000 / (this.rate * this.#speed));
  }

  pause() {
    clearInterval(this.#timer);
    [this.#timer, this.#wanted] = [null, null];
  }

  step() {
    this.seek(this.#last + 1);
  }

  async seek(number) {
    this.#wanted = number;
    if (this.#isWaiting) {
      return;
    }
    this.#isWaiting = true;
    await this.#sink.room();
    this.#isWaiting = false;
    const next = this.#wanted;
    this.#wanted = null;
    if (next > this.length) {
      this.#sink.ended();
    } else if (next !== null) {
      this.#last = next;
      this.#sink.send({ number: next, index: next - 1 });
    }
  }

  restart() {
    this.seek(1);
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
