// A video file as a source of frames: one decoder for the trackers and one for the screen, so that neither waits.

import { quoted } from "./command.js";
import { Video } from "./video.js";

export class VideoFile {
  live = false;
  #file;
  #page;
  #followed;
  #seen;
  #end = Infinity; // the last frame, once the trackers were there

  /** `page.failed(text)` is called with the reason if the file ends early or cannot be played. */
  constructor(file, page) {
    [this.#file, this.#page] = [file, page];
    [this.name, this.words] = [file.name, quoted(file.name)];
    this.key = `${file.name} ${file.size} ${file.lastModified}`;
  }

  /** Opens the file. Throws an error with the reason in one line if it cannot be played. */
  async open() {
    if (this.#file.size === 0) {
      throw new Error(`${this.name} is empty: choose a video.`);
    }
    this.#followed = new Video(this.#file, this.#page.failed);
    await this.#followed.open();
    this.#seen = new Video(this.#file, this.#page.failed, this.#followed);
    await this.#seen.open();
    [this.width, this.height] = [this.#followed.width, this.#followed.height];
  }

  get warning() {
    return this.#followed.isUneven ? "Frames of this file come at uneven times: unless they are followed from the first one on, their numbers are estimates." : "";
  }

  /** Number of the last frame; Infinity until a decoder has reached it. Until then, `news` returns an estimate. */
  get last() {
    return Math.min(this.#end, this.#followed.isCounted ? this.#followed.length : Infinity);
  }

  timeOf(number) {
    return this.#followed.timeOf(number);
  }

  news() {
    return { frames: Math.min(this.#followed.length ?? Infinity, this.#end) };
  }

  /** Decodes a frame for the trackers; null if the file ends before it. */
  async frame(number) {
    const image = await this.#followed.take(number);
    if (image === null) {
      this.#end = number - 1;
    }
    return image && { image };
  }

  async image(number) {
    const image = await this.#seen.take(number);
    if (image === null) {
      throw new Error(`${this.name} ends before frame ${number}.`);
    }
    return image;
  }

  close() {
    this.#followed?.close();
    this.#seen?.close();
  }
}
