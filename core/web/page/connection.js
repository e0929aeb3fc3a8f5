// The window's side of `host-sim view`: what it asks host-sim for, and what it hears.

import { targetOf, toldOf } from "./edits.js";

const AGAIN_MS = 1000;
const MOST_FAILURES = 3;

export class Connection {
  #revision = 0; // the number of the last change of the targets that this page knows
  #sending = Promise.resolve();

  /**
   * The source: its name and size, `live`, the number of its first frame and of all `frames`, their `times` in
   * seconds or their `rate` as far as they are known, the targets, the method that follows them, and what can be saved.
   */
  async open() {
    const source = await (await asked("source")).json();
    this.#revision = source.revision;
    return { ...source, version: `host-sim ${source.version}`, targets: source.targets.map(targetOf) };
  }

  /** The picture of a frame. */
  async picture(number) {
    return createImageBitmap(await (await asked(`frames/${number}.jpg`)).blob());
  }

  /** The recording's own pixels of a part of a frame, { x, y, width, height }. */
  async part(number, { x, y, width, height }) {
    return createImageBitmap(await (await asked(`frames/${number}.png?part=${x},${y},${width},${height}`)).blob());
  }

  /** Tells the frame that the user looks at, for the next time. */
  async place(frame) {
    await told("place", { frame });
  }

  /**
   * Calls `heard` with all news, as long as the page is open, and `gone` when host-sim does not answer any more. Of many answers, those from the
   * frame `now()` on come first.
   */
  async listen(heard, gone, now) {
    let [position, failures] = [0, 0];
    const parts = []; // of answers that are to be asked for: [target, first frame, last frame]
    while (failures < MOST_FAILURES) {
      try {
        const { targets, ...news } = await (await asked(`news?since=${position}${parts.length === 0 ? "" : "&wait=0"}`)).json();
        [position, failures] = [news.position, 0];
        if (news.rows.length === 0) {
          parts.push(...news.changed);
        }
        if (parts.length > 0) {
          news.rows.push(...(await answersOf(parts, now())));
        }
        // Changes sent by this page are no news.
        await this.#sending;
        const isNew = news.revision > this.#revision;
        this.#revision = Math.max(this.#revision, news.revision ?? 0);
        heard({ ...news, ...(isNew ? { targets: targets.map(targetOf) } : {}) });
      } catch (error) {
        failures += 1;
        console.debug(error);
        await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
      }
    }
    gone();
  }

  /** Sends the wanted targets, after any list still being sent. Throws host-sim's reason if it refuses. */
  targets(targets) {
    const sent = this.#sending.then(async () => {
      const answer = await told("targets", targets.map(toldOf), { "If-Match": `"${this.#revision}"` });
      this.#revision = (await answer.json()).revision;
    });
    this.#sending = sent.catch(() => {});
    return sent;
  }

  async method(method, options) {
    await told("method", { method, options });
  }

  async stop() {
    await told("stop", {});
  }

  /** Begins to make a film or a report; returns its number and the name of its file. */
  async make(what, options = {}) {
    return (await told(what, options)).json();
  }

  async cancel(id) {
    await told("cancel", { id });
  }

  /** The targets of a file with boxes, { name, locks }. */
  async read(file) {
    const answer = await asked(`boxes?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file });
    return (await answer.json()).targets.map(targetOf);
  }

  /** The boxes as a file: its name and its bytes. */
  async boxes(format) {
    const answer = await asked(`boxes?format=${format}`);
    const [, name] = /filename="([^"]+)"/.exec(answer.headers.get("Content-Disposition")) ?? [null, `boxes.${format}`];
    return { name, bytes: await answer.blob() };
  }

  async firmware() {
    return (await asked("firmware")).text();
  }
}

// Asks for a portion of `parts`, which keep the rest.
async function answersOf(parts, now) {
  const isHere = ([, first, last]) => first <= now && now <= last;
  const [part] = parts.splice(Math.max(parts.findIndex(isHere), 0), 1);
  const [target, first, last] = part;
  const from = isHere(part) ? now : first;
  const { rows, to } = await (await asked(`answers?target=${target}&from=${from}&to=${last}`)).json();
  const rest = [[target, first, from - 1], [target, to + 1, last]];
  parts.push(...rest.filter(([, begin, end]) => begin <= end));
  return rows;
}

async function asked(address, options) {
  const answer = await fetch(address, options).catch(() => {
    throw new Error("host-sim does not answer: it has ended, or this machine was asleep.");
  });
  if (!answer.ok) {
    throw new Error((await answer.text()).trim() || `host-sim answers ${answer.status} for ${address}`);
  }
  return answer;
}

function told(address, body, headers = {}) {
  return asked(address, { method: "POST", headers: { "Content-Type": "application/json", ...headers }, body: JSON.stringify(body) });
}
