// The tracking worker of the stand-alone page: has a tracker for each target, and answers the requests of follower.js,
// so that the page never waits for a tracker.

import { Recorder } from "../record.js";
import { hasSimd, load } from "../smr.js";
import { grayOf } from "./gray.js";
import { trackerOf } from "./methods.js";
import { scene } from "./scene.js";
import { unpacked } from "./unpacked.js";

const RECORD_BYTES = 6 << 20; // of each target's flight record
const MAX_BYTES = 96 << 20; // of frames that are kept

/** A cache of the last frames by number, limited in bytes. */
class Frames {
  #kept = new Map();
  #bytes = 0;

  get(number) {
    return this.#kept.get(number);
  }

  set(number, frame) {
    this.#forget(number);
    this.#kept.set(number, frame);
    this.#bytes += frame.data.length;
    while (this.#bytes > MAX_BYTES) {
      this.#forget(this.#kept.keys().next().value);
    }
  }

  #forget(number) {
    this.#bytes -= this.get(number)?.data.length ?? 0;
    this.#kept.delete(number);
  }
}

let library;
let street; // draws the built-in recording
let method = { method: "robust", options: {} };
const targets = new Map(); // { tracker, recorder } by id
let seen = new Frames(); // of the camera
const drawn = new Frames(); // of the built-in recording

const bytesOf = (packed) => unpacked(packed).arrayBuffer();

const HANDLERS = {
  async start({ modules }) {
    if (!hasSimd()) {
      throw new Error("This browser has no SIMD in WebAssembly, which the trackers need: use a current one.");
    }
    library = await load(await bytesOf(modules.smr));
    street = await scene(await bytesOf(modules.scene));
    return { version: library.version };
  },

  /** Removes all targets. Targets locked later get trackers as in `using`: { method, options }. */
  restart({ using }) {
    [...targets.keys()].forEach(remove);
    method = using;
  },

  clear() {
    seen = new Frames();
  },

  /** Stores the gray pixels of a camera's image (VideoFrame or ImageBitmap), and sends the image back. */
  async keep({ number, image }) {
    const { data, ...size } = await grayOf(image);
    seen.set(number, { data: data.slice(), ...size });
    return { image };
  },

  async draw({ number }) {
    const { data, width, height } = built(number);
    return { image: await createImageBitmap(new ImageData(data, width, height)) };
  },

  /**
   * Locks or updates targets in a frame: `image` if given, else frame `number` of the built-in recording if
   * `isBuiltIn`, else the stored frame `number`. A job { id, box } locks, a job { id } updates. Returns for each job a
   * pair of its id and { quality } of a lock, { answer } of an update, or { error }.
   */
  async follow({ number, image, isBuiltIn, jobs }) {
    const frame = image ? await grayOf(image) : isBuiltIn ? built(number) : seen.get(number);
    if (frame === undefined) {
      throw new Error(`frame ${number} is not kept any more`);
    }
    image?.close();
    return jobs.map(({ id, box }) => [id, followed(id, frame, box)]);
  },

  remove({ id }) {
    remove(id);
  },

  /** Returns the flight record of a target (its last frames and answers); null if it has none. */
  record({ id }) {
    return { bytes: targets.get(id)?.recorder.bytes() ?? null };
  },
};

function built(number) {
  const frame = drawn.get(number) ?? street(number - 1);
  drawn.set(number, frame);
  return frame;
}

function followed(id, frame, box) {
  try {
    if (box === undefined) {
      return { answer: targets.get(id).tracker.update(frame) };
    }
    return { quality: made(id).tracker.lock(frame, box) };
  } catch (error) {
    remove(id);
    return { error: error.message };
  }
}

function made(id) {
  if (!targets.has(id)) {
    const tracker = trackerOf(library, method);
    targets.set(id, { tracker, recorder: new Recorder(tracker, { bytes: RECORD_BYTES }) });
  }
  return targets.get(id);
}

function remove(id) {
  targets.get(id)?.tracker.free();
  targets.delete(id);
}

// Handles requests one after the other; each answer carries its request's ticket.
let turn = Promise.resolve();
self.onmessage = ({ data: { request, ticket, ...of } }) => {
  turn = turn.then(() => respond(request, ticket, of));
};

async function respond(request, ticket, of) {
  try {
    const answer = await HANDLERS[request](of);
    self.postMessage({ ticket, answer }, answer?.image === undefined ? [] : [answer.image]);
  } catch (error) {
    self.postMessage({ ticket, error: error.message });
  }
}
