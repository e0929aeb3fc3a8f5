// The sentences that the page says to the user, each until its cause ends.

/** A sentence with this cause stays for good, in front of any other. */
export const ENDED = "ended";

export class Messages {
  #all = new Map(); // by cause, the last one said last

  /** Replaces the sentence of a cause; an empty text ends it. */
  say(text, cause) {
    this.#all.delete(cause);
    if (text !== "") {
      this.#all.set(cause, text);
    }
  }

  /** The sentence to show: the last one said whose cause goes on, behind that of `ENDED`. */
  get text() {
    const last = [...this.#all].findLast(([cause]) => cause !== ENDED)?.[1];
    return [this.#all.get(ENDED), last].filter(Boolean).join(" ");
  }
}
