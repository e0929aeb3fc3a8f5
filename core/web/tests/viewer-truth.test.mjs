// A hand that marks the truth of a clip of 30 seconds in `host-sim view`: its clicks and keys are counted, and
// `host-sim eval` measures trackers on what it exports.
//
// Requires a program `chromium` (or CHROMIUM) and host-sim (SMR_HOST_SIM); else the test is skipped by name.

import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { FRAMES, HIDDEN, SIZE, clip, truthIn } from "./annotated-clip.mjs";
import { Browser, hasBrowser } from "./browser.mjs";
import { PACKAGE } from "./library.mjs";

const HOST_SIM = process.env.SMR_HOST_SIM;
const why = !hasBrowser() ? "no chromium" : !HOST_SIM ? "SMR_HOST_SIM does not name host-sim" : null;
if (why !== null) {
  console.log(`skipped: viewer's truth: ${why}`);
}
const MAX_ACTS = 25;
const MAX_SECONDS = 300;

// The user: each click, drag and key is one act. What it waits for, it sees on the page.
class Hand {
  acts = [];
  #page;

  constructor(page) {
    this.#page = page;
  }

  async key(key) {
    this.acts.push(key);
    await this.#page.key(key);
  }

  async click(selector) {
    this.acts.push(selector);
    await this.#page.click(selector);
  }

  /** Clicks on the timeline at a frame, which the preview names. */
  async goTo(number) {
    this.acts.push(`frame ${number}`);
    const [left, top, width] = await this.#page.value(`(() => { const { left, top, width } = document.getElementById("timeline").getBoundingClientRect(); return [left, top, width]; })()`);
    const at = { x: left + 8 + ((width - 16) * (number - 0.5)) / FRAMES, y: top + 15, button: "left", clickCount: 1 };
    await this.#page.call("Input.dispatchMouseEvent", { type: "mousePressed", buttons: 1, ...at });
    await this.#page.call("Input.dispatchMouseEvent", { type: "mouseReleased", buttons: 0, ...at });
    await this.#page.until(`document.getElementById("place").value.startsWith("frame ${number} of ")`);
  }

  /** Draws the target's box in the shown frame, from a corner that lies outside of the present box, or pulls this one. */
  async box(number) {
    this.acts.push(`box ${number}`);
    if (this.acts.length > 1) {
      await followed(this.#page);
    }
    const { x, y, width, height } = truthIn(number);
    const words = await this.#page.until(`document.getElementById("stage").getAttribute("aria-label").startsWith("Frame ${number},") && document.getElementById("stage").getAttribute("aria-label")`);
    const [, left, top, wide, high] = (/left (\S+), top (\S+), (\d+) x (\d+)/.exec(words) ?? []).map(Number);
    const isOutside = ([across, down]) => left === undefined || across < left - 2 || across > left + wide + 2 || down < top - 2 || down > top + high + 2;
    const corners = [[x, y], [x + width, y], [x, y + height], [x + width, y + height]];
    const from = corners.findIndex(isOutside);
    if (from >= 0) {
      await this.#page.drag(await this.#place(...corners[from]), await this.#place(...corners[3 - from]));
      if (await this.#page.value(`!document.getElementById("asked").hidden`)) {
        await this.click("#correct");
      }
    } else {
      // A hand that pulls a box which is right moves it by a pixel.
      const isRight = Math.hypot(x + width / 2 - left - wide / 2, y + height / 2 - top - high / 2) < 1;
      await this.#page.drag(await this.#place(left + wide / 2, top + high / 2), await this.#place(x + width / 2 + (isRight ? 1 : 0), y + height / 2));
    }
    await this.#page.until(`fetch("source").then((answer) => answer.json()).then(({ targets }) => targets[0]?.locks.some(({ frame }) => frame === ${number}))`);
  }

  #place(x, y) {
    return this.#page.value(`(() => {
      const { left, top, width } = document.getElementById("stage").getBoundingClientRect();
      return [left + ${x} * width / ${SIZE.width}, top + ${y} * width / ${SIZE.width}];
    })()`);
  }
}

const shown = (page) => page.value(`parseInt(document.getElementById("place").value.split(" ")[1])`);
// Waits until all frames are followed, and then as long as a hand needs to see it.
async function followed(page) {
  await page.until(`fetch("news?since=0").then((answer) => answer.json()).then(({ followed, progress }) => followed === ${FRAMES} && progress === null)`);
  await page.until(`document.getElementById("load").textContent === ""`);
  await new Promise((resolve) => setTimeout(resolve, 500));
}
const until = (page, number) => page.until(`parseInt(document.getElementById("place").value.split(" ")[1]) >= ${number}`);
const hint = (page, pattern) => page.until(`${pattern}.test(document.getElementById("hint").textContent)`);

test(`the truth of 30 seconds takes ${MAX_ACTS} clicks and keys, and eval measures trackers on it`, { skip: why ?? false }, async () => {
  const folder = mkdtempSync(join(tmpdir(), "smr-truth-"));
  mkdirSync(PACKAGE, { recursive: true });
  writeFileSync(join(folder, "clip.y4m"), clip());
  const server = spawn(HOST_SIM, ["view", "clip.y4m", "--no-open", "--json"], { cwd: folder, stdio: ["ignore", "pipe", "inherit"] });
  const browser = new Browser();
  try {
    const { address } = JSON.parse(await new Promise((resolve) => server.stdout.once("data", resolve)));
    const page = await browser.page(address);
    await page.until(`document.getElementById("place").value !== ""`);
    await hint(page, /^Drag a box over what is to be followed\.$/);
    // The hand would look at the usual speed; that takes no other clicks.
    await page.select("speed", "4");
    const begin = Date.now();
    const hand = new Hand(page);
    await hand.box(1);
    await until(page, FRAMES);
    // Behind the pillar, which covers a part of the target before it is lost: the timeline shows these frames to a mouse.
    await hand.goTo(96);
    await hand.box(96);
    await hand.goTo(252);
    await hand.box(252);
    await hand.key("b");
    await page.until(`document.getElementById("line").ariaPressed === "true"`);
    await hand.goTo(HIDDEN[0]);
    await hand.key("h");
    await hint(page, /^Hidden up to .*press H again/);
    await hand.goTo(HIDDEN[1] + 1);
    await hand.key("h");
    await followed(page);
    // In the fog.
    await hand.key("n");
    await hint(page, /^The (target is lost|tracker is uncertain)/);
    const doubt = await shown(page);
    await hand.box(doubt);
    await hand.goTo(415);
    await hand.box(415);
    await hand.key("b");
    await page.until(`document.getElementById("line").ariaPressed === "true"`);
    await followed(page);
    // Out of the picture, and back at another place.
    await hand.key("n");
    await hint(page, /^The (target is lost|tracker is uncertain)/);
    await hand.key("g");
    await hand.goTo(621);
    await hand.box(621);
    await followed(page);
    await hand.key("n");
    await page.until(`document.getElementById("share").textContent === "100 % checked"`);
    writeFileSync(join(PACKAGE, "viewer-truth.png"), await page.image());
    await hand.click("#export summary");
    await hand.click("#recording");
    await page.until(`/host-sim eval /.test(document.getElementById("made").textContent)`);
    const seconds = (Date.now() - begin) / 1000;
    console.log(`the truth of 30 seconds: ${hand.acts.length} clicks and keys, ${Math.round(seconds)} s at speed 4: ${hand.acts.join(", ")}`);
    assert.ok(hand.acts.length <= MAX_ACTS && seconds < MAX_SECONDS, `${hand.acts.length} acts in ${seconds} s`);
    assert.deepEqual(page.errors, []);
    compare(join(folder, "clip-truth"));
    const eval_ = spawnSync(HOST_SIM, ["eval", "clip-truth", "--method", "robust,paper", "--json"], { cwd: folder, encoding: "utf8" });
    assert.equal(eval_.status, 0, eval_.stderr);
    const { measured } = JSON.parse(eval_.stdout);
    assert.deepEqual(measured.map(({ tracker, frames }) => [tracker, frames]), [["robust", FRAMES], ["paper", FRAMES]]);
    await page.close();
  } finally {
    await browser.close();
    server.kill();
    rmSync(folder, { recursive: true });
  }
});

// Compares what was exported with the truth of the drawn clip.
function compare(folder) {
  const lines = readFileSync(join(folder, "gt.txt"), "utf8").trim().split("\n").map((line) => line.split(",").map(Number));
  assert.equal(lines.length, FRAMES);
  const pairs = lines.map(([x, y, right, bottom], at) => [truthIn(at + 1), Number.isNaN(x) ? null : { x, y, width: right - x, height: bottom - y }]);
  const differing = pairs.filter(([truth, told]) => (truth === null) !== (told === null)).length;
  const overlaps = pairs.filter((pair) => !pair.includes(null)).map(overlapOf);
  const mean = overlaps.reduce((sum, overlap) => sum + overlap, 0) / overlaps.length;
  const right = overlaps.filter((overlap) => overlap > 0.5).length;
  console.log(`the truth of 30 seconds: mean IoU ${mean.toFixed(3)}, ${right} of ${overlaps.length} above 0.5; ${differing} frames are wrongly hidden or not`);
  assert.ok(mean > 0.8 && right > 0.97 * overlaps.length && differing < 20);
}

function overlapOf([one, other]) {
  const shared = (from, length) => Math.max(Math.min(one[from] + one[length], other[from] + other[length]) - Math.max(one[from], other[from]), 0);
  const common = shared("x", "width") * shared("y", "height");
  return common / (one.width * one.height + other.width * other.height - common);
}
