// Client of the tracking worker: sends requests, and returns a promise for each answer.

export class Follower {
  #worker;
  #waiting = new Map(); // by ticket
  #tickets = 0;

  constructor(address) {
    this.#worker = new Worker(address);
    this.#worker.onmessage = ({ data }) => this.#answered(data);
    this.#worker.onerror = ({ message }) => {
      this.#waiting.forEach(({ reject }) => reject(new Error(`The trackers do not run here: ${message ?? "the worker does not start"}.`)));
      this.#waiting.clear();
    };
  }

  /** Sends the worker the request named `request`, with the fields `of`. A `image` is transferred without a copy. */
  ask(request, of = {}) {
    const ticket = this.#tickets++;
    this.#worker.postMessage({ request, ticket, ...of }, of.image === undefined ? [] : [of.image]);
    return new Promise((resolve, reject) => this.#waiting.set(ticket, { resolve, reject }));
  }

  #answered({ ticket, answer, error }) {
    const { resolve, reject } = this.#waiting.get(ticket);
    this.#waiting.delete(ticket);
    error === undefined ? resolve(answer) : reject(new Error(error));
  }
}
