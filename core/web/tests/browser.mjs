// A headless Chromium, driven through its debugging pipe: messages in JSON, each ended by a zero byte, on the file descriptors 3 and 4.

import { spawn, spawnSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const PROGRAM = process.env.CHROMIUM ?? "chromium";
// Longest wait in seconds for a condition. It is long because other steps of `.ci/run` may keep the processors busy.
const MAX_SECONDS = 120;

export function hasBrowser() {
  return spawnSync(PROGRAM, ["--version"]).status === 0;
}

export class Browser {
  /** Folder of the files that pages save. */
  downloads = mkdtempSync(join(tmpdir(), "smr-downloads-"));
  #profile = mkdtempSync(join(tmpdir(), "smr-browser-"));
  #process;
  #waiting = new Map(); // by number of the call
  #calls = 0;
  #listeners = new Map(); // by session

  constructor(flags = []) {
    const all = ["--headless", "--no-sandbox", "--disable-gpu", "--mute-audio", "--no-first-run", "--remote-debugging-pipe", `--user-data-dir=${this.#profile}`];
    this.#process = spawn(PROGRAM, [...all, ...flags, "about:blank"], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
    let rest = "";
    this.#process.stdio[4].setEncoding("utf8").on("data", (text) => {
      const messages = (rest + text).split("\0");
      rest = messages.pop();
      messages.forEach((message) => this.#received(JSON.parse(message)));
    });
    this.#process.on("exit", () => this.#waiting.forEach(({ reject }) => reject(new Error("Chromium has ended"))));
  }

  call(method, params = {}, session = undefined) {
    const id = ++this.#calls;
    this.#process.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId: session })}\0`);
    return new Promise((resolve, reject) => this.#waiting.set(id, { resolve, reject, method }));
  }

  /** Opens a page of `width` by `height` pixels; `scheme` is light or dark. */
  async page(address, { width = 1280, height = 900, scheme = "light", prepare = "" } = {}) {
    const { targetId } = await this.call("Target.createTarget", { url: "about:blank" });
    const { sessionId } = await this.call("Target.attachToTarget", { targetId, flatten: true });
    const page = new Page(this, sessionId, targetId);
    this.#listeners.set(sessionId, (method, params) => page.heard(method, params));
    await this.call("Browser.setDownloadBehavior", { behavior: "allow", downloadPath: this.downloads, eventsEnabled: true });
    for (const domain of ["Page", "Runtime", "Log", "Network", "DOM"]) {
      await page.call(`${domain}.enable`);
    }
    await page.size(width, height);
    await page.scheme(scheme);
    if (prepare !== "") {
      await page.call("Page.addScriptToEvaluateOnNewDocument", { source: prepare });
    }
    const loaded = page.next("Page.loadEventFired");
    await page.call("Page.navigate", { url: address });
    await loaded;
    return page;
  }

  get process() {
    return this.#process.pid;
  }

  async close() {
    await this.call("Browser.close").catch(() => {});
    await new Promise((resolve) => (this.#process.exitCode === null ? this.#process.on("exit", resolve) : resolve()));
    rmSync(this.#profile, { recursive: true, force: true, maxRetries: 5 });
    rmSync(this.downloads, { recursive: true, force: true });
  }

  #received({ id, result, error, method, params, sessionId }) {
    if (id === undefined) {
      this.#listeners.get(sessionId)?.(method, params);
      return;
    }
    const { resolve, reject, method: called } = this.#waiting.get(id);
    this.#waiting.delete(id);
    error === undefined ? resolve(result) : reject(new Error(`${called}: ${error.message}`));
  }
}

/** An open page. `errors` are the errors that it wrote to the console, `requests` the URLs that it requested. */
export class Page {
  errors = [];
  requests = [];
  #browser;
  #session;
  #target;
  #wanted = new Map(); // by the name of an event

  constructor(browser, session, target) {
    [this.#browser, this.#session, this.#target] = [browser, session, target];
  }

  call(method, params) {
    return this.#browser.call(method, params, this.#session);
  }

  next(method) {
    return new Promise((resolve) => this.#wanted.set(method, resolve));
  }

  heard(method, params) {
    this.#wanted.get(method)?.(params);
    if (method === "Runtime.exceptionThrown") {
      this.errors.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
    } else if (method === "Runtime.consoleAPICalled" && ["error", "warning"].includes(params.type)) {
      this.errors.push(params.args.map(({ value, description }) => value ?? description).join(" "));
    } else if (method === "Log.entryAdded" && params.entry.level === "error") {
      this.errors.push(params.entry.text);
    } else if (method === "Network.requestWillBeSent" && !/^(file|blob|data|about):/.test(params.request.url)) {
      this.requests.push(params.request.url);
    }
  }

  /** Evaluates an expression in the page, and awaits it if it is a promise. */
  async value(expression) {
    const { result, exceptionDetails } = await this.call("Runtime.evaluate", { expression, returnByValue: true, awaitPromise: true, userGesture: true });
    if (exceptionDetails !== undefined) {
      throw new Error(`${expression}: ${exceptionDetails.exception?.description ?? exceptionDetails.text}`);
    }
    return result.value;
  }

  text(id) {
    return this.value(`document.getElementById(${JSON.stringify(id)}).${id === "place" ? "value" : "textContent"}`);
  }

  click(selector) {
    return this.value(`document.querySelector(${JSON.stringify(selector)}).click()`);
  }

  select(id, value) {
    return this.value(`{ const one = document.getElementById("${id}"); one.value = ${JSON.stringify(value)}; one.dispatchEvent(new Event("change", { bubbles: true })); }`);
  }

  /** Waits until an expression is true; returns its value. */
  async until(expression, seconds = MAX_SECONDS) {
    const end = Date.now() + 1000 * seconds;
    for (;;) {
      const value = await this.value(expression);
      if (value) {
        return value;
      }
      if (Date.now() > end) {
        const words = await this.value("document.body.innerText.replace(/\\s+/g, ' ').slice(0, 2000)");
        throw new Error(`not within ${seconds} s: ${expression}; errors: "${this.errors.slice(0, 3).join("; ")}"; the page: ${words}`);
      }
      await new Promise((resolve) => setTimeout(resolve, 20));
    }
  }

  size(width, height) {
    return this.call("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: width < 600 });
  }

  scheme(value) {
    return this.call("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value }] });
  }

  async image(whole = true) {
    const { data } = await this.call("Page.captureScreenshot", { format: "png", captureBeyondViewport: whole });
    return Buffer.from(data, "base64");
  }

  async key(key, { shift = false, alt = false } = {}) {
    const of = { key, code: key, modifiers: (alt ? 1 : 0) | (shift ? 8 : 0), windowsVirtualKeyCode: CODES[key], ...(key === "Enter" ? { text: "\r" } : {}) };
    await this.call("Input.dispatchKeyEvent", { type: "keyDown", ...of });
    await this.call("Input.dispatchKeyEvent", { type: "keyUp", ...of });
  }

  async drag([fromX, fromY], [toX, toY]) {
    const mouse = (type, x, y, buttons) => this.call("Input.dispatchMouseEvent", { type, x, y, button: "left", buttons, clickCount: 1 });
    await mouse("mousePressed", fromX, fromY, 1);
    for (const part of [0.5, 1]) {
      await mouse("mouseMoved", fromX + (toX - fromX) * part, fromY + (toY - fromY) * part, 1);
    }
    await mouse("mouseReleased", toX, toY, 0);
  }

  async swipe([fromX, fromY], [toX, toY]) {
    const touch = (type, ...points) => this.call("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y]) => ({ x, y })) });
    await touch("touchStart", [fromX, fromY]);
    await touch("touchMove", [(fromX + toX) / 2, (fromY + toY) / 2]);
    await touch("touchMove", [toX, toY]);
    await touch("touchEnd");
  }

  close() {
    return this.#browser.call("Target.closeTarget", { targetId: this.#target });
  }
}

const CODES = { Enter: 13, Escape: 27, Tab: 9, " ": 32, ArrowLeft: 37, ArrowUp: 38, ArrowRight: 39, ArrowDown: 40 };
