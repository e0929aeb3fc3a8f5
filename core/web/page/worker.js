// The worker: takes frames and requests from the page and sends back answers, so that the page never waits for a
// tracker. follower.js is the other side.

import { hasSimd, load } from "../smr.js";
import { grayOf } from "./gray.js";
import { scene } from "./scene.js";
import { Targets } from "./targets.js";

let targets = null;
let streetFrame = null; // draws the built-in recording
let last = null; // the last frame, which a lock is on

const WISHES = {
  async start({ modules, settings }) {
    const library = await load(await unpacked(hasSimd() ? modules.simd : modules.plain));
    targets = new Targets(library, settings);
    streetFrame = await scene(await unpacked(modules.scene));
    return { simd: library.simd, version: library.version };
  },

  // `picture` is an ImageBitmap or a VideoFrame, which is sent back to be drawn; or `index` a frame of the built-in
  // recording.
  async frame({ number, picture, index, shown }) {
    const { frame, drawn } = picture === undefined ? await builtIn(index) : { frame: await grayOf(picture), drawn: picture };
    const isOther = last !== null && (last.width !== frame.width || last.height !== frame.height);
    if (isOther) {
      targets.restart();
    }
    last = { ...frame, number };
    return { number, picture: drawn, isOther, width: frame.width, height: frame.height, answers: targets.update(last, shown) };
  },

  lock({ id, box }) {
    return { id, box, number: last.number, locked: targets.lock(id, last, box) };
  },

  remove({ id }) {
    targets.remove(id);
  },

  restart({ settings }) {
    targets.restart(settings);
    last = null;
  },

  record({ id, method }) {
    return { bytes: targets.record(id, method) };
  },
};

async function unpacked(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

async function builtIn(index) {
  const frame = streetFrame(index);
  return { frame, drawn: await createImageBitmap(new ImageData(frame.data, frame.width, frame.height)) };
}

// Handles requests one after the other and answers each with its number.
let turn = Promise.resolve();
self.onmessage = ({ data: { wish, ticket, ...of } }) => {
  turn = turn.then(() => granted(wish, ticket, of));
};

async function granted(wish, ticket, of) {
  try {
    const answer = await WISHES[wish](of);
    self.postMessage({ ticket, answer }, answer?.picture === undefined ? [] : [answer.picture]);
  } catch (error) {
    self.postMessage({ ticket, error: error.message });
  }
}
