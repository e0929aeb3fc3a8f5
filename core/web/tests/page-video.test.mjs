// Video files and the slider in a headless Chromium: no frame is lost, and any frame can be shown and corrected.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { NUMBER, answers, boxes, choose, dragBox, folder, followed, host, lines, onPage, replays, same, settled, shoot } from "./open-page.mjs";
import { SYNTHETIC, syntheticFrame } from "./library.mjs";

const BOX = "36,24,24,28";
const DELAY = 80; // of a slow worker, in milliseconds
const SIDE = 8; // of the squares that say the number of a frame, in pixels

// Encodes the recording `synthetic` as a video. Squares at the bottom of each frame show its number in binary, the
// lowest bit first.
function film(name, length, rate, ...options) {
  const file = join(folder, name);
  const input = ["-f", "rawvideo", "-pix_fmt", "gray", "-s", "160x120", "-r", String(rate), "-i", "-"];
  const raw = Buffer.concat(Array.from({ length }, (_, index) => numbered(index + 1)));
  const { status, stderr } = spawnSync("ffmpeg", ["-v", "error", ...input, "-pix_fmt", "yuv420p", ...options, "-y", file], { input: raw, encoding: "utf8" });
  return status === 0 ? file : (console.log(`skipped: page: ${name}: ${stderr.trim().split("\n").at(-1)}`), null);
}

function numbered(number) {
  const { width, height } = SYNTHETIC;
  const frame = Buffer.from(syntheticFrame((number - 1) % SYNTHETIC.length));
  for (let at = 0; at < SIDE * SIDE * 8; at++) {
    const [x, y] = [at % (SIDE * 8), height - 1 - Math.floor(at / (SIDE * 8))];
    frame[y * width + x] = (number >> Math.floor(x / SIDE)) & 1 ? 255 : 0;
  }
  return frame;
}

/** Script that decodes the frame number from the squares in the picture. */
const CODE = `(() => {
  const stage = document.getElementById("stage");
  const scale = stage.width / ${SYNTHETIC.width};
  const bright = (bit) => stage.getContext("2d").getImageData((bit + 0.5) * ${SIDE} * scale, stage.height - 4 * scale, 1, 1).data[0] > 127;
  return Array.from({ length: 8 }, (_, bit) => bright(bit) << bit).reduce((sum, one) => sum + one);
})()`;

// Opens a video and waits until the page says "frame 1 of `length`". The default accepts any length, because the page
// only estimates it until all frames are decoded.
async function open(page, file, length = "\\d+") {
  await choose(page, file);
  await page.until(`document.getElementById("name").textContent === ${JSON.stringify(basename(file))} && /^frame 1 of ${length}, 0:00.0$/.test(document.getElementById("place").value)`);
}

async function lockFirst(page) {
  await dragBox(page, { x: 36, y: 24, width: 24, height: 28 });
  await page.until(`document.getElementById("track").textContent.includes("--init ${BOX} ")`);
}

const expected = (file, method, ...options) => lines(host("track", file, "--method", method, ...options, "--json").stdout).map((line) => JSON.parse(line));

/** Moves the slider's head from one frame to another, in a video of `length` frames. */
async function scrub(page, from, to, length, how = "drag") {
  const [left, top, width, height] = await page.value(`(() => {
    const slider = document.getElementById("timeline");
    slider.scrollIntoView({ block: "center" });
    const { left, top, width, height } = slider.getBoundingClientRect();
    return [left, top, width, height];
  })()`);
  const at = (frame) => [left + 8 + ((width - 16) * (frame - 0.5)) / length, top + height / 2];
  await page[how](at(from), at(to));
  await page.until(`${NUMBER} > 0`);
  await settled(page);
}

// Videos that play too fast for a slow machine: where Chromium skips a picture, the page must seek back to it.
const FILMS = [
  ["vp8.webm", 240, 60, "-c:v", "libvpx", "-b:v", "4M"],
  ["vp9.webm", 60, 25, "-c:v", "libvpx-vp9", "-b:v", "1M", "-deadline", "realtime", "-cpu-used", "8"],
  ["b-frames.mp4", 120, 30, "-c:v", "libx264", "-bf", "3"],
  // The frames have uneven intervals.
  ["uneven.webm", 120, 30, "-vf", "select='not(eq(mod(n,7),3)+eq(mod(n,7),4))'", "-fps_mode", "vfr", "-c:v", "libvpx", "-b:v", "2M"],
];
for (const [name, length, rate, ...options] of FILMS) {
  onPage(`no frame of ${name} is lost, and the answers are those of host-sim`, async (page, context) => {
    const file = film(name, length, rate, ...options);
    if (file === null) {
      context.skip("ffmpeg does not make it");
      return;
    }
    const robust = expected(file, "robust", "--init", BOX);
    await open(page, file);
    await lockFirst(page);
    for (const [method, ...of] of [["robust"], ["paper", "--config", "camera"]]) {
      await page.select("method", method);
      await followed(page);
      const found = await answers(page);
      assert.deepEqual(found.map(({ frame }) => frame), robust.map(({ frame }) => frame));
      same(found, expected(file, method, "--init", BOX, ...of), method);
      await replays(page, robust.length - 1);
    }
    await page.select("method", "robust");
    await followed(page);
    assert.deepEqual(await boxes(page), lines(host("track", file, "--init", BOX, "--format", "csv").stdout));
  });
}

onPage("trackers that are slower than the video make it wait", async (page, context) => {
  const file = film("slow.webm", 60, 60, "-c:v", "libvpx", "-b:v", "2M");
  if (file === null) {
    context.skip("no ffmpeg that makes WebM");
    return;
  }
  await open(page, file, 60);
  await lockFirst(page);
  await followed(page);
  same(await answers(page), expected(file, "robust", "--init", BOX), "robust");
}, { prepare: `const { postMessage } = Worker.prototype;
  Worker.prototype.postMessage = function (...of) { setTimeout(() => postMessage.apply(this, of), ${DELAY}); };` });

for (const [how, width, scheme] of [["drag", 1280, "light"], ["swipe", 390, "dark"]]) {
  onPage(`the slider: any frame is looked at and corrected, ${how} at ${width} pixels, ${scheme}`, async (page, context) => {
    const file = film(`slider-${width}.webm`, 200, 25, "-c:v", "libvpx", "-b:v", "2M");
    if (file === null) {
      context.skip("no ffmpeg that makes WebM");
      return;
    }
    await open(page, file, 200);
    await page.click("#plays");
    await lockFirst(page);
    await scrub(page, 1, 40, 200, how);
    const back = await page.value(NUMBER);
    assert.ok(Math.abs(back - 40) <= 1, `frame ${back}`);
    assert.equal(await page.value(CODE), back);
    const robust = expected(file, "robust", "--init", BOX);
    await page.until(`document.getElementById("stage").ariaLabel.includes(" ${robust[back - 1].state}: ")`);
    await scrub(page, back, 160, 200, how);
    const ahead = await page.value(NUMBER);
    assert.equal(await page.value(CODE), ahead);
    // A target added in an earlier frame is tracked from there; the first target still has one answer for each frame.
    await scrub(page, ahead, 50, 200, how);
    const place = await page.value(NUMBER);
    await page.click("#add");
    await dragBox(page, { x: 100, y: 60, width: 30, height: 30 }, how);
    await page.until(`document.getElementById("track").textContent.includes("--init target2=100,60,30,30@${place}")`);
    await scrub(page, place, 70, 200, how);
    const corrected = await page.value(NUMBER);
    await page.click("#targets li:first-child input[type=radio]");
    await dragBox(page, { x: 120, y: 20, width: 32, height: 30 }, how);
    await page.until(`!document.getElementById("asked").hidden`);
    await page.click("#correct");
    await page.until(`document.getElementById("track").textContent.includes("--init target1=120,20,32,30@${corrected}")`);
    await followed(page);
    const inits = ["--init", `target1=${BOX}`, "--init", `target1=120,20,32,30@${corrected}`, "--init", `target2=100,60,30,30@${place}`];
    assert.deepEqual(await answers(page), expected(file, "robust", ...inits));
    // A click on an event in the list goes to the frame of the correction.
    await page.value(`[...document.querySelectorAll("#events button")].find(({ textContent }) => textContent.includes("corrected at")).click()`);
    await page.until(`${NUMBER} === ${corrected}`);
    await settled(page);
    assert.equal(await page.value(CODE), corrected);
    await page.value(`document.querySelector("#timeline input").focus()`);
    await page.key("ArrowRight");
    await page.until(`${NUMBER} === ${corrected + 1}`);
    const time = (corrected / 25).toFixed(1);
    assert.equal(await page.value(`document.querySelector("#timeline input").getAttribute("aria-valuetext")`), `0:0${time} (frame ${corrected + 1})`);
    assert.equal(await page.value(`document.documentElement.scrollWidth <= innerWidth`), true);
    await shoot(page, `slider-${scheme}`, width);
  }, { width, height: 844, scheme });
}

onPage("the built-in recording: its slider, and events without times", async (page) => {
  await followed(page);
  const events = await page.value(`[...document.querySelectorAll("#events li")].map(({ textContent }) => textContent)`);
  assert.equal(events[0], "locked at frame 1");
  assert.ok(events.some((text) => /^uncertain at frame \d+$/.test(text)), events.join());
  await page.key("[");
  await page.until(`${NUMBER} < 300`);
  assert.match(await page.value(`document.querySelector("#events [aria-current]").textContent`), new RegExp(`frame ${await page.value(NUMBER)}$`));
  await scrub(page, 30, 100, 300);
  assert.equal(await page.value(NUMBER), 100);
});

onPage("a codec that the browser lacks is named, and a damaged file is called damaged", async (page) => {
  await page.until(`${NUMBER} > 3`);
  const broken = join(folder, "broken.mp4");
  writeFileSync(broken, Buffer.alloc(5000, "not a video "));
  const told = async (file, start) => {
    await choose(page, file);
    await page.until(`document.getElementById("said").textContent.startsWith(${JSON.stringify(start)})`);
    assert.equal(await page.text("name"), "street");
    assert.ok((await page.text("said")).startsWith(start));
  };
  await told(broken, "broken.mp4 is damaged or no video: expected MP4, WebM");
  const hevc = film("phone.mp4", 10, 30, "-c:v", "libx265", "-x265-params", "log-level=error");
  if (hevc !== null && (await page.value(`document.createElement("video").canPlayType('video/mp4; codecs="hvc1.1.6.L93.B0"')`)) === "") {
    await told(hevc, "phone.mp4 is HEVC (H.265), which this browser does not play: host-sim view phone.mp4 does, or a current Safari or Edge.");
  }
  const avi = film("old.avi", 10, 30, "-c:v", "mpeg4");
  if (avi !== null) {
    await told(avi, "old.avi is AVI, which this browser does not play: host-sim view old.avi does.");
  }
  const cut = film("cut.webm", 60, 30, "-c:v", "libvpx", "-b:v", "2M");
  if (cut !== null) {
    writeFileSync(cut, readFileSync(cut).subarray(0, 300));
    await told(cut, "cut.webm is damaged");
  }
});
