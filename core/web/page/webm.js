// Writes a WebM file of VP8 pictures: RFC 9559 (Matroska), as far as WebM needs it.

const VIDEO = 1;
// The longest cluster in milliseconds: a picture tells its time from there in 15 bits.
const LONGEST = 30_000;

const bytesOf = (value, least = 1) => {
  const bytes = [];
  for (let rest = value; rest > 0 || bytes.length < least; rest = Math.floor(rest / 256)) {
    bytes.unshift(rest % 256);
  }
  return bytes;
};
const textOf = (text) => [...text].map((letter) => letter.charCodeAt(0));
const sizeOf = (size) => [0x01, ...bytesOf(size, 7)];
const element = (id, ...contents) => {
  const content = contents.flat();
  return [...bytesOf(id), ...sizeOf(content.length), ...content];
};
const floatOf = (value) => [...new Uint8Array(new Float64Array([value]).buffer)].reverse();

export class Webm {
  #tracks;
  #clusters = [];
  #size = 0; // of them
  #open = null; // the cluster that is not full: { ms, parts }
  #cues = []; // where clusters begin: { ms, at }
  #last = 0; // milliseconds of the last picture

  constructor(width, height) {
    const shape = element(0xe0, element(0xb0, bytesOf(width)), element(0xba, bytesOf(height)));
    this.#tracks = element(0x1654ae6b, element(0xae, element(0xd7, VIDEO), element(0x73c5, VIDEO), element(0x83, VIDEO), element(0x86, textOf("V_VP8")), shape));
  }

  /** Adds a picture: the bytes of VP8, its time in milliseconds, and whether it needs no other. */
  add(bytes, ms, isKey) {
    if (this.#open === null || isKey || ms - this.#open.ms > LONGEST) {
      this.#close();
      this.#open = { ms, parts: [Uint8Array.from(element(0xe7, bytesOf(ms)))] };
      this.#cues.push({ ms, at: this.#size });
    }
    const head = [0x80 | VIDEO, ...bytesOf(ms - this.#open.ms, 2), isKey ? 0x80 : 0];
    this.#open.parts.push(Uint8Array.from([0xa3, ...sizeOf(head.length + bytes.length), ...head]), bytes);
    this.#last = ms;
  }

  /** The file. `step`: how long the last picture is shown, in milliseconds. */
  blob(step) {
    this.#close();
    const kind = [element(0x4282, textOf("webm")), element(0x4287, 4), element(0x4285, 2)];
    const head = element(0x1a45dfa3, element(0x4286, 1), element(0x42f7, 1), element(0x42f2, 4), element(0x42f3, 8), ...kind);
    const names = [element(0x4d80, textOf("smr")), element(0x5741, textOf("smr"))];
    const info = element(0x1549a966, element(0x2ad7b1, bytesOf(1e6)), element(0x4489, floatOf(this.#last + step)), ...names);
    // Where clusters are depends on how long the list of their places is: that is always the same.
    const before = [...info, ...this.#tracks];
    const cues = this.#cuesAt(before.length + this.#cuesAt(0).length);
    const size = before.length + cues.length + this.#size;
    return new Blob([Uint8Array.from([...head, ...bytesOf(0x18538067), ...sizeOf(size), ...before, ...cues]), ...this.#clusters], { type: "video/webm" });
  }

  #cuesAt(start) {
    const place = (at) => element(0xb7, element(0xf7, VIDEO), element(0xf1, bytesOf(start + at, 6)));
    return element(0x1c53bb6b, ...this.#cues.map(({ ms, at }) => element(0xbb, element(0xb3, bytesOf(ms)), place(at))));
  }

  #close() {
    if (this.#open === null) {
      return;
    }
    const size = this.#open.parts.reduce((sum, { length }) => sum + length, 0);
    const head = Uint8Array.from([...bytesOf(0x1f43b675), ...sizeOf(size)]);
    // A blob need not stay in memory.
    this.#clusters.push(new Blob([head, ...this.#open.parts]));
    this.#size += head.length + size;
    this.#open = null;
  }
}
