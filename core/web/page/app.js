// The page: handles the user's actions and draws. The trackers run in the worker.

import { Camera } from "./camera.js";
import { Cards, drawScale } from "./cards.js";
import { packedModules, workerAddress } from "./data.js";
import { byId, htmlNode, inView, sample } from "./dom.js";
import { save } from "./download.js";
import { Drag } from "./drag.js";
import { clock, drawEvents, eventsOf } from "./events.js";
import { Figures } from "./figures.js";
import { Followed } from "./followed.js";
import { Follower } from "./follower.js";
import { FRAMES, chartsOf } from "./curves.js";
import { Graph } from "./graph.js";
import { drawList } from "./list.js";
import { METHODS, SETTINGS, SHORT, TITLES } from "./methods.js";
import { lookOf, palette } from "./palette.js";
import { Player } from "./player.js";
import { BUILT_IN, Recording } from "./recording.js";
import { csv, json } from "./rows.js";
import { commandLine } from "./command.js";
import { drawStage } from "./stage.js";
import { Timeline } from "./timeline.js";
import { Video } from "./video.js";
import { sceneOf } from "./view.js";

const MOST_TARGETS = 8;
const READINGS_MS = 80;
const POOR_QUALITY = 1023; // of smr.js

const settings = structuredClone(SETTINGS);
let picture = null; // the frame that is shown
let size = { width: 0, height: 0 }; // its size
let targets = [];
let chosen = null;
let ids = 0;
let number = null; // of the frame that is shown
let proposed = null; // a box that is being drawn
let version = "";
let passes = 0; // of the sources, each from a first frame on
let drawing = null;
let reading = null;
let told = { key: "", events: [] }; // what happened to the chosen target
let follower, player, graph, cards, figures, timeline, seesCurves, seesComparisons;

// ---- messages

function say(text) {
  byId("said").textContent = text;
  byId("said").hidden = text === "";
}

// ---- targets

function newTarget() {
  const target = new Followed(++ids);
  targets.push(target);
  chosen = target;
  return target;
}

async function lock(target, box, isNew) {
  const before = passes;
  const reply = await follower.ask("lock", { id: target.id, box });
  if (before !== passes || !targets.includes(target)) {
    return;
  }
  target.locked(reply.number, box, reply.locked);
  const text = METHODS.map((method) => saidOfLock(method, reply.locked[method] ?? {})).join(" ").trim();
  // A repeated lock shows no message if it succeeds.
  if (isNew || text !== "") {
    say(text);
  }
  draw();
}

function saidOfLock(method, { error, quality }) {
  if (error !== undefined) {
    return `${TITLES[method]} did not lock: ${error}.`;
  }
  return quality < POOR_QUALITY ? `${TITLES[method]} can hardly tell this from what is around it: try a box with more in it.` : "";
}

function lockByUser(box) {
  if (box.width * box.height === 0) {
    say("The box has no pixels: drag from one corner to the other.");
    return;
  }
  if (chosen === null) {
    newTarget();
  }
  chosen.planned = [];
  lock(chosen, box, true).catch((error) => say(error.message));
}

function removeTarget(target) {
  follower.ask("remove", { id: target.id });
  targets = targets.filter((one) => one !== target);
  chosen = chosen === target ? (targets.at(-1) ?? null) : chosen;
  draw();
}

function choose(target) {
  chosen = target;
  draw();
}

// ---- sources

async function use(source) {
  player.use(source);
  forget();
  await source.open?.();
}

function forget() {
  passes += 1;
  follower.ask("restart", { settings });
  [targets, chosen, ids, number] = [[], null, 0, null];
  newTarget();
}

async function useBuiltIn() {
  await use(new Recording(player.sink));
  chosen.planned = [{ number: 1, box: BUILT_IN.box }];
  say("");
  player.play(true);
}

async function useCamera() {
  say("Waiting for the camera.");
  const camera = new Camera(player.sink, byId("video"));
  await trying(camera, "Drag a box over what is to be followed.");
  if (player.source === camera) {
    player.play(true);
  }
}

async function useFile(file) {
  say(`Opening ${file.name}.`);
  await trying(new Video(player.sink, byId("video"), file), "Drag a box over what is to be followed, then play.");
}

// If the wanted source is not there, the built-in recording plays again.
async function trying(source, hint) {
  try {
    await use(source);
    say(hint);
  } catch (error) {
    await useBuiltIn();
    say(error.message);
  }
  draw();
}

function seek(to) {
  if (player.source.kind === "camera") {
    say("The earlier pictures of a camera are gone.");
    return;
  }
  player.seek(to);
}

// The event before or after the frame that is shown.
function seekEvent(way) {
  const frames = events().map(({ frame }) => frame).filter((frame) => (frame - number) * way > 0);
  if (frames.length > 0) {
    seek(way > 0 ? Math.min(...frames) : Math.max(...frames));
  }
}

// Where following stopped, if that is before the frame that is shown.
function behind() {
  const next = Math.min(...targets.map((target) => target.next ?? Infinity));
  return number !== null && next <= number ? next : null;
}

// Locks are repeated, except on a camera: its earlier pictures are gone.
function restarted() {
  passes += 1;
  follower.ask("restart", { settings });
  targets.forEach((target) => target.restart(player.source.kind !== "camera"));
  number = null;
}

// ---- frames

function sent(at) {
  for (const target of targets) {
    const box = target.due(at);
    if (box !== null) {
      lock(target, box, false);
    }
  }
}

function answered(reply) {
  show(reply);
  if (reply.isOther && targets.some((target) => target.isFollowed)) {
    targets.forEach((target) => target.restart(false));
    say("The frames have another size now: lock again.");
  }
  const answers = new Map(reply.answers);
  for (const target of targets) {
    const found = answers.get(target.id);
    found === undefined ? target.showAt(reply.number) : target.answered(reply.number, found);
  }
  number = reply.number;
  draw();
}

function show(reply) {
  picture?.close();
  picture = reply.picture;
  if (size.width !== reply.width || size.height !== reply.height) {
    size = { width: reply.width, height: reply.height };
    byId("stage").style.setProperty("--ratio", size.width / size.height);
  }
}

// ---- drawing

// Draws once for each picture of the screen, however much has changed. Numbers and curves change too quickly to read,
// so they are drawn less often.
function draw() {
  drawing ??= requestAnimationFrame(() => {
    drawing = null;
    if (number !== null) {
      drawStage(byId("stage"), sceneOf({ picture, size, targets, chosen, on: settings.on, box: proposed, number }));
    }
    reading ??= setTimeout(() => {
      reading = null;
      drawReadings();
    }, READINGS_MS);
  });
}

function drawReadings() {
  const { on } = settings;
  if (seesCurves()) {
    const last = Math.max(FRAMES, chosen?.last ?? 0);
    graph.draw({ charts: chartsOf(byId("curves"), chosen, on), first: last - FRAMES + 1, last, now: number, timeOf });
  }
  if (seesComparisons()) {
    cards.draw(chosen, on);
  }
  figures.draw(chosen, on);
  drawList(byId("targets"), { targets, chosen, choose, remove: removeTarget });
  drawEvents(byId("events"), events(), { timeOf, goTo: seek, chosen: number });
  drawTimeline();
  drawControls();
}

const timeOf = (frame) => player.source.timeOf(frame);

// A lock is one of both trackers; all else is of one of them.
function events() {
  const histories = METHODS.filter((method) => settings.on[method] && chosen?.histories[method]).map((method) => [method, chosen.histories[method]]);
  const key = [passes, chosen?.id, chosen?.last, chosen?.locks.length, ...histories.map(([method]) => method)].join();
  if (told.key !== key) {
    const locks = chosen?.locks ?? [];
    const isLock = ({ kind }) => kind === "locked" || kind === "corrected";
    const ofMethod = ([method, history]) => eventsOf(history.states(), locks).filter((one) => !isLock(one)).map((one) => ({ ...one, name: SHORT[method] }));
    told = { key, events: [...eventsOf([], locks), ...histories.flatMap(ofMethod)].sort((one, other) => one.frame - other.frame) };
  }
  return told.events;
}

function drawTimeline() {
  const { length } = player.source;
  byId("timeline").hidden = player.source.kind === "camera";
  if (number === null || byId("timeline").hidden) {
    return;
  }
  const followed = targets.map(({ last }) => last ?? 0);
  const last = Math.max(length ?? 0, number, ...followed);
  timeline.draw({ first: 1, last, frame: number, followed: chosen?.last ?? null, strips: targets.flatMap(stripsOf), marks: events(), timeOf });
}

// Each tracker of the chosen target, and the first one of the others.
function stripsOf(target) {
  const isChosen = target === chosen;
  const methods = METHODS.filter((method) => settings.on[method]).slice(0, isChosen ? METHODS.length : 1);
  return methods.map((method) => ({
    color: isChosen ? lookOf(method).onPage : palette().faint, isChosen, states: (frame) => target.histories[method]?.stateAt(frame),
  }));
}

function drawControls() {
  const { source, isPlaying, dropped } = player;
  byId("play").textContent = isPlaying ? "❚❚" : "▶";
  byId("play").setAttribute("aria-label", isPlaying ? "Pause" : "Play");
  for (const [id, kind] of [["camera", "camera"], ["choose", "video"], ["built-in", "recording"]]) {
    byId(id).setAttribute("aria-pressed", source.kind === kind);
  }
  const isCamera = source.kind === "camera";
  byId("speed").disabled = byId("repeat").disabled = byId("again").disabled = isCamera;
  byId("add").disabled = targets.length >= MOST_TARGETS;
  const of = source.length === null ? "" : ` of ${source.length}`;
  const time = number === null ? null : timeOf(number);
  byId("place").value = number === null ? "" : `frame ${number}${of}${time === null ? "" : `, ${clock(time)}`}`;
  const named = number === null ? "" : `${source.name}, ${size.width}x${size.height} pixels. `;
  const next = behind();
  const stopped = next === null ? "" : ` This frame is not followed yet: Play goes on from frame ${next}.`;
  byId("load").textContent = `${named}${dropped === 0 ? "No frame was dropped." : `${dropped} frames were dropped: this machine was behind.`}${stopped}`;
  const states = METHODS.map((method) => chosen?.now[method]?.state && `${SHORT[method]}: ${chosen.now[method].state}`).filter(Boolean);
  byId("stage").setAttribute("aria-label", ["The frame with its boxes", ...states].join(", "));
  drawCommand();
}

function drawCommand() {
  const method = byId("of").value;
  const locked = targets.filter(({ locks }) => locks.length > 0);
  const source = { ...player.source, ...size };
  const text = locked.length === 0 ? "" : commandLine(method, settings, locked, source);
  if (byId("command").textContent !== text) {
    byId("command").textContent = text;
  }
}

// ---- downloads

const FILES = {
  csv: (method, named) => save(`boxes-${method}.csv`, csv(named, timeOf)),
  json: (method, named) => save(`boxes-${method}.jsonl`, json(named, method, settings, version, timeOf)),
  record: async (method) => {
    const { bytes } = await follower.ask("record", { id: chosen?.id, method });
    bytes === null ? say(`${TITLES[method]} has no flight record: lock it on a target first.`) : save(`flight-${method}.smr`, bytes);
  },
};

function download(event) {
  const kind = event.target.dataset.file;
  const method = byId("of").value;
  const named = targets.filter(({ histories }) => histories[method]).map(({ name, histories }) => [name, histories[method]]);
  if (kind !== undefined) {
    FILES[kind](method, named);
  }
}

// ---- actions of the user

function listen() {
  byId("camera").addEventListener("click", useCamera);
  byId("built-in").addEventListener("click", useBuiltIn);
  byId("choose").addEventListener("click", () => byId("file").click());
  byId("file").addEventListener("change", ({ target }) => {
    const [file] = target.files;
    // So that the same file can be chosen again.
    target.value = "";
    if (file !== undefined) {
      useFile(file);
    }
  });
  byId("play").addEventListener("click", () => player.play(!player.isPlaying));
  byId("step").addEventListener("click", () => player.step());
  byId("again").addEventListener("click", () => seek(1));
  byId("speed").addEventListener("change", ({ target }) => {
    player.speed = Number(target.value);
  });
  byId("repeat").addEventListener("change", ({ target }) => {
    player.repeats = target.checked;
  });
  byId("add").addEventListener("click", () => {
    newTarget();
    say("Drag a box over what is to be followed.");
    byId("stage").focus({ preventScroll: true });
    draw();
  });
  byId("downloads").addEventListener("click", download);
  byId("of").addEventListener("change", draw);
  byId("copy").addEventListener("click", copy);
  byId("settings").addEventListener("change", change);
  byId("stage").addEventListener("keydown", (event) => {
    if (event.key === " ") {
      event.preventDefault();
      player.play(!player.isPlaying);
    } else if (event.key === "[" || event.key === "]") {
      seekEvent(event.key === "]" ? 1 : -1);
    }
  });
  listenToDrops();
  new ResizeObserver(draw).observe(byId("stage"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
}

function listenToDrops() {
  const dropping = (on) => (event) => {
    event.preventDefault();
    document.body.classList.toggle("dropping", on);
  };
  document.addEventListener("dragover", dropping(true));
  document.addEventListener("dragleave", dropping(false));
  document.addEventListener("drop", (event) => {
    dropping(false)(event);
    const [file] = event.dataTransfer.files;
    file === undefined ? say("That is no file: drop a video.") : useFile(file);
  });
}

async function copy() {
  try {
    await navigator.clipboard.writeText(byId("command").textContent);
    byId("copy").textContent = "Copied";
    setTimeout(() => (byId("copy").textContent = "Copy"), 1500);
  } catch {
    getSelection().selectAllChildren(byId("command"));
  }
}

function change() {
  const isChecked = (id) => byId(id).checked;
  settings.robust = { reach: Number(byId("reach").value), size: isChecked("size"), sweep: isChecked("sweep"), refiner: isChecked("refiner") };
  settings.smr.config = byId("config").value;
  player.restart();
  if (player.source.kind === "camera") {
    say("Lock again: the trackers have new settings.");
  }
}

function switches() {
  for (const method of METHODS) {
    const input = htmlNode("input", { type: "checkbox" });
    input.checked = true;
    input.addEventListener("change", () => {
      settings.on[method] = input.checked;
      change();
    });
    byId("switches").append(htmlNode("label", {}, input, sample(method), TITLES[method]));
    byId("of").append(htmlNode("option", { value: method }, TITLES[method]));
  }
}

// The box that keys start from: where the target is, or the middle.
function startBox() {
  const now = METHODS.map((method) => chosen?.now[method]?.box).find((box) => box !== undefined);
  const { x, y, width, height } = now ?? { x: size.width * 0.4, y: size.height * 0.4, width: size.width / 5, height: size.height / 5 };
  return { x: Math.round(x), y: Math.round(y), width: Math.round(width), height: Math.round(height) };
}

async function start() {
  if (typeof WebAssembly !== "object") {
    throw new Error("This browser has no WebAssembly, which the trackers need: use a current browser, or allow it.");
  }
  if (typeof OffscreenCanvas !== "function" || typeof DecompressionStream !== "function") {
    throw new Error("This browser is too old for this page: use a current Firefox, Chrome, Edge or Safari.");
  }
  follower = new Follower(workerAddress(), (text) => say(`The trackers do not run here: ${text}.`));
  const { version: found, simd } = await follower.ask("start", { modules: packedModules(), settings });
  version = found;
  byId("version").textContent = `smr ${version}, ${simd ? "with" : "without"} SIMD`;
  graph = new Graph({ goTo: seek });
  cards = new Cards(byId("comparisons"));
  figures = new Figures(byId("figures"));
  drawScale(byId("scale"));
  seesCurves = inView(byId("curves"), draw);
  seesComparisons = inView(byId("scale"), draw);
  byId("cost").textContent = "Time here: of an update in this browser, the median of 300. Cortex-M4 and M55: instructions of this update, estimated from its work.";
  player = new Player(follower, {
    shown: () => chosen?.id, behind, sent, answered, restarted, changed: draw, say,
  });
  timeline = new Timeline(byId("timeline"), { goTo: seek });
  new Drag(byId("stage"), {
    size: () => (number === null ? null : size),
    start: startBox,
    propose: (box) => {
      proposed = box;
      player.hold(box !== null);
      draw();
    },
    lock: lockByUser,
  });
  switches();
  listen();
  await useBuiltIn();
}

start().catch((error) => {
  document.body.classList.add("failed");
  say(error.message);
});
