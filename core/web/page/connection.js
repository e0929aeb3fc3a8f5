// Client of `host-sim view`: the application's source of frames and answers, which host-sim sends over HTTP.

import { quoted } from "./command.js";
import { targetOf, toldOf } from "./edits.js";
import { isRecording } from "./file-kind.js";

const AGAIN_MS = 1000;
const MAX_FAILURES = 3;

export class Connection {
  #revision = 0; // the number of the last change of the targets that this page knows
  #position = 0; // in host-sim's log: the last change that this page has heard
  #sending = Promise.resolve();
  #waiting = []; // for a position: { position, resolve }

  /**
   * Requests the facts about the source: name, size, `live` (true for a camera or stream), the count of `frames`, their
   * `times` in seconds or their `rate` in frames per second if known, the targets, the method that tracks them, and the
   * formats of files that can be saved.
   */
  async open() {
    const source = await (await asked("source")).json();
    this.#revision = source.revision;
    return { ...source, version: `host-sim ${source.version}`, targets: source.targets.map(targetOf) };
  }

  async image(number) {
    return createImageBitmap(await (await asked(`frames/${number}.jpg`)).blob());
  }

  /** Loads a part { x, y, width, height } of a frame at full resolution. */
  async part(number, { x, y, width, height }) {
    return createImageBitmap(await (await asked(`frames/${number}.png?part=${x},${y},${width},${height}`)).blob());
  }

  /** Saves the number of the shown frame in the session, for the next start of host-sim. */
  async place(frame) {
    await told("place", { frame });
  }

  /**
   * Polls host-sim and calls `heard` with all changes, and `gone` when host-sim does not reply any more. If there are
   * many new answers, those from the frame `now()` on are loaded first.
   */
  async listen(heard, gone, now) {
    let failures = 0;
    const parts = []; // of answers that are to be asked for: [target, first frame, last frame]
    while (failures < MAX_FAILURES) {
      try {
        const { targets, ...news } = await (await asked(`news?since=${this.#position}${parts.length === 0 ? "" : "&wait=0"}`)).json();
        failures = 0;
        if (news.rows.length === 0) {
          parts.push(...news.changed);
        }
        if (parts.length > 0) {
          news.rows.push(...(await answersOf(parts, now())));
        }
        // Waits for the reply to this page's own change, so that the change is not taken for one by another page.
        await this.#sending;
        const isNew = news.revision > this.#revision;
        this.#revision = Math.max(this.#revision, news.revision ?? 0);
        heard({ ...news, ...(isNew ? { targets: targets.map(targetOf) } : {}) });
        this.#heard(news.position);
      } catch (error) {
        failures += 1;
        console.debug(error);
        await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
      }
    }
    this.#heard(Infinity);
    gone();
  }

  #heard(position) {
    this.#position = position;
    this.#waiting.filter((one) => one.position <= position).forEach(({ resolve }) => resolve());
    this.#waiting = this.#waiting.filter((one) => one.position > position);
  }

  /**
   * Sends the list of targets, after any list still being sent, and waits until its news are heard: then all answers are
   * of these targets. Throws host-sim's reason if the list is refused.
   */
  async targets(targets, ids, checked) {
    const body = targets.map((target) => toldOf(target, checked.get(target.id)));
    const sent = this.#sending.then(async () => {
      const answer = await told("targets", body, { "If-Match": `"${this.#revision}"` });
      const { revision } = await answer.json();
      this.#revision = revision;
      return revision;
    });
    this.#sending = sent.catch(() => {});
    const position = await sent;
    if (position > this.#position) {
      await new Promise((resolve) => this.#waiting.push({ position, resolve }));
    }
  }

  /** Saves the ranges of frames in which the user has looked at a target. */
  async checked(target, frames) {
    await this.#sending;
    await told("checked", { target, frames });
  }

  async method(method, options) {
    await told("method", { method, options });
  }

  /** Saves the length in the picture that the user has drawn, or removes it if it is null. */
  async length(length) {
    await told("length", length);
  }

  async stop() {
    await told("stop", {});
  }

  /** Orders a video or a report; returns its id and the name of its file. */
  async make(what, options = {}) {
    return (await told(what, options)).json();
  }

  async cancel(id) {
    await told("cancel", { id });
  }

  /** Lets host-sim parse a file with boxes. Returns its targets { name, locks }. */
  async read(file) {
    if (await isRecording(file)) {
      throw new Error(`${file.name} has pictures, not boxes: to look at it, start another host-sim view ${quoted(file.name)}`);
    }
    const answer = await asked(`boxes?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file });
    return (await answer.json()).targets.map(targetOf);
  }

  async boxes(format) {
    const answer = await asked(`boxes?format=${format}`);
    const [, name] = /filename="([^"]+)"/.exec(answer.headers.get("Content-Disposition")) ?? [null, `boxes.${format}`];
    return { name, bytes: await answer.blob() };
  }

  async firmware() {
    return (await asked("firmware")).text();
  }
}

// Loads answers for one of the ranges `parts`: for the range that contains frame `now`, from `now` on, or else for the
// first range, from its start. Removes the frames of the loaded answers from `parts`.
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
    throw new Error("host-sim does not answer: it has ended, or this machine was asleep.", { cause: "connection" });
  });
  if (!answer.ok) {
    throw new Error((await answer.text()).trim() || `host-sim answers ${answer.status} for ${address}`);
  }
  return answer;
}

function told(address, body, headers = {}) {
  return asked(address, { method: "POST", headers: { "Content-Type": "application/json", ...headers }, body: JSON.stringify(body) });
}
