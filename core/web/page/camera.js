// The webcam as a source of frames. A frame that arrives while the trackers are busy is dropped and counted.

import { htmlNode } from "./dom.js";
import { eachImage } from "./camera-images.js";

const WANTED = { audio: false, video: { width: { ideal: 640 }, height: { ideal: 480 }, frameRate: { ideal: 60 }, facingMode: "environment" } };
const MAX_BYTES = 96 << 20; // of images that are kept
// One frame is tracked and one waits. A third one would only be late.
const MAX_UNDER_WAY = 2;

const REFUSED = {
  NotAllowedError: "The camera was refused: allow it for this page in the browser, or choose a video file.",
  NotFoundError: "There is no camera: connect one, or choose a video file.",
  NotReadableError: "The camera is in use by another program: close that, or choose a video file.",
};

export class Camera {
  name = "camera";
  words = "/dev/video0";
  live = true;
  /** Number of the newest frame. */
  last = 0;
  #follower;
  #page;
  #video = htmlNode("video", { class: "decoder", playsinline: "" });
  #kept = new Map(); // { image, time it came } by number, the oldest first
  #dropped = 0;
  #sent = 0; // frames to the worker
  #underWay = 0;
  #isStopped = false;
  #end = () => {};

  /** `page` has callbacks: { came() when a frame has arrived, failed(text) }. */
  constructor(follower, page) {
    [this.#follower, this.#page] = [follower, page];
  }

  /** Requests the camera. Throws an error with the reason in one line if it cannot be used. */
  async open() {
    if (navigator.mediaDevices === undefined) {
      throw new Error("This page may not use the camera: open it from https or from a file, or choose a video file.");
    }
    const video = this.#video;
    video.muted = true;
    document.body.append(video);
    try {
      video.srcObject = await navigator.mediaDevices.getUserMedia(WANTED);
      await video.play();
    } catch (error) {
      this.close();
      throw new Error(REFUSED[error.name] ?? `The camera cannot be used: ${error.message}`);
    }
    [this.width, this.height] = [video.videoWidth, video.videoHeight];
    video.srcObject.getVideoTracks()[0].addEventListener("ended", () => this.#page.failed("The camera was disconnected."));
  }

  /** Starts to take images; resolves after the first one. */
  async start() {
    await this.#follower.ask("clear");
    await new Promise((resolve) => {
      this.#end = eachImage(this.#video, ({ missed }) => this.#seen(missed).then(resolve));
    });
  }

  get oldest() {
    return this.#kept.keys().next().value;
  }

  /** Returns the oldest and newest kept frame number, count of dropped frames, and age of frame `number` in ms. */
  news(number) {
    const time = this.#kept.get(number)?.time ?? performance.now();
    return { live: { oldest: this.oldest, newest: this.last, dropped: this.#dropped, latency_ms: performance.now() - time } };
  }

  /** Returns no image, because the worker has the frames already. */
  async frame() {
    return {};
  }

  async image(number) {
    const kept = this.#kept.get(number);
    if (kept === undefined) {
      throw new Error(`Frame ${number} is not kept any more.`);
    }
    return kept.image;
  }

  /** Stops taking images, but keeps the last ones. */
  stop() {
    this.#isStopped = true;
    this.#end();
    for (const track of this.#video.srcObject?.getTracks() ?? []) {
      track.stop();
    }
    this.#video.remove();
  }

  close() {
    this.stop();
    this.#kept.forEach(({ image }) => image.close());
    this.#kept.clear();
  }

  async #seen(missed) {
    this.#dropped += missed;
    if (this.#underWay >= MAX_UNDER_WAY) {
      this.#dropped += 1;
      return;
    }
    this.#underWay += 1;
    try {
      await this.#take(performance.now());
    } catch (error) {
      this.#page.failed(`The camera gives no picture: ${error.message}.`);
    } finally {
      this.#underWay -= 1;
    }
  }

  async #take(time) {
    const seen = await imageOf(this.#video);
    if (this.#isStopped) {
      seen.close();
      return;
    }
    const number = ++this.#sent;
    const { image } = await this.#follower.ask("keep", { number, image: seen });
    this.#keep(number, { image: await createImageBitmap(image), time });
    image.close();
    // Two images may be copied at the same time, and the older one may finish last.
    this.last = Math.max(this.last, number);
    this.#page.came();
  }

  #keep(number, kept) {
    this.#kept.set(number, kept);
    const oldest = number - Math.floor(MAX_BYTES / (4 * this.width * this.height));
    this.#kept.get(oldest)?.image.close();
    this.#kept.delete(oldest);
  }
}

// Returns the current image of a video: a VideoFrame, which shares the video's pixels, or else an ImageBitmap, a
// copy.
async function imageOf(video) {
  return typeof VideoFrame === "function" ? new VideoFrame(video) : createImageBitmap(video);
}
