// Runs the application without host-sim: the browser supplies the frames (of the built-in recording, a video file or a
// camera), and a worker tracks targets in them.

import { BuiltIn } from "./built-in.js";
import { Camera } from "./camera.js";
import { packedModules, workerAddress } from "./data.js";
import { quoted } from "./command.js";
import { nameOf } from "./edits.js";
import { isRecording } from "./file-kind.js";
import { Follower } from "./follower.js";
import { Following } from "./following.js";
import { METHODS, TITLES } from "./methods.js";
import { csv, json } from "./rows.js";
import { parsed, session, stemOf } from "./session.js";
import { VideoFile } from "./video-file.js";

const MAX_WIDE = 1920; // pixels of an image of a whole frame
const FORMATS = [{ name: "csv", several: true }, { name: "json", several: true }, { name: "record", several: true }];
const SESSION = { name: "session", several: true };

export class Local {
  #follower;
  #following;
  #source = null;
  #version;
  #choices = 0; // of sources
  #isStarting = false;
  #work = new Map(); // see `#worked`, by the source's key; by the source itself if it cannot be opened again
  #heard = () => {};

  /** Starts the worker and opens the built-in recording. */
  async open() {
    if (typeof WebAssembly !== "object") {
      throw new Error("This browser has no WebAssembly, which the trackers need: use a current browser, or allow it.");
    }
    if (typeof OffscreenCanvas !== "function" || typeof DecompressionStream !== "function" || !CSS.supports("color", "light-dark(red, red)")) {
      throw new Error("This browser is too old for this page: use a current Firefox, Chrome, Edge or Safari.");
    }
    this.#follower = new Follower(await workerAddress());
    this.#following = new Following(this.#follower, (news) => this.#tell(news));
    this.#version = (await this.#follower.ask("start", { modules: packedModules() })).version;
    return this.#use(new BuiltIn(this.#follower));
  }

  listen(heard) {
    this.#heard = heard;
    this.#tell({});
  }

  /** Opens the built-in recording. On failure the former source stays; a source chosen meanwhile takes precedence. */
  async builtIn() {
    await this.#change(new BuiltIn(this.#follower));
  }

  async camera() {
    this.#say("Waiting for the camera.", "opening");
    const camera = new Camera(this.#follower, {
      came: () => camera === this.#source && this.#came(),
      failed: (text) => this.#say(text, "camera"),
    });
    await this.#change(camera);
  }

  async read(file) {
    if (file.size > 0 && !(await isRecording(file))) {
      return this.#session(file.name, await file.text());
    }
    this.#say(`Opening ${file.name}.`, "opening");
    await this.#change(new VideoFile(file, { failed: (text) => this.#say(text) }));
    return "";
  }

  async image(number) {
    const whole = { x: 0, y: 0, width: this.#source.width, height: this.#source.height };
    return this.#cut(number, whole, Math.min(MAX_WIDE / whole.width, 1));
  }

  async part(number, part) {
    return this.#cut(number, part, 1);
  }

  async targets(targets, ids, checked) {
    const source = this.#shown;
    await this.#following.targets(targets);
    this.#keep(source, { targets, ids, checked: new Map(checked) });
  }

  /** Keeps the ranges of frames in which the user has looked at a target. */
  async checked(id, frames) {
    const source = this.#source;
    this.#keep(source, { checked: new Map(this.#worked(source).checked).set(id, frames) });
  }

  async length(length) {
    this.#keep(this.#shown, { length });
  }

  #keep(source, made) {
    const key = source.key ?? source;
    this.#work.set(key, { ...this.#work.get(key), ...made });
  }

  /** True if the user has drawn or changed boxes or a length, which end with the page. */
  get hasWork() {
    return [...this.#work.values()].some(({ targets, length }) => targets?.length > 0 || length);
  }

  async method(method, options) {
    this.#following.method({ method, options });
    // Other boxes are to come than those that the user has looked at.
    this.#work.get(this.#source.key)?.checked?.clear();
  }

  async stop() {
    this.#source.stop();
  }

  /** Returns a file { name, bytes }: all targets' boxes for `format` "csv" or "json", the session, or `chosen`'s flight record. */
  async boxes(format, chosen) {
    const { method, options } = this.#following.using;
    const { name, last, live } = this.#source;
    const { followed } = this.#following;
    const isWhole = live || followed >= (Number.isFinite(last) ? last : this.#source.news().frames);
    const stem = `${stemOf(name)}${isWhole ? "" : `-${followed}-frames`}`;
    const rows = this.#following.rows(nameOf);
    const timeOf = (number) => this.#source.timeOf?.(number) ?? null;
    if (format === "csv") {
      return { name: `${stem}.csv`, bytes: csv(rows, timeOf, this.#length) };
    }
    if (format === "json") {
      return { name: `${stem}.jsonl`, bytes: json(rows, { version: this.#version, method, options }, timeOf) };
    }
    if (format === "session") {
      return { name: `${name}.smr.json`, bytes: session({ name, using: this.#following.using, ...this.#worked(this.#source), madeBy: this.#madeBy }) };
    }
    const { bytes } = await this.#follower.ask("record", { id: chosen?.id });
    if (bytes === null) {
      throw new Error(`${TITLES[method]} has no flight record: choose a target that it follows.`);
    }
    return { name: `${stemOf(name)}.smr`, bytes };
  }

  get #madeBy() {
    return `smr page ${this.#version}`;
  }

  // Returns the user's work on a source: { targets, ids, checked, length }; see `session`.
  #worked(source) {
    return { targets: source.targets ?? [], ids: 0, checked: new Map(), length: null, ...this.#work.get(source.key ?? source) };
  }

  // Returns the work { using, targets, ids, checked, length } of a session of the present source.
  #session(file, text) {
    const source = this.#source;
    let found;
    try {
      found = parsed(text, source);
    } catch ({ message }) {
      throw new Error(`${file}: ${message}`);
    }
    if (found === null) {
      throw new Error(`${file} is text, not a video: boxes are read by host-sim view VIDEO --boxes ${quoted(file)}`);
    }
    if (source.live) {
      throw new Error(`${file}: a camera has other frames now: open its recording first.`);
    }
    const { madeBy, targets, ...work } = found;
    // Another program may have had other boxes.
    return { ...work, targets: targets.map(({ checked, ...target }) => ({ ...target, checked: madeBy === this.#madeBy ? checked : [] })) };
  }

  async #change(source) {
    const opened = await this.#use(source);
    if (opened !== null) {
      this.#heard({ opened });
      this.#say(source.warning ?? "");
    }
  }

  // Opens a source. Returns what the application needs to know about it; null if another source was chosen meanwhile.
  async #use(source) {
    const choice = ++this.#choices;
    try {
      await source.open();
    } catch (error) {
      source.close();
      if (choice === this.#choices) {
        this.#isStarting = false;
        this.#say("", "opening");
      }
      throw error;
    }
    if (choice !== this.#choices) {
      source.close();
      return null;
    }
    this.#source?.close();
    this.#work.delete(this.#source); // of a camera, whose frames end with it
    this.#source = source;
    this.#following.use(source);
    this.#isStarting = true;
    await source.start?.();
    if (choice !== this.#choices) {
      return null;
    }
    this.#isStarting = false;
    const { name, words, live, width, height } = source;
    const { targets, ids, checked, length } = this.#worked(source);
    this.#following.targets(targets).catch((error) => this.#say(error.message));
    return {
      name, words, live, width, height, ids, length, ...source.news(), ...this.#following.using, methods: METHODS, version: `smr ${this.#version}`,
      targets: targets.map((target) => ({ ...target, checked: checked.get(target.id) })), formats: live ? FORMATS : [...FORMATS, SESSION],
      timeOf: (number) => source.timeOf?.(number) ?? null, plays: source.targets !== undefined,
    };
  }

  // The source whose picture the user sees. Throws while another one starts.
  get #shown() {
    if (this.#isStarting) {
      throw new Error(`${this.#source.name} is being opened: wait for its picture.`);
    }
    return this.#source;
  }

  get #length() {
    return this.#worked(this.#source).length;
  }

  #came() {
    this.#following.run();
    this.#tell({ said: "", cause: "camera", ...this.#source.news(this.#following.followed) });
  }

  #tell(news) {
    this.#heard({ rows: [], followed: this.#following.followed, silent: this.#following.silent, length: this.#length, ...news });
  }

  #say(said, cause = "source") {
    this.#tell({ said, cause });
  }

  async #cut(number, { x, y, width, height }, scale) {
    const image = await this.#source.image(number);
    const [wide, high] = [Math.round(width * scale), Math.round(height * scale)];
    const canvas = new OffscreenCanvas(wide, high);
    canvas.getContext("2d").drawImage(image, x, y, width, height, 0, 0, wide, high);
    if (!this.#source.live) {
      image.close();
    }
    return canvas.transferToImageBitmap();
  }
}
