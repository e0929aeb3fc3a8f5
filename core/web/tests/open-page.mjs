// The page in a real headless Chromium, for the tests of it: opens it, does what a user does, and compares with host-sim.
//
// Needs what `.ci/web build` has built, a program `chromium` (or CHROMIUM), and host-sim (SMR_HOST_SIM); names what it skips. Pictures of the page go
// to target/web.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { Browser, hasBrowser } from "./browser.mjs";
import { HOST_SIM, PACKAGE, PROJECT, SYNTHETIC, syntheticFrame } from "./library.mjs";

export const FRAMES = 100;
export const PRESSED = `document.getElementById("play").ariaLabel === "Play"`;
// Frames come, or the page says why not.
export const STARTED = `document.getElementById("place").value !== "" || !document.getElementById("said").hidden`;
export const NUMBER = `Number(document.getElementById("place").value.split(" ")[1])`;
const LAST = `/^frame (\\d+)( of \\1)?\\b/.test(document.getElementById("place").value)`;
const IDLE = `!document.getElementById("load").textContent.includes("Following")`;
export const why = !hasBrowser() ? "no chromium" : !HOST_SIM ? "SMR_HOST_SIM does not name host-sim" : null;
if (why !== null) {
  console.log(`skipped: page: ${why}`);
}

export let browser, folder;
export const address = pathToFileURL(join(PACKAGE, "smr.html")).href;
export const host = (...args) => spawnSync(HOST_SIM, args, { encoding: "utf8", maxBuffer: 1 << 28 });
export const lines = (text) => text.trim().split("\n");

before(async () => {
  if (why === null) {
    folder = mkdtempSync(join(tmpdir(), "smr-page-"));
    const built = spawnSync(process.execPath, [join(PROJECT, "core/web/page/build.mjs")], { encoding: "utf8" });
    assert.equal(built.status, 0, built.stderr);
    writeFileSync(join(folder, "camera.y4m"), y4m());
    browser = new Browser([
      "--use-fake-ui-for-media-stream", "--use-fake-device-for-media-stream", `--use-file-for-fake-video-capture=${join(folder, "camera.y4m")}`,
      "--autoplay-policy=no-user-gesture-required",
    ]);
  }
});

after(async () => {
  await browser?.close();
  if (folder !== undefined) {
    rmSync(folder, { recursive: true });
  }
});

// The recording `synthetic` as a camera gives it, in the range of video.
function y4m() {
  const { width, height, length } = SYNTHETIC;
  const colors = Buffer.alloc((width * height) / 2, 128);
  const frames = Array.from({ length }, (_, index) => [Buffer.from("FRAME\n"), syntheticFrame(index).map((gray) => 16 + (gray * 219) / 255), colors]);
  return Buffer.concat([Buffer.from(`YUV4MPEG2 W${width} H${height} F30:1 Ip C420jpeg\n`), ...frames.flat()]);
}

// A test on a page of its own, which may neither write errors nor ask the network for anything.
export function onPage(name, run, options) {
  test(name, { skip: why ?? false }, async (context) => {
    const page = await browser.page(address, options);
    try {
      await page.until(STARTED);
      await run(page, context);
      assert.deepEqual([page.errors, page.requests], [[], []]);
    } finally {
      await page.close();
    }
  });
}

// A browser does not draw what is out of view: so the whole page is in view.
export async function shoot(page, name, width) {
  await page.size(width, await page.value(`document.documentElement.scrollHeight`));
  await new Promise((resolve) => setTimeout(resolve, 400));
  writeFileSync(join(PACKAGE, `page-${name}.png`), await page.picture());
}

/** Saves a file by the menu; returns its path. Its name is that of the source, and what is not followed to its end says so. */
export async function downloaded(page, label, ending) {
  const before = readdirSync(browser.downloads);
  before.forEach((name) => rmSync(join(browser.downloads, name)));
  await page.value(`[...document.querySelectorAll("#files button")].find((one) => one.textContent === "${label}").click()`);
  for (let wait = 0; ; wait += 20) {
    const name = readdirSync(browser.downloads).find((one) => one.endsWith(ending));
    if (name !== undefined) {
      return join(browser.downloads, name);
    }
    assert.ok(wait < 60_000, `${label} was not saved; the page says "${await page.text("said")}"`);
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
}

const read = async (page, label, ending) => lines(readFileSync(await downloaded(page, label, ending), "utf8"));
/** The answers, an object for each target and frame. */
export const answers = async (page) => (await read(page, "JSON", ".jsonl")).map((line) => JSON.parse(line));
export const boxes = (page) => read(page, "CSV", ".csv");

/** Waits until all targets are followed to the last frame, which is shown then. */
export async function followed(page) {
  await page.key("End");
  // Numbers change no quicker than they can be read.
  await new Promise((resolve) => setTimeout(resolve, 300));
  await page.until(`${LAST} && [...document.querySelectorAll(".now")].every(({ textContent }) => textContent !== "–") && ${IDLE}`);
}

// The work of SMR depends on the capacity of the tracker, which host-sim has more of. All else is the same.
export const columns = (method) => (line) => (method === "smr" ? line.slice(0, line.lastIndexOf(",")) : line);

export function same(found, expected, method) {
  found.forEach((answer, at) => {
    const work = method === "smr" ? { work: answer.work } : {};
    assert.deepEqual(answer, { ...expected[at], ...work }, `${method}, frame ${at + 1}`);
  });
}

/** host-sim computes what is in the flight record again, and agrees in so many answers. */
export async function replays(page, least) {
  const { status, stdout, stderr } = host("replay", await downloaded(page, "Flight record", ".smr"), "--json");
  assert.equal(status, 0, stdout + stderr);
  const count = JSON.parse(stdout).flights.reduce((sum, flight) => sum + flight.answers, 0);
  assert.ok(count >= least, stdout);
}

export async function pausedAt(page, number) {
  await page.until(`${NUMBER} >= ${number}`);
  await page.click("#play");
  await page.until(PRESSED);
  await settled(page);
}

// Frames that are under way still come.
export async function settled(page) {
  for (let before = -1, now = 0; before !== now; ) {
    [before, now] = [now, await page.value(NUMBER)];
    await new Promise((resolve) => setTimeout(resolve, 150));
  }
}

/** Where a pixel of the frame is in the window. */
export async function place(page, x, y) {
  return page.value(`(() => {
    const stage = document.getElementById("stage");
    stage.scrollIntoView({ block: "center" });
    const { left, top, width, height } = stage.getBoundingClientRect();
    const [wide, high] = document.getElementById("about").textContent.match(/(\\d+)x(\\d+)/).slice(1).map(Number);
    return [left + ${x} * width / wide, top + ${y} * height / high];
  })()`);
}

export async function dragBox(page, { x, y, width, height }, how = "drag") {
  const from = await place(page, x, y);
  await page[how](from, await place(page, x + width, y + height));
}

export async function choose(page, file) {
  const { root } = await page.call("DOM.getDocument");
  const { nodeId } = await page.call("DOM.querySelector", { nodeId: root.nodeId, selector: "#file" });
  await page.call("DOM.setFileInputFiles", { files: [file], nodeId });
}
