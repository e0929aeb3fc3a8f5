// Allocates blocks in the memory of the WebAssembly module, behind the library's own data: first fit in a list of free
// blocks. The library itself does not allocate. The memory grows only if no free block is large enough.

const PAGE = 65536;
const ALIGNMENT = 8; // SMR_ALIGNMENT of smr.h

const aligned = (size) => Math.ceil(size / ALIGNMENT) * ALIGNMENT;

export class Memory {
  #memory;
  #bytes = new Uint8Array(0);
  #view;
  #free = []; // { at, size }, by address; never two that touch
  #taken = new Map(); // sizes, by address

  /** `memory` is a WebAssembly.Memory, `start` its first free address. */
  constructor(memory, start) {
    this.#memory = memory;
    const at = aligned(start);
    this.#release(at, memory.buffer.byteLength - at);
  }

  /** All bytes of the memory. Allocation may replace this array. */
  get bytes() {
    this.#look();
    return this.#bytes;
  }

  get view() {
    this.#look();
    return this.#view;
  }

  /** Allocates at least `size` bytes and returns their address. */
  take(size) {
    const wanted = Math.max(aligned(size), ALIGNMENT);
    let place = this.#free.findIndex((block) => block.size >= wanted);
    if (place < 0) {
      this.#grow(wanted);
      place = this.#free.findIndex((block) => block.size >= wanted);
    }
    const block = this.#free[place];
    const at = block.at;
    block.at += wanted;
    block.size -= wanted;
    if (block.size === 0) {
      this.#free.splice(place, 1);
    }
    this.#taken.set(at, wanted);
    return at;
  }

  /** Frees the block at address `at`. Does nothing if `at` is 0. */
  give(at) {
    if (at === 0) {
      return;
    }
    this.#release(at, this.#taken.get(at));
    this.#taken.delete(at);
  }

  copy(at, size) {
    return this.bytes.slice(at, at + size);
  }

  /** Reads the zero-terminated text at address `at`. */
  text(at) {
    const bytes = this.bytes;
    return String.fromCharCode(...bytes.subarray(at, bytes.indexOf(0, at)));
  }

  // Renews the views: when the memory grows, it gets another buffer.
  #look() {
    if (this.#bytes.buffer !== this.#memory.buffer) {
      this.#bytes = new Uint8Array(this.#memory.buffer);
      this.#view = new DataView(this.#memory.buffer);
    }
  }

  #grow(size) {
    const end = this.#memory.buffer.byteLength;
    const last = this.#free.at(-1);
    const free = last !== undefined && last.at + last.size === end ? last.size : 0;
    const pages = Math.ceil((size - free) / PAGE);
    try {
      this.#memory.grow(pages);
    } catch {
      throw new RangeError(`no memory for ${size} bytes`);
    }
    this.#release(end, pages * PAGE);
  }

  #release(at, size) {
    const found = this.#free.findIndex((block) => block.at > at);
    const place = found < 0 ? this.#free.length : found;
    this.#free.splice(place, 0, { at, size });
    this.#join(place);
    this.#join(place - 1);
  }

  // Merges the free block at index `place` with the next one if they touch.
  #join(place) {
    const [block, next] = [this.#free[place], this.#free[place + 1]];
    if (block !== undefined && next !== undefined && block.at + block.size === next.at) {
      block.size += next.size;
      this.#free.splice(place + 1, 1);
    }
  }
}
