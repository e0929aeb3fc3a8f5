// The video with its boxes: draws the frames that come, one after the other, and packs them into a WebM file.

import { drawFrame } from "./stage.js";
import { Webm } from "./webm.js";

// Smaller pictures are enlarged, so that lines and words have room. In larger ones these grow.
const LEAST_HEIGHT = 480;
const FINE_HEIGHT = 720;
const MOST_WAITING = 4;
// From a picture that needs no other to the next such one.
const KEY_EACH = 60;
const BITS_OF_PIXEL = 0.15, RATE = 30;

export class Film {
  #canvas;
  #encoder;
  #webm;
  #free = []; // who waits until there is room for a picture
  #pictures = 0;
  #last = 0; // milliseconds
  #step = 1000 / RATE; // from a picture to the next one

  /** Opens a film of frames of `size`. Throws an error that says in one line why this browser makes none. */
  static async open(size, failed) {
    const config = configOf(size);
    if (typeof VideoEncoder !== "function" || !(await VideoEncoder.isConfigSupported(config)).supported) {
      throw new Error("This browser makes no videos: type the command below, with --video boxes.webm.");
    }
    return new Film(config, failed);
  }

  constructor(config, failed) {
    this.#canvas = new OffscreenCanvas(config.width, config.height);
    this.#webm = new Webm(config.width, config.height);
    this.#encoder = new VideoEncoder({ output: (chunk) => this.#packed(chunk), error: failed });
    this.#encoder.addEventListener("dequeue", () => this.#free.splice(0).forEach((go) => go()));
    this.#encoder.configure(config);
  }

  /** A promise for room for a picture. */
  async ready() {
    while (this.#encoder.state === "configured" && this.#encoder.encodeQueueSize >= MOST_WAITING) {
      await new Promise((resolve) => this.#free.push(resolve));
    }
  }

  /** Adds a picture. `scene`: see stage.js; `time` in seconds. */
  add(scene, time) {
    const { width, height } = this.#canvas;
    const scale = Math.max(height / FINE_HEIGHT, 1);
    const context = this.#canvas.getContext("2d");
    context.setTransform(scale, 0, 0, scale, 0, 0);
    drawFrame(context, { width: width / scale, height: height / scale }, scene);
    const picture = new VideoFrame(this.#canvas, { timestamp: Math.round(time * 1e6) });
    this.#encoder.encode(picture, { keyFrame: this.#pictures % KEY_EACH === 0 });
    picture.close();
    this.#pictures += 1;
  }

  /** Ends the film. Returns the file. */
  async end() {
    await this.#encoder.flush();
    this.#encoder.close();
    return this.#webm.blob(this.#step);
  }

  /** Gives the film up. */
  drop() {
    if (this.#encoder.state !== "closed") {
      this.#encoder.close();
    }
    this.#free.splice(0).forEach((go) => go());
  }

  #packed(chunk) {
    const bytes = new Uint8Array(chunk.byteLength);
    chunk.copyTo(bytes);
    const ms = Math.round(chunk.timestamp / 1000);
    this.#step = ms > this.#last ? ms - this.#last : this.#step;
    this.#last = ms;
    this.#webm.add(bytes, ms, chunk.type === "key");
  }
}

function configOf(size) {
  const scale = Math.max(Math.ceil(LEAST_HEIGHT / size.height), 1);
  // VP8 wants even sides.
  const [width, height] = [size.width, size.height].map((side) => 2 * Math.ceil((side * scale) / 2));
  return { codec: "vp8", width, height, bitrate: Math.round(width * height * RATE * BITS_OF_PIXEL), framerate: RATE, latencyMode: "quality" };
}
