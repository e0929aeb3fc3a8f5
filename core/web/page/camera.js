// The webcam as a source of frames. A frame that comes while the trackers are behind is dropped, and counted.

import { eachPicture } from "./pictures.js";

const WANTED = { audio: false, video: { width: { ideal: 640 }, height: { ideal: 480 }, frameRate: { ideal: 60 }, facingMode: "environment" } };

const REFUSED = {
  NotAllowedError: "The camera was refused: allow it for this page in the browser, or choose a video file.",
  NotFoundError: "There is no camera: connect one, or choose a video file.",
  NotReadableError: "The camera is in use by another program: close that, or choose a video file.",
};

export class Camera {
  kind = "camera";
  name = "camera";
  length = null;
  #sink;
  #video;
  #number = 0;
  #end = () => {};
  #isPlaying = false;
  #isOneWanted = false;

  constructor(sink, video) {
    this.#sink = sink;
    this.#video = video;
  }

  /** Asks for the camera. If there is none, throws an error that says why in one line. */
  async open() {
    if (navigator.mediaDevices === undefined) {
      throw new Error("This page may not use the camera: open it from https or from a file, or choose a video file.");
    }
    try {
      this.#video.srcObject = await navigator.mediaDevices.getUserMedia(WANTED);
      await this.#video.play();
    } catch (error) {
      this.stop();
      throw new Error(REFUSED[error.name] ?? `The camera cannot be used: ${error.message}`);
    }
    [this.width, this.height] = [this.#video.videoWidth, this.#video.videoHeight];
    this.#end = eachPicture(this.#video, (picture) => this.#seen(picture));
    this.#video.srcObject.getVideoTracks()[0].addEventListener("ended", () => this.#sink.failed("The camera was disconnected."));
  }

  /** The times of a camera are not kept. */
  timeOf() {
    return null;
  }

  play() {
    this.#isPlaying = true;
  }

  pause() {
    this.#isPlaying = false;
  }

  step() {
    this.#isOneWanted = true;
  }

  /** A camera cannot start again: it goes on. */
  restart() {}

  set speed(_) {
    // A camera has a speed of its own.
  }

  stop() {
    this.#end();
    for (const track of this.#video.srcObject?.getTracks() ?? []) {
      track.stop();
    }
    this.#video.srcObject = null;
  }

  async #seen({ missed }) {
    if (!this.#isPlaying && !this.#isOneWanted) {
      return;
    }
    this.#sink.missed(missed);
    this.#isOneWanted = false;
    await this.#sink.show(this.#video, () => ++this.#number);
  }
}
