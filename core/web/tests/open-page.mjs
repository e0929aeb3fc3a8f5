// Helpers for tests of the stand-alone page in a headless Chromium: open it, act as a user, compare with host-sim.
//
// Requires the output of `.ci/web build`, a program `chromium` (or CHROMIUM), and host-sim (SMR_HOST_SIM); else tests
// are skipped by name. Screenshots are written to target/web.

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
// True once the page shows a frame or an error message.
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

// Returns the recording `synthetic` as Y4M for Chromium's fake camera, in the range of video (16 to 235).
function y4m() {
  const { width, height, length } = SYNTHETIC;
  const colors = Buffer.alloc((width * height) / 2, 128);
  const frames = Array.from({ length }, (_, index) => [Buffer.from("FRAME\n"), syntheticFrame(index).map((gray) => 16 + (gray * 219) / 255), colors]);
  return Buffer.concat([Buffer.from(`YUV4MPEG2 W${width} H${height} F30:1 Ip C420jpeg\n`), ...frames.flat()]);
}

// Runs a test on a new page, which must write no errors to the console and send no network requests.
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

// Takes a screenshot of the whole page, after enlarging the window, because a browser does not draw hidden parts.
export async function shoot(page, name, width) {
  await page.size(width, await page.value(`document.documentElement.scrollHeight`));
  await new Promise((resolve) => setTimeout(resolve, 400));
  writeFileSync(join(PACKAGE, `page-${name}.png`), await page.image());
}

/** Saves a file by the page's menu and returns its path. */
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
/** Saves the answers as JSON and returns them: one object for each frame of each target. */
export const answers = async (page) => (await read(page, "JSON", ".jsonl")).map((line) => JSON.parse(line));
export const boxes = (page) => read(page, "CSV", ".csv");

/** Goes to the last frame and waits until all targets are tracked up to it. */
export async function followed(page) {
  await page.key("End");
  // The page updates its text less often than the frame.
  await new Promise((resolve) => setTimeout(resolve, 300));
  await page.until(`${LAST} && [...document.querySelectorAll(".now")].every(({ textContent }) => textContent !== "–") && ${IDLE}`);
}

// Removes the column `work` of SMR, before those of centre and speed, which depends on the tracker's capacity, which is larger in host-sim.
export const columns = (method) => (line) => (method === "paper" ? line.split(",").filter((_, at, all) => at !== all.length - 4).join() : line);

export function same(found, expected, method) {
  found.forEach((answer, at) => {
    const work = method === "paper" ? { work: answer.work } : {};
    assert.deepEqual(answer, { ...expected[at], ...work }, `${method}, frame ${at + 1}`);
  });
}

/** Lets host-sim replay the page's flight record and checks that at least `least` answers agree. */
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

// Waits until the shown frame no longer changes, because requested frames may still be loading.
export async function settled(page) {
  for (let before = -1, now = 0; before !== now; ) {
    [before, now] = [now, await page.value(NUMBER)];
    await new Promise((resolve) => setTimeout(resolve, 150));
  }
}

/** Converts a pixel of the frame to a position in the window. */
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
