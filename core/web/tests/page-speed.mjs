// Measures the stand-alone page's processor time and memory: a camera of 640x480 at 60 frames a second, two targets.
//
//   SMR_HOST_SIM=... node core/web/tests/page-speed.mjs [FRAMES]          default: 3000

import { mkdtempSync, openSync, readFileSync, readdirSync, rmSync, writeSync, closeSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "./browser.mjs";
import { PACKAGE, SYNTHETIC, syntheticFrame } from "./library.mjs";

const FACTOR = 4; // of the recording `synthetic`
const LENGTH = 160; // until then the target is in the picture
const FRAMES = Number(process.argv[2] ?? 3000);
const FIRST = 1000;

function writeCamera(file) {
  const [width, height] = [FACTOR * SYNTHETIC.width, FACTOR * SYNTHETIC.height];
  const out = openSync(file, "w");
  writeSync(out, `YUV4MPEG2 W${width} H${height} F60:1 Ip C420jpeg\n`);
  const colors = Buffer.alloc((width * height) / 2, 128);
  // Plays forward and backward, so that the video repeats without a jump.
  const order = [...Array(LENGTH).keys()];
  for (const index of [...order, ...order.reverse()]) {
    const gray = syntheticFrame(index);
    const luma = Buffer.alloc(width * height);
    for (let y = 0; y < height; y++) {
      const row = Math.floor(y / FACTOR) * SYNTHETIC.width;
      for (let x = 0; x < width; x++) {
        luma[y * width + x] = 16 + (gray[row + Math.floor(x / FACTOR)] * 219) / 255;
      }
    }
    writeSync(out, Buffer.concat([Buffer.from("FRAME\n"), luma, colors]));
  }
  closeSync(out);
}

// Returns the ids of a process and of all its descendants. Some of these processes may already have ended.
function family(parent) {
  const parentOf = (pid) => Number(tried(() => fields(`/proc/${pid}/stat`)[1]));
  const all = readdirSync("/proc").filter((name) => /^\d+$/.test(name)).map(Number);
  const below = (of) => all.filter((pid) => parentOf(pid) === of).flatMap((pid) => [pid, ...below(pid)]);
  return [parent, ...below(parent)];
}

const tried = (read) => {
  try {
    return read();
  } catch {
    return undefined;
  }
};
// Returns the fields of a `stat` file in /proc, after the name of the process.
const fields = (file) => readFileSync(file, "utf8").split(") ").at(-1).split(" ");
const isRenderer = (pid) => tried(() => readFileSync(`/proc/${pid}/cmdline`, "utf8").includes("--type=renderer")) ?? false;

/** Returns the memory, in megabytes, of all processes that run pages. */
function memory(parent) {
  const kilobytes = family(parent).filter(isRenderer).map((pid) => Number(readFileSync(`/proc/${pid}/status`, "utf8").match(/VmRSS:\s+(\d+)/)?.[1] ?? 0));
  return Math.round(kilobytes.reduce((sum, one) => sum + one, 0) / 1024);
}

/** Returns processor times so far in ms: `page` (main threads of pages), `worker` (web workers), `all` (everything). */
function processor(parent) {
  const sum = { page: 0, worker: 0, all: 0 };
  for (const pid of family(parent)) {
    for (const thread of tried(() => readdirSync(`/proc/${pid}/task`)) ?? []) {
      const [, , , , , , , , , , , user, system] = tried(() => fields(`/proc/${pid}/task/${thread}/stat`)) ?? [];
      const spent = 10 * (Number(user ?? 0) + Number(system ?? 0));
      const name = tried(() => readFileSync(`/proc/${pid}/task/${thread}/comm`, "utf8").trim());
      sum.all += spent;
      sum.page += isRenderer(pid) && Number(thread) === pid ? spent : 0;
      sum.worker += name?.startsWith("DedicatedWorker") ? spent : 0;
    }
  }
  return sum;
}

const folder = mkdtempSync(join(tmpdir(), "smr-speed-"));
writeCamera(join(folder, "camera.y4m"));
const browser = new Browser([
  "--use-fake-ui-for-media-stream", "--use-fake-device-for-media-stream", `--use-file-for-fake-video-capture=${join(folder, "camera.y4m")}`,
]);
try {
  const page = await browser.page(pathToFileURL(join(PACKAGE, "smr.html")).href);
  const number = `Number(document.getElementById("place").value.split(" ")[1])`;
  await page.until(`${number} > 0`);
  await page.click("#camera");
  await page.until(`document.getElementById("about").textContent.startsWith("640x480")`);
  const at = (x, y) => page.value(`(() => { const { left, top, width, height } = document.getElementById("stage").getBoundingClientRect();
    return [left + ${x} * width / 640, top + ${y} * height / 480]; })()`);
  await page.drag(await at(100, 60), await at(160, 120));
  await page.until(`document.querySelectorAll("#targets li").length === 1`);
  await page.click("#add");
  await page.drag(await at(400, 200), await at(460, 260));
  await page.until(`document.querySelectorAll("#targets li").length === 2`);
  const figures = async () => ({
    frames: await page.value(number),
    load: (await page.text("load")).trim(),
    seconds: performance.now() / 1000,
    megabytes: memory(browser.process),
    processor: processor(browser.process),
  });
  const marks = [];
  for (const mark of [100, FIRST, FRAMES]) {
    await page.until(`${number} >= ${mark}`, 300);
    marks.push(await figures());
    const { frames, megabytes, load } = marks.at(-1);
    console.log(`frame ${frames}: ${megabytes} MB; ${load}`);
  }
  const [first, , last] = marks;
  const rate = (last.frames - first.frames) / (last.seconds - first.seconds);
  const spent = (of) => ((last.processor[of] - first.processor[of]) / (last.frames - first.frames)).toFixed(1);
  console.log(`${rate.toFixed(1)} frames a second were followed`);
  console.log(`processor time a frame: page ${spent("page")} ms, worker ${spent("worker")} ms, all of Chromium ${spent("all")} ms`);
  console.log(page.errors.join("\n"));
} finally {
  await browser.close();
  rmSync(folder, { recursive: true });
}
