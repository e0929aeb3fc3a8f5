// The stand-alone page in a headless Chromium: its answers equal host-sim's, and each failure at the start has one
// clear message.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { copyFileSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { pathToFileURL } from "node:url";
import { Browser } from "./browser.mjs";
import { BELOW, CHOSEN_IS_SEEN, MENU_IS_SEEN, HOST_SIM } from "./library.mjs";
import {
  FRAMES, NUMBER, PRESSED, STARTED, address, answers, boxes, browser, choose, columns, downloaded, dragBox, folder, followed, host, lines, onPage, pausedAt, replays, same,
  settled, shoot, why,
} from "./open-page.mjs";

const told = (...words) => lines(host(...words, "--json").stdout).map((line) => JSON.parse(line));

onPage("the built-in recording moves at once, and its answers are those of host-sim", async (page) => {
  await page.until(`${NUMBER} > 5`);
  for (const [method, ...options] of [["robust"], ["paper", "--config", "camera"]]) {
    await page.select("method", method);
    await followed(page);
    const expected = told("track", "street", "--method", method, ...options);
    const found = await answers(page);
    assert.equal(found.length, expected.length);
    same(found, expected, method);
    const csv = lines(host("track", "street", "--method", method, ...options, "--format", "csv").stdout);
    assert.deepEqual((await boxes(page)).map(columns(method)), csv.map(columns(method)));
    const [program, ...words] = (await page.text("track")).split(" ");
    assert.equal(program, "host-sim");
    assert.deepEqual(told(...words), expected);
    await replays(page, FRAMES);
  }
});

onPage("a camera: a box is dragged, 100 frames are followed, and host-sim agrees on the very pixels", async (page) => {
  await page.click("#camera");
  await page.until(`document.getElementById("name").textContent === "camera" && document.getElementById("about").textContent.startsWith("160x120") && ${NUMBER} > 0`);
  // The picture is held while the mouse is down, so that the target stays at this position.
  await dragBox(page, { x: 60, y: 50, width: 40, height: 40 });
  await page.until(`document.getElementById("track").textContent.includes("--init 60,50,40,40")`);
  const first = Number(/@(\d+)/.exec(await page.text("track"))?.[1] ?? 1);
  await page.until(`${NUMBER} >= ${first + FRAMES + 20}`);
  // A change of the window's size during tracking affects only the picture.
  await page.size(900, 700);
  await pausedAt(page, first + FRAMES + 30);
  await shoot(page, "camera", 900);
  const found = await answers(page);
  assert.ok(found.length >= FRAMES, `${found.length} answers`);
  assert.deepEqual(found.map(({ frame }) => frame), found.map((_, at) => first + at));
  assert.deepEqual(found[0].box, { x: 60, y: 50, width: 40, height: 40 });
  // A target corrected in an earlier frame is tracked from there to the newest frame.
  await page.key("ArrowLeft", { shift: true });
  await settled(page);
  const corrected = await page.value(NUMBER);
  await page.value(`document.getElementById("stage").focus()`);
  for (const key of ["Enter", "ArrowRight", "Enter"]) {
    await page.key(key);
  }
  await page.until(`document.getElementById("track").textContent.includes("@${corrected}")`);
  await settled(page);
  assert.ok((await answers(page)).at(-1).frame >= found.at(-1).frame);
  await replays(page, FRAMES);
  // Marks the target as gone: its earlier answers stay, even for frames that the page no longer keeps. Then opens the
  // built-in recording.
  await page.click("#newest");
  await page.until(`${NUMBER} >= ${first + 800}`);
  await page.click("#gone");
  await page.until(`document.querySelector("#targets .now").textContent === "gone"`);
  assert.equal((await answers(page))[0].frame, first);
  await page.click("#built-in");
  await page.click("#camera");
  await page.click("#built-in");
  await page.until(`document.getElementById("name").textContent === "street" && ${NUMBER} > 1`);
  await followed(page);
  assert.deepEqual(await answers(page), told("track", "street"));
});

onPage("a page of 390 pixels, by keys alone, with several targets", async (page) => {
  await pausedAt(page, 4);
  await page.value(`document.getElementById("add").focus()`);
  await page.key("Enter");
  assert.equal(await page.value(`document.activeElement.id`), "stage");
  await page.click("#plays");
  const keys = [["Enter"], ["ArrowRight"], ["ArrowDown", { alt: true }], ["ArrowLeft", { shift: true }], ["ArrowDown", { shift: true, alt: true }], ["Enter"]];
  for (const [key, held] of keys) {
    await page.key(key, held);
  }
  await page.until(`document.getElementById("track").textContent.includes("target2=")`);
  await page.click("#add");
  await dragBox(page, { x: 40, y: 80, width: 20, height: 20 }, "swipe");
  await page.until(`document.getElementById("track").textContent.includes("target3=40,80,20,20@")`);
  const words = (await page.text("track")).split(" ").slice(1);
  const [, x, y, width, height] = words.join(" ").match(/--init target2=(\d+),(\d+),(\d+),(\d+)@\d+/).map(Number);
  assert.deepEqual([x, y, width, height], [125, 91, 75, 61]);
  await followed(page);
  assert.deepEqual(await answers(page), told(...words));
  assert.equal(await page.value(`document.documentElement.scrollWidth <= innerWidth && ${MENU_IS_SEEN}`), true);
  assert.ok((await page.value(`document.getElementById("stage").getBoundingClientRect().top + scrollY`)) < 844 / 4, "text above the picture");
  await page.value(`scrollTo(0, document.documentElement.scrollHeight)`);
  await page.click("#length");
  assert.equal(await page.value(`document.getElementById("stage").getBoundingClientRect().top > -1`), true, "the picture is in sight");
  await page.key("Escape");
  await shoot(page, "narrow", 390);
}, { width: 390, height: 844 });

onPage("other settings follow the targets anew, and what is undone is followed as before", async (page) => {
  await page.click("#plays");
  await pausedAt(page, 20);
  const next = await page.value(NUMBER);
  await page.click("#trail");
  await dragBox(page, { x: 100, y: 160, width: 30, height: 30 });
  await page.until(`!document.getElementById("asked").hidden`);
  await page.click("#correct");
  await page.until(`document.getElementById("track").textContent.includes("100,160,30,30@${next}")`);
  await page.select("reach", "6");
  await page.select("sweep", "0");
  await page.click("#refiner");
  await followed(page);
  const command = await page.text("track");
  assert.match(command, /--init 268,101,39,14 --init 100,160,30,30@\d+ --method robust --set reach=6 --set sweep=0 --set refiner=off$/);
  assert.deepEqual(await answers(page), told(...command.split(" ").slice(1)));
  await page.click("#undo");
  await followed(page);
  assert.deepEqual(await answers(page), told(...(await page.text("track")).split(" ").slice(1)));
  assert.doesNotMatch(await page.text("track"), /@/);
});

onPage("a box of 0x0, one that is refused, a removed target", async (page) => {
  await pausedAt(page, 4);
  await page.click("#plays");
  await page.select("method", "paper");
  await page.until(`document.getElementById("track").textContent.includes("--method paper")`);
  const before = await page.text("track");
  await page.click("#add");
  await dragBox(page, { x: 2, y: 2, width: 310, height: 230 });
  await page.until(`document.getElementById("said").textContent.startsWith("Paper tracker (SMR, 2013) did not lock: ")`);
  await page.until(`document.getElementById("track").textContent === ${JSON.stringify(before)}`);
  await dragBox(page, { x: 80, y: 160, width: 20, height: 0 });
  await page.until(`document.getElementById("said").textContent === "The box has no pixels: drag from one corner to the other."`);
  await page.click("#targets button");
  await page.until(`document.querySelectorAll("#targets li").length === 0 && document.querySelectorAll("#files button:disabled").length === 4`);
});

onPage("all curves of four targets stand beside the picture in a window of 1280x900", async (page) => {
  await pausedAt(page, 4);
  await page.click("#plays");
  for (const left of [20, 60, 100]) {
    await page.click("#add");
    await dragBox(page, { x: left, y: 160, width: 30, height: 30 });
    await page.until(`document.getElementById("track").textContent.includes("${left},160,30,30@")`);
  }
  await page.until(CHOSEN_IS_SEEN);
  await page.value(`scrollTo(0, 0)`);
  for (const choice of ["tracker", "movement"]) {
    await page.select("curve", choice);
    await page.until(`document.querySelector("#curves b").textContent === "${choice === "tracker" ? "States" : "Centre x →"}"`);
    assert.deepEqual(await page.value(BELOW), [], choice);
  }
});

onPage("a length in the picture: the CSV has metres as that of host-sim, and the length comes back with its source", async (page) => {
  await pausedAt(page, 40);
  assert.deepEqual(await page.value(BELOW), [], "the curves of the tracker stand beside the picture");
  await page.select("curve", "movement");
  await page.until(`[...document.querySelectorAll("#curves .panel b")].map((title) => title.textContent).join() === "Centre x →,Centre y ↓,Speed: no times"`);
  await page.click("#length");
  await dragBox(page, { x: 30, y: 200, width: 250, height: -20 });
  await page.until(`document.activeElement.id === "metres"`);
  await page.value(`document.getElementById("metres").value = "7,5"`);
  await page.key("Enter");
  await page.until(`/--pixels-per-metre 33.4398$/.test(document.getElementById("track").textContent)`);
  await page.until(`/^[\\d.]+ m$/.test(document.querySelector("#curves .value").textContent.trim())`);
  assert.deepEqual(await page.value(BELOW), [], "the curves of the movement stand beside the picture");
  await shoot(page, "movement", 1280);
  await followed(page);
  assert.deepEqual(await boxes(page), lines(host(...(await page.text("track")).split(" ").slice(1)).stdout));
  await page.click("#camera");
  await page.until(`document.getElementById("name").textContent === "camera" && document.getElementById("scale").textContent === ""`);
  await page.click("#built-in");
  await page.until(`document.getElementById("scale").textContent === "1 m = 33.44 pixels"`);
  await page.click("#length");
  await page.until(`document.getElementById("metres").value === "7.5" && !document.getElementById("dropLength").disabled`);
  await page.click("#dropLength");
  await page.until(`document.getElementById("measured").hidden && document.getElementById("scale").textContent === ""`);
  assert.doesNotMatch(await page.text("track"), /metre/);
  // The step that is undone is that of the length: the box stays.
  await page.click("#undo");
  await page.until(`document.getElementById("scale").textContent === "1 m = 33.44 pixels"`);
  await page.click("#redo");
  await page.until(`document.getElementById("scale").textContent === ""`);
  assert.match(await page.text("track"), /--init /);
});

onPage("work is not lost: the page asks before it is left, and a source that is opened again has its boxes", async (page) => {
  await pausedAt(page, 4);
  await page.click("#plays");
  const loaded = page.next("Page.loadEventFired");
  await page.call("Page.reload");
  await loaded;
  await page.until(STARTED);
  await pausedAt(page, 4);
  await page.click("#plays");
  await page.click("#add");
  await dragBox(page, { x: 40, y: 80, width: 20, height: 20 });
  await page.until(`document.getElementById("track").textContent.includes("target2=40,80,20,20@")`);
  const asked = page.next("Page.javascriptDialogOpening");
  await page.call("Page.reload");
  assert.equal((await asked).type, "beforeunload");
  await page.call("Page.handleJavaScriptDialog", { accept: false });
  await page.click("#camera");
  await page.until(`document.getElementById("name").textContent === "camera"`);
  await page.click("#built-in");
  await page.until(`document.getElementById("track").textContent.includes("target2=40,80,20,20@")`);
});

onPage("truth by hand is kept in a session, which host-sim view and the page open again", async (page) => {
  await pausedAt(page, 4);
  await page.click("#plays");
  await page.click("#add");
  await page.key("Home");
  await page.until(`${NUMBER} === 1`);
  await dragBox(page, { x: 40, y: 80, width: 20, height: 20 });
  await page.until(`document.getElementById("track").textContent.includes("target2=40,80,20,20")`);
  await followed(page);
  await page.key("Home");
  await page.key("ArrowRight", { shift: true });
  await page.until(`${NUMBER} === 11`);
  await dragBox(page, { x: 64, y: 104, width: 20, height: 20 });
  await page.until(`!document.getElementById("asked").hidden || document.getElementById("track").textContent.includes("@11")`);
  if (await page.value(`!document.getElementById("asked").hidden`)) {
    await page.click("#correct");
  }
  await page.until(`document.getElementById("track").textContent.includes("target2=64,104,20,20@11")`);
  await page.key("b");
  await page.key("ArrowRight", { shift: true });
  await page.until(`${NUMBER} === 21`);
  // Behind the last box, no line is shown that the key could change.
  await page.until(`document.getElementById("line").disabled`);
  await page.key("b");
  await page.until(`/^Draw a box in an earlier frame and one in a later frame/.test(document.getElementById("said").textContent)`);
  await page.key("h");
  await page.until(`document.querySelector("#targets li:last-child .now").textContent === "hidden"`);
  await followed(page);
  await page.until(`/^[1-9]\\d* % checked$/.test(document.getElementById("share").textContent)`);
  const share = await page.text("share");
  const saved = join(folder, "street.smr.json");
  await page.value(`document.getElementById("export").open = true`);
  copyFileSync(await downloaded(page, "Session", ".smr.json"), saved);
  assert.equal(await page.value(`document.getElementById("export").open`), false, "the menu closes when a file is made");
  const work = JSON.parse(readFileSync(saved, "utf8"));
  const [, marked] = work.targets;
  assert.deepEqual(marked.locks.map(({ frame, box, by_hand: byHand }) => [frame, box, byHand]), [[1, [40, 80, 20, 20], true], [11, [64, 104, 20, 20], false]]);
  assert.deepEqual([marked.hidden[0][0], work.recording, work.method], [21, "street", "robust"]);
  assert.ok(marked.checked.length > 0);

  // What the user says, on a line and hidden, stands in the files of the page and of host-sim.
  const clip = join(folder, "street.y4m");
  assert.equal(host("convert", "street", "-o", clip).status, 0);
  copyFileSync(saved, `${clip}.smr.json`);
  const untimed = ({ time, ...answer }) => answer;
  const found = (await answers(page)).map(untimed);
  assert.deepEqual(found, told("track", clip).map(untimed));
  const second = found.filter(({ target }) => target === "target2");
  assert.deepEqual([second[5].fine, second[25].state], [{ x: 52, y: 92, width: 20, height: 20 }, "lost"]);

  // The page opens it again, after it was loaded anew.
  const asked = page.next("Page.javascriptDialogOpening");
  const loaded = page.next("Page.loadEventFired");
  await page.call("Page.reload");
  await asked;
  await page.call("Page.handleJavaScriptDialog", { accept: true });
  await loaded;
  await page.until(STARTED);
  // What plays is looked at.
  await pausedAt(page, 4);
  await choose(page, saved);
  await page.until(`document.getElementById("track").textContent.includes("target2=64,104,20,20@11")`);
  await page.click("#targets li:last-child input");
  // The frame that is shown is looked at, too.
  const shares = [0, 1].map((more) => `${parseInt(share) + more} % checked`);
  await page.until(`${JSON.stringify(shares)}.includes(document.getElementById("share").textContent)`);
  // It replaced what was there, which can be undone.
  await page.click("#undo");
  await page.until(`!document.getElementById("track").textContent.includes("target2")`);
  await page.click("#redo");
  await page.until(`document.getElementById("track").textContent.includes("target2=64,104,20,20@11")`);

  // So does host-sim, for which the user looks at the boxes again: they may differ.
  const viewer = spawn(HOST_SIM, ["view", "street", "--session", saved, "--no-open", "--json"]);
  try {
    const said = new Promise((resolve) => viewer.stderr.once("data", (text) => resolve(String(text))));
    const { address } = JSON.parse(String(await new Promise((resolve) => viewer.stdout.once("data", resolve))));
    const { targets } = await (await fetch(`${address}source`)).json();
    assert.match(await said, /look at them again/);
    const unchecked = ({ checked, ...target }) => target;
    const plain = ({ by_hand: byHand, ...lock }) => (byHand ? { ...lock, by_hand: true } : lock);
    assert.deepEqual(targets.map(unchecked), work.targets.map(({ hidden, locks, ...rest }) => unchecked({ ...rest, locks: locks.map(plain), ...(hidden.length > 0 ? { hidden } : {}) })));
  } finally {
    viewer.kill();
  }
});

onPage("a dropped file that is no video says where it belongs", async (page) => {
  await page.value(`{
    const data = new DataTransfer();
    data.items.add(new File(["frame,x,y,width,height\\n1,2,3,4,5\\n"], "boxes.csv", { type: "text/csv" }));
    document.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
  }`);
  await page.until(`document.getElementById("said").textContent === "boxes.csv is text, not a video: boxes are read by host-sim view VIDEO --boxes boxes.csv"`);
  assert.equal(await page.text("name"), "street");
});

onPage("without WebAssembly there is one clear line", async (page) => {
  await page.until(`document.getElementById("said").textContent.startsWith("This browser has no WebAssembly")`);
  assert.equal(await page.value(`document.getElementById("stage").offsetHeight`), 0);
}, { prepare: "delete globalThis.WebAssembly;" });

onPage("a worker that cannot run is said to be", async (page) => {
  await page.until(`document.getElementById("said").textContent.startsWith("The trackers do not run here: ")`);
  page.errors.length = 0; // the worker's own
}, { prepare: `{ const Real = Worker; self.Worker = class extends Real { constructor() { super(URL.createObjectURL(new Blob(["throw new Error(1)"]))); } }; }` });

for (const scheme of ["light", "dark"]) {
  onPage(`it is seen in the ${scheme}, in the colors of host-sim's pages`, async (page) => {
    await page.until(`${NUMBER} > 40`);
    await shoot(page, scheme, 1280);
    const report = join(folder, `${scheme}.html`);
    assert.equal(host("report", "synthetic", "--frames", "1..3", "--method", "robust,paper", "--out", report).status, 0);
    const theirs = await browser.page(pathToFileURL(report).href, { scheme });
    assert.deepEqual(await page.value(COLORS), await theirs.value(COLORS.replace("look-robust", "look-0").replace("look-paper", "look-1")));
    await theirs.close();
  }, { scheme });
}

const COLORS = `["look-robust", "look-paper"].map((name) => {
  const node = document.body.appendChild(document.createElement("i"));
  node.className = name;
  const style = getComputedStyle(node);
  const colors = ["--line", "--tracking", "--leaving", "--lost", "--paper", "--ink", "--panel"].map((name) => {
    node.style.color = \`var(\${name})\`;
    return style.color;
  });
  const told = [style.getPropertyValue("--dashes").trim(), ...colors];
  node.remove();
  return told;
})`;

test("a refused camera has one clear line, and the built-in recording stays", { skip: why ?? false }, async () => {
  const other = new Browser(["--use-fake-device-for-media-stream", "--deny-permission-prompts"]);
  try {
    const page = await other.page(address);
    await page.until(STARTED);
    await page.click("#camera");
    await page.until(`document.getElementById("said").textContent.startsWith("The camera was refused: allow it")`);
    await page.until(`${NUMBER} > 10`);
    assert.deepEqual([await page.text("name"), page.errors, page.requests], ["street", [], []]);
  } finally {
    await other.close();
  }
});
