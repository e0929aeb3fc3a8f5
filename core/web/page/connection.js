// The window's side of `host-sim view`: what it asks host-sim for, and what it hears.

import { targetOf, toldOf } from "./edits.js";

const AGAIN_MS = 1000;
const MOST_FAILURES = 3;

export class Connection {
  /** Whether targets are followed while the page is open. */
  follows = true;

  /**
   * What there is to see: its name and size, `live`, the number of its first frame and of all `frames`, their `times` in
   * seconds or their `rate` as far as they are known, the targets, the method that follows them, and what can be saved.
   */
  async open() {
    const source = await (await asked("source")).json();
    return { first: 1, ...source, targets: source.targets.map(targetOf) };
  }

  /** The frame that comes so many frames later, or earlier. */
  step(number, by) {
    return number + by;
  }

  /** The picture of a frame. */
  async picture(number) {
    return createImageBitmap(await (await asked(`frames/${number}.jpg`)).blob());
  }

  /** Calls `heard` with all news, as long as the page is open, and `gone` when host-sim does not answer any more. */
  async listen(heard, gone) {
    let [position, failures] = [0, 0];
    while (failures < MOST_FAILURES) {
      try {
        const news = await (await asked(`news?since=${position}`)).json();
        [position, failures] = [news.position, 0];
        heard({ ...news, ...(news.targets === undefined ? {} : { targets: news.targets.map(targetOf) }) });
      } catch (error) {
        failures += 1;
        console.debug(error);
        await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
      }
    }
    gone();
  }

  /** Says which targets are wanted. If host-sim refuses them, throws its reason. */
  async targets(targets) {
    await told("targets", targets.map(toldOf));
  }

  async method(method, options) {
    await told("method", { method, options });
  }

  async stop() {
    await told("stop", {});
  }

  /** Begins to make a film or a report; returns its number. */
  async make(what, options = {}) {
    return (await (await told(what, options)).json()).id;
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

async function asked(address, options) {
  const answer = await fetch(address, options).catch(() => {
    throw new Error("host-sim does not answer: it has ended, or this machine was asleep.");
  });
  if (!answer.ok) {
    throw new Error((await answer.text()).trim() || `host-sim answers ${answer.status} for ${address}`);
  }
  return answer;
}

const told = (address, body) => asked(address, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });
