// The page's side of the worker: sends requests to it, and returns a promise for each answer.

// A frame waits while another is followed. A third one would only be late.
const MOST_FRAMES = 2;

export class Follower {
  #worker;
  #waiting = new Map(); // by ticket
  #tickets = 0;
  #frames = 0; // under way
  #free = []; // who waits until there is room for a frame

  /** `address`: that of the worker's script. `broken` is called if the script cannot run. */
  constructor(address, broken) {
    this.#worker = new Worker(address);
    this.#worker.onmessage = ({ data }) => this.#answered(data);
    this.#worker.onerror = (event) => broken(event.message ?? "the worker does not start");
  }

  /** True if a frame would have to wait for others. */
  get isBehind() {
    return this.#frames >= MOST_FRAMES;
  }

  /** A promise for the time when a frame need not wait for others. */
  async free() {
    while (this.isBehind) {
      await new Promise((resolve) => this.#free.push(resolve));
    }
  }

  ask(wish, of = {}, moved = []) {
    const ticket = this.#tickets++;
    this.#worker.postMessage({ wish, ticket, ...of }, moved);
    return new Promise((resolve, reject) => this.#waiting.set(ticket, { resolve, reject }));
  }

  /** Follows all targets in a frame. */
  async frame(of) {
    this.#frames += 1;
    try {
      return await this.ask("frame", of, of.picture === undefined ? [] : [of.picture]);
    } finally {
      this.#frames -= 1;
      this.#free.splice(0).forEach((go) => go());
    }
  }

  #answered({ ticket, answer, error }) {
    const { resolve, reject } = this.#waiting.get(ticket);
    this.#waiting.delete(ticket);
    error === undefined ? resolve(answer) : reject(new Error(error));
  }
}
