// Plays one source of frames at a time: plays, steps, seeks and holds it. Frames go to the worker, answers to the page.

export class Player {
  isPlaying = false;
  repeats = true;
  source = null;
  /** Frames of a camera that were not followed because the trackers were behind. */
  dropped = 0;
  #follower;
  #page;
  #pass = 0; // of the source, from its first frame on
  #making = 0; // pictures on their way to the worker
  #isHeld = false;
  #hasEnded = false;
  #speed = 1;

  /**
   * `page`: { shown() the target whose pictures are wanted, behind() the frame where following stopped, if that is before the
   * frame that is shown, or null, sent(number), answered(reply),
   * restarted(), changed(), say(text) }.
   */
  constructor(follower, page) {
    this.#follower = follower;
    this.#page = page;
  }

  /** The calls that a source may make. */
  get sink() {
    return {
      room: () => this.#room(),
      send: (frame) => this.#send(frame),
      show: (video, count) => this.#show(video, count),
      missed: (count) => {
        this.dropped += this.#isHeld ? 0 : count;
      },
      ended: () => this.#ended(),
      failed: (text) => {
        this.play(false);
        this.#page.say(text);
      },
    };
  }

  /** Plays frames of `source` from now on. */
  use(source) {
    this.source?.stop();
    this.source = source;
    this.dropped = 0;
    [this.isPlaying, this.#hasEnded] = [false, false];
    this.#pass += 1;
    source.speed = this.#speed;
  }

  play(on) {
    if (on && this.#hasEnded) {
      this.#begin();
    } else if (on && this.source.kind !== "camera") {
      this.#goBack();
    }
    this.isPlaying = on;
    on ? this.source.play() : this.source.pause();
    this.#page.changed();
  }

  step() {
    this.play(false);
    this.source.step();
  }

  /** Shows a frame. What was followed stays. */
  seek(number) {
    this.play(false);
    this.#hasEnded = false;
    this.source.seek(number);
  }

  /** Starts again at the first frame, and follows all anew. */
  restart() {
    this.#hasEnded = false;
    this.#pass += 1;
    this.#page.restarted();
    this.source.restart();
  }

  // At the end of the built-in recording it is followed again, so that there is always something to see. What was followed in
  // a video stays.
  #begin() {
    this.#hasEnded = false;
    this.source.kind === "recording" ? this.restart() : this.source.seek(1);
  }

  #goBack() {
    const behind = this.#page.behind();
    if (behind !== null) {
      this.#page.say(`Goes on from frame ${behind}: following had stopped there.`);
      this.source.seek(behind);
    }
  }

  /** Waits while the user draws a box. */
  hold(on) {
    if (this.#isHeld === on) {
      return;
    }
    this.#isHeld = on;
    if (this.isPlaying) {
      on ? this.source.pause() : this.source.play();
    }
  }

  set speed(speed) {
    this.#speed = speed;
    this.source.speed = speed;
  }

  #ended() {
    if (this.repeats && this.isPlaying) {
      this.#begin();
      this.source.play();
    } else {
      this.#hasEnded = true;
      this.play(false);
    }
  }

  #room() {
    return this.#follower.free();
  }

  // Follows the picture that a camera shows now. `count` gives its number, if it is followed.
  async #show(video, count) {
    if (this.#isHeld) {
      return;
    }
    if (!this.isPlaying) {
      // This picture stays until there is time for it.
      await this.#follower.free();
    } else if (this.#making > 0 || this.#follower.isBehind) {
      this.dropped += 1;
      return;
    }
    const pass = this.#pass;
    this.#making += 1;
    const picture = await pictureOf(video).catch(() => null);
    this.#making -= 1;
    if (picture !== null && pass === this.#pass) {
      await this.#send({ number: count(), picture });
    } else {
      picture?.close();
    }
  }

  async #send(frame) {
    const pass = this.#pass;
    const answered = this.#follower.frame({ ...frame, shown: this.#page.shown() });
    this.#page.sent(frame.number);
    try {
      const reply = await answered;
      if (pass === this.#pass) {
        this.#page.answered(reply);
      } else {
        reply.picture.close();
      }
    } catch (error) {
      this.play(false);
      this.#page.say(`The trackers stopped: ${error.message}.`);
    }
  }
}

// The picture that a video shows now. A VideoFrame shares the pixels of the video, in browsers that have it; an
// ImageBitmap is a copy.
async function pictureOf(video) {
  return typeof VideoFrame === "function" ? new VideoFrame(video) : createImageBitmap(video);
}
