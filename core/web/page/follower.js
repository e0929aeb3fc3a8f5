// The page's side of the worker: sends requests to it, and returns a promise for each answer.

export class Follower {
  #worker;
  #waiting = new Map(); // by ticket
  #tickets = 0;

  /** `address`: that of the worker's script. */
  constructor(address) {
    this.#worker = new Worker(address);
    this.#worker.onmessage = ({ data }) => this.#answered(data);
    this.#worker.onerror = ({ message }) => {
      this.#waiting.forEach(({ reject }) => reject(new Error(`The trackers do not run here: ${message ?? "the worker does not start"}.`)));
      this.#waiting.clear();
    };
  }

  /** Asks for one of the worker's wishes. A `picture` goes to the worker without a copy. */
  ask(wish, of = {}) {
    const ticket = this.#tickets++;
    this.#worker.postMessage({ wish, ticket, ...of }, of.picture === undefined ? [] : [of.picture]);
    return new Promise((resolve, reject) => this.#waiting.set(ticket, { resolve, reject }));
  }

  #answered({ ticket, answer, error }) {
    const { resolve, reject } = this.#waiting.get(ticket);
    this.#waiting.delete(ticket);
    error === undefined ? resolve(answer) : reject(new Error(error));
  }
}
