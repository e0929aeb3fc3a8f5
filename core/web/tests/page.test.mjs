// The page in a real headless Chromium: what it answers equals what host-sim answers, and every bad start has one clear line.
//
// Needs what `.ci/web build` has built, a program `chromium` (or CHROMIUM), and host-sim (SMR_HOST_SIM); names what it skips. Pictures of the page go
// to target/web.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { Browser, hasBrowser } from "./browser.mjs";
import { PACKAGE, PROJECT } from "./library.mjs";
import { BUILT_IN, syntheticFrame } from "../page/synthetic.js";

const HOST_SIM = process.env.SMR_HOST_SIM;
const FRAMES = 100;
const PRESSED = `document.getElementById("play").ariaLabel === "Play"`;
// Frames come, or the page says why not.
const STARTED = `document.getElementById("place").value !== "" || !document.getElementById("said").hidden`;
const NUMBER = `Number(document.getElementById("place").value.split(" ")[1])`;
const why = !hasBrowser() ? "no chromium" : !HOST_SIM ? "SMR_HOST_SIM does not name host-sim" : null;
if (why !== null) {
  console.log(`skipped: page: ${why}`);
}

let browser, folder;
const address = pathToFileURL(join(PACKAGE, "smr.html")).href;
const host = (...args) => spawnSync(HOST_SIM, args, { encoding: "utf8", maxBuffer: 1 << 28 });
const lines = (text) => text.trim().split("\n");

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

// The built-in recording as a camera gives it, in the range of video.
function y4m() {
  const { width, height, length } = BUILT_IN;
  const colors = Buffer.alloc((width * height) / 2, 128);
  const frames = Array.from({ length }, (_, index) => [Buffer.from("FRAME\n"), syntheticFrame(index).map((gray) => 16 + (gray * 219) / 255), colors]);
  return Buffer.concat([Buffer.from(`YUV4MPEG2 W${width} H${height} F30:1 Ip C420jpeg\n`), ...frames.flat()]);
}

// A test on a page of its own, which may neither write errors nor ask the network for anything.
function onPage(name, run, options) {
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

// What is not in view is not drawn: so all of it is.
async function shoot(page, name, width) {
  await page.size(width, await page.value(`document.documentElement.scrollHeight`));
  await new Promise((resolve) => setTimeout(resolve, 400));
  writeFileSync(join(PACKAGE, `page-${name}.png`), await page.picture());
}

async function downloaded(page, kind, name) {
  const file = join(browser.downloads, name);
  rmSync(file, { force: true });
  await page.click(`[data-file="${kind}"]`);
  for (let wait = 0; !existsSync(file); wait += 20) {
    assert.ok(wait < 10_000, `${name} was not saved; the page says "${await page.text("said")}"`);
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
  return file;
}

/** The answers of a method, an object for each target and frame. */
async function answers(page, method) {
  await page.select("of", method);
  return lines(readFileSync(await downloaded(page, "json", `boxes-${method}.jsonl`), "utf8")).map((line) => JSON.parse(line));
}

// The work of SMR depends on the capacity of the tracker, which host-sim has more of. All else is the same.
const columns = (method) => (line) => (method === "smr" ? line.slice(0, line.lastIndexOf(",")) : line);

function same(found, expected, method) {
  found.forEach((answer, at) => {
    const work = method === "smr" ? { work: answer.work } : {};
    assert.deepEqual(answer, { ...expected[at], ...work }, `${method}, frame ${at + 1}`);
  });
}

/** host-sim computes what is in the flight record again, and agrees in so many answers. */
async function replays(page, method, least) {
  await page.select("of", method);
  const file = await downloaded(page, "record", `flight-${method}.smr`);
  const { status, stdout, stderr } = host("replay", file, "--json");
  assert.equal(status, 0, stdout + stderr);
  const count = JSON.parse(stdout).flights.reduce((sum, flight) => sum + flight.answers, 0);
  assert.ok(count >= least, stdout);
}

async function pausedAt(page, number) {
  await page.until(`${NUMBER} >= ${number}`);
  await page.click("#play");
  await page.until(PRESSED);
  await settled(page);
}

// Frames that are under way still come.
async function settled(page) {
  for (let before = -1, now = 0; before !== now; ) {
    [before, now] = [now, await page.value(NUMBER)];
    await new Promise((resolve) => setTimeout(resolve, 150));
  }
}

/** Where a pixel of the frame is in the window. */
async function place(page, x, y) {
  return page.value(`(() => {
    const stage = document.getElementById("stage");
    stage.scrollIntoView({ block: "center" });
    const { left, top, width, height } = stage.getBoundingClientRect();
    const [wide, high] = document.getElementById("load").textContent.match(/(\\d+)x(\\d+)/).slice(1).map(Number);
    return [left + ${x} * width / wide, top + ${y} * height / high];
  })()`);
}

async function dragBox(page, { x, y, width, height }, how = "drag") {
  const from = await place(page, x, y);
  await page[how](from, await place(page, x + width, y + height));
}

onPage("the built-in recording moves at once, and its answers are those of host-sim", async (page) => {
  await page.click("#repeat");
  await page.select("speed", "2");
  await pausedAt(page, FRAMES + 1);
  for (const [method, ...options] of [["robust"], ["smr", "--config", "camera"]]) {
    const expected = host("track", "synthetic", "--method", method, ...options, "--json");
    const found = await answers(page, method);
    assert.ok(found.length > FRAMES);
    same(found, lines(expected.stdout).map((line) => JSON.parse(line)), method);
    const csv = lines(host("track", "synthetic", "--method", method, ...options, "--format", "csv").stdout);
    const saved = lines(readFileSync(await downloaded(page, "csv", `boxes-${method}.csv`), "utf8"));
    assert.deepEqual(saved.map(columns(method)), csv.slice(0, saved.length).map(columns(method)));
    const [program, ...words] = (await page.text("command")).split(" ");
    assert.equal(program, "host-sim");
    assert.equal(host(...words, "--json").stdout, expected.stdout);
    await replays(page, method, FRAMES);
  }
  assert.match(await page.text("load"), /No frame was dropped/);
});

onPage("a camera: a box is dragged, 100 frames are followed, and host-sim agrees on the very pixels", async (page) => {
  await page.click("#camera");
  await page.until(`document.getElementById("camera").ariaPressed === "true" && ${NUMBER} > 0`);
  // While the mouse is down the picture waits: so this is where the target is.
  await dragBox(page, { x: 60, y: 50, width: 40, height: 40 });
  await page.until(`document.getElementById("command").textContent !== ""`);
  await page.until(`${NUMBER} >= ${FRAMES + 20}`);
  // A change of the window meanwhile changes nothing but the picture.
  await page.size(900, 700);
  await pausedAt(page, FRAMES + 30);
  await shoot(page, "camera", 900);
  for (const method of ["robust", "smr"]) {
    const found = await answers(page, method);
    assert.ok(found.length >= FRAMES, `${found.length} answers`);
    assert.deepEqual(found.map(({ frame }) => frame), found.map((_, at) => found[0].frame + at));
    assert.equal(found[0].box.width * found[0].box.height > 0, true);
    await replays(page, method, FRAMES);
  }
});

onPage("a page of 390 pixels, by keys alone, with several targets", async (page) => {
  await page.until(`${NUMBER} > 3`);
  await page.click("#repeat");
  await page.click("#play");
  await page.until(PRESSED);
  await settled(page);
  await page.value(`document.getElementById("add").focus()`);
  await page.key("Enter");
  assert.equal(await page.value(`document.activeElement.id`), "stage");
  const keys = [["ArrowRight"], ["ArrowRight"], ["ArrowDown", { alt: true }], ["ArrowLeft", { shift: true }], ["ArrowDown", { shift: true, alt: true }], ["Enter"]];
  for (const [key, held] of keys) {
    await page.key(key, held);
  }
  await page.until(`document.getElementById("command").textContent.includes("2=")`);
  await page.click("#add");
  await dragBox(page, { x: 40, y: 80, width: 20, height: 20 }, "swipe");
  await page.until(`document.getElementById("command").textContent.includes("3=40,80,20,20@")`);
  await page.value(`document.getElementById("stage").focus()`);
  await page.key(" ");
  await pausedAt(page, 60);
  const [, x, y, width, height, frame] = (await page.text("command")).match(/--init 2=(\d+),(\d+),(\d+),(\d+)@(\d+)/).map(Number);
  assert.deepEqual([x, y, width, height], [67, 49, 29, 25]);
  const expected = host("track", "synthetic", "--init", "1=36,24,24,28", "--init", `2=${x},${y},${width},${height}@${frame}`, "--init", `3=40,80,20,20@${frame}`, "--json");
  const found = await answers(page, "robust");
  assert.deepEqual(found, lines(expected.stdout).slice(0, found.length).map((line) => JSON.parse(line)));
  assert.equal(await page.value(`document.documentElement.scrollWidth <= innerWidth`), true);
  await shoot(page, "narrow", 390);
}, { width: 390, height: 844 });

onPage("locks are repeated when a recording starts again, with other settings too", async (page) => {
  await page.select("speed", "2");
  await pausedAt(page, 20);
  const next = await page.value(NUMBER);
  await dragBox(page, { x: 100, y: 60, width: 30, height: 30 });
  await page.until(`document.getElementById("command").textContent.includes("@${next}")`);
  await page.select("reach", "6");
  await page.click("#sweep");
  await page.click("#refiner");
  await page.click("#play");
  await pausedAt(page, next + 10);
  const command = await page.text("command");
  assert.match(command, /--init 36,24,24,28 --init 100,60,30,30@\d+ --method robust --reach 6 --without sweep,refiner$/);
  const expected = lines(host(...command.split(" ").slice(1), "--json").stdout).map((line) => JSON.parse(line));
  same(await answers(page, "robust"), expected, "robust");
});

onPage("a box of 0x0, a tracker that is switched off, a removed target", async (page) => {
  await page.until(`${NUMBER} > 3`);
  await dragBox(page, { x: 80, y: 60, width: 0, height: 0 });
  await page.until(`document.getElementById("said").textContent === "The box has no pixels: drag from one corner to the other."`);
  assert.equal(await page.value(`document.getElementById("said").hidden`), false);
  await page.click("#switches label:nth-of-type(2) input");
  await page.until(`document.querySelectorAll("#figures thead th").length === 2`);
  await page.click("#targets button");
  await page.until(`document.querySelectorAll("#targets li").length === 0`);
  await page.click(`[data-file="record"]`);
  await page.until(`document.getElementById("said").textContent === "ROBUST has no flight record: lock it on a target first."`);
});

onPage("a broken video has one clear line, and the built-in recording goes on", async (page) => {
  await page.until(`${NUMBER} > 3`);
  const file = join(folder, "broken.mp4");
  writeFileSync(file, Buffer.alloc(5000, "not a video "));
  await choose(page, file);
  await page.until(`/^broken.mp4 is no video that this browser plays/.test(document.getElementById("said").textContent)`);
  await page.until(`${NUMBER} > 10`);
  assert.match(await page.text("said"), /^broken.mp4 is no video/);
});

onPage("a video is locked on its first frame, stepped with host-sim's answers, and numbered by its time", async (page, context) => {
  const file = join(folder, "synthetic.webm");
  const raw = Buffer.concat(Array.from({ length: 60 }, (_, index) => syntheticFrame(index)));
  const film = ["-v", "error", "-f", "rawvideo", "-pix_fmt", "gray", "-s", "160x120", "-r", "25", "-i", "-", "-c:v", "libvpx", "-b:v", "2M", "-y", file];
  const { status } = spawnSync("ffmpeg", film, { input: raw });
  if (status !== 0) {
    console.log("skipped: page: a video file: no ffmpeg that makes WebM");
    context.skip("no ffmpeg");
    return;
  }
  await page.click("#repeat");
  await choose(page, file);
  await page.until(`document.getElementById("place").value === "frame 1" && document.getElementById("choose").ariaPressed === "true"`);
  await dragBox(page, { x: 36, y: 24, width: 24, height: 28 });
  await page.until(`document.getElementById("command").textContent.includes("--init 36,24,24,28 ")`);
  for (let number = 2; number <= 12; number++) {
    await page.click("#step");
    await page.until(`document.getElementById("place").value.startsWith("frame ${number}")`);
  }
  const expected = lines(host("track", file, "--init", "36,24,24,28", "--json").stdout).map((line) => JSON.parse(line));
  const stepped = await answers(page, "robust");
  assert.equal(stepped.length, 12);
  same(stepped, expected, "robust");
  await page.click("#play");
  await page.until(`document.getElementById("place").value === "frame 60 of 60"`);
  const found = await answers(page, "robust");
  assert.ok(found.every(({ state }) => state === "tracking"), JSON.stringify(found.at(-1)));
  await replays(page, "robust", found.length - 1);
});

onPage("without WebAssembly there is one clear line", async (page) => {
  await page.until(`document.getElementById("said").textContent.startsWith("This browser has no WebAssembly")`);
  assert.equal(await page.value(`document.getElementById("stage").offsetHeight`), 0);
}, { prepare: "delete globalThis.WebAssembly;" });

for (const scheme of ["light", "dark"]) {
  onPage(`it is seen in the ${scheme}, in the colors of host-sim's pages`, async (page) => {
    await page.select("speed", "2");
    await page.until(`${NUMBER} > 40`);
    await shoot(page, scheme, 1280);
    const report = join(folder, `${scheme}.html`);
    assert.equal(host("report", "synthetic", "--frames", "1..3", "--method", "robust,smr", "--out", report).status, 0);
    const theirs = await browser.page(pathToFileURL(report).href, { scheme });
    assert.deepEqual(await page.value(COLORS), await theirs.value(COLORS.replace("look-robust", "look-0").replace("look-smr", "look-1")));
    await theirs.close();
  }, { scheme });
}

const COLORS = `["look-robust", "look-smr"].map((name) => {
  const node = document.body.appendChild(document.createElement("i"));
  node.className = name;
  const { color, ...style } = Object.fromEntries(["--c", "--line", "--dashes", "--tracking", "--leaving", "--lost", "--paper", "--ink", "--panel"]
    .map((name) => [name, getComputedStyle(node).getPropertyValue(name).trim()]));
  node.remove();
  return style;
})`;

test("a refused camera has one clear line, and the built-in recording goes on", { skip: why ?? false }, async () => {
  const other = new Browser(["--use-fake-device-for-media-stream", "--deny-permission-prompts"]);
  try {
    const page = await other.page(address);
    await page.until(STARTED);
    await page.click("#camera");
    await page.until(`document.getElementById("said").textContent.startsWith("The camera was refused")`);
    await page.until(`${NUMBER} > 10`);
    assert.match(await page.text("said"), /^The camera was refused: allow it/);
    assert.deepEqual([page.errors, page.requests], [[], []]);
  } finally {
    await other.close();
  }
});

async function choose(page, file) {
  const { root } = await page.call("DOM.getDocument");
  const { nodeId } = await page.call("DOM.querySelector", { nodeId: root.nodeId, selector: "#file" });
  await page.call("DOM.setFileInputFiles", { files: [file], nodeId });
}
