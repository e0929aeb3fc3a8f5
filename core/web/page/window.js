// The window of `host-sim view`: shows frames with the boxes of the targets, and takes what the user draws on them.

import { Answers } from "./answers.js";
import { Connection } from "./connection.js";
import { optionsOf } from "./command.js";
import { byId, htmlNode, inView } from "./dom.js";
import { save } from "./download.js";
import { Drag, gripOf } from "./drag.js";
import { Edits, lockIn, nameOf } from "./edits.js";
import { clock, drawEvents, eventsOf, placeOf } from "./events.js";
import { Figures } from "./figures.js";
import { FRAMES, chartsOf } from "./curves.js";
import { Graph } from "./graph.js";
import { drawList } from "./list.js";
import { METHODS, SETTINGS, TITLES } from "./methods.js";
import { Playback } from "./playback.js";
import { drawStage } from "./stage.js";
import { Timeline } from "./timeline.js";
import { drawCommands, drawFiles, drawMade, drawTaken } from "./window-files.js";

const READINGS_MS = 80;
const EVENTS_MS = 400;
const MOST_LATE = 50; // frames
const NEW_COLOR = "#fff";
const NOT_THERE = ["runner-up", "time here"]; // rows of figures.js that no answer here has

const clamp = (value, least, most) => Math.min(Math.max(value, least), most);
const connection = new Connection();
const edits = new Edits();
const answers = new Answers();
const view = { x: 0, y: 0, zoom: 1 };
const happened = new Map(); // events by the id of a target
let source; // see connection.js
let kind; // recording or live
let followed = null; // the last frame that all targets have answers for
let news = {};
let proposed = null; // a box that is being drawn
let pulled = null; // what it is pulled by
let hasEnded = false;
let [drawing, reading] = [null, null];
let playback, timeline, graph, figures, drag, seesCurves;

function say(text) {
  byId("said").textContent = text;
  byId("said").hidden = text === "";
}

// ---- frames

const size = () => (playback.shown === null ? null : { width: source.width, height: source.height });
const timeOf = (number) => source.times?.[number - source.first] ?? (source.rate ? (number - source.first) / source.rate : null);
const visit = (number) => playback.visit(number);
const play = (on) => {
  playback.play(on);
  byId("newest").checked = playback.followsNewest;
};

// ---- what the user draws

// Where the target is, or the middle.
function startBox() {
  const { width, height } = source;
  const box = boxOf(edits.chosen)?.box ?? { x: width * 0.375, y: height * 0.375, width: width / 4, height: height / 4 };
  return whole(box);
}

function whole({ x, y, width, height }) {
  return { x: Math.round(x), y: Math.round(y), width: Math.round(width), height: Math.round(height) };
}

function lock(box, grip) {
  if (box.width * box.height === 0) {
    say("The box has no pixels: drag from one corner to the other.");
    return;
  }
  say("");
  edits.lock(playback.shown, box, grip === null ? edits.chosen : targetOf(grip.id));
  changed();
  if (grip === null && kind === "recording" && byId("plays").checked) {
    // The box is not proposed any more when the frame goes on.
    queueMicrotask(() => play(true));
  }
}

const targetOf = (id) => edits.targets.find((target) => target.id === id) ?? null;

// Only boxes that were drawn are moved: over one that a tracker found, a better one can be drawn.
function gripAt(point, reach) {
  const chosen = edits.chosen;
  // While a target is added, every drag draws.
  for (const target of chosen === null ? [] : [chosen, ...edits.targets]) {
    const box = lockIn(target, playback.shown)?.box;
    const held = box && gripOf(box, point, target === chosen ? reach : 0);
    if (held) {
      return { box, held, id: target.id };
    }
  }
  return null;
}

function clicked(point) {
  const target = edits.targets.find((one) => boxOf(one) !== null && gripOf(boxOf(one).box, point, 0) !== null);
  if (target !== undefined) {
    choose(target);
  }
}

function choose(target) {
  edits.choose(target);
  draw();
}

// Each change is sent as all that is wanted now. What host-sim refuses is taken back.
async function changed() {
  const { targets } = edits;
  draw();
  try {
    await connection.targets(targets);
    answers.keep(edits.targets.map(({ id }) => id));
  } catch (error) {
    edits.takeBack(targets);
    say(error.message);
    draw();
  }
}

function rename(target, text) {
  const refused = edits.rename(target, text);
  refused === null ? changed() : say(refused);
}

function unlock() {
  if (lockIn(edits.chosen, playback.shown) !== undefined) {
    edits.unlock(edits.chosen, playback.shown);
    changed();
  }
}

function undo(isRedo) {
  if (isRedo ? edits.canRedo : edits.canUndo) {
    isRedo ? edits.redo() : edits.undo();
    changed();
  }
}

// ---- what host-sim tells

function heard(told) {
  news = { ...told, live: told.live ?? news.live };
  answers.clear(told.clear ?? []);
  answers.take(told.rows);
  followed = told.followed > 0 ? source.first + told.followed - 1 : null;
  Object.assign(source, { frames: told.frames ?? source.frames, times: told.times ?? source.times });
  if (told.targets !== undefined) {
    edits.load(told.targets);
    answers.keep(edits.targets.map(({ id }) => id));
  }
  if (told.said !== undefined) {
    say(told.said);
  }
  told.exports?.forEach((one) => drawMade(byId("made"), one));
  measure();
  draw();
}

// From where to where frames can be reached.
function measure() {
  if (kind !== "live") {
    const known = source.frames === null ? Math.max(followed ?? 0, playback.frame ?? 0, source.first) : source.first + source.frames - 1;
    playback.reach(source.first, known);
  } else if (news.live) {
    const { oldest, newest } = news.live;
    playback.reach(oldest, newest);
    answers.forget(oldest);
    if (playback.followsNewest) {
      // So that there is a picture with its boxes, unless these come late.
      playback.goTo(edits.targets.length === 0 || followed === null ? newest : clamp(followed, newest - MOST_LATE, newest));
    }
  }
}

function gone() {
  hasEnded = true;
  play(false);
  say("host-sim has ended: what was drawn is in the command line below. Start it again to go on.");
  draw();
}

// ---- what is drawn

// The box of a target in the frame that is shown: its lock, else its answer.
function boxOf(target) {
  const answer = target && answers.at(target.id, playback.shown);
  const box = target && (lockIn(target, playback.shown)?.box ?? answer?.box);
  return box ? { box, state: answer?.state ?? "tracking" } : null;
}

function drawn(target) {
  const found = boxOf(target);
  const isChosen = target === edits.chosen;
  // The box that is pulled is drawn where it is pulled to.
  if (found === null || (proposed !== null && pulled?.id === target.id)) {
    return [];
  }
  const { box, state } = found;
  const words = state === "tracking" ? nameOf(target) : `${nameOf(target)}: ${state}`;
  return [{ box, color: target.color, words, isChosen, isLast: state === "lost", hasHandles: isChosen && lockIn(target, playback.shown) !== undefined }];
}

const seen = () => ({ x: view.x, y: view.y, width: source.width / view.zoom, height: source.height / view.zoom });

function moveView(x, y) {
  const { width, height } = seen();
  [view.x, view.y] = [clamp(x, 0, source.width - width), clamp(y, 0, source.height - height)];
}

function centre({ x, y, width, height }) {
  moveView(x + width / 2 - seen().width / 2, y + height / 2 - seen().height / 2);
}

// What is followed or moved by keys stays in view.
function follow() {
  const box = proposed ?? boxOf(edits.chosen)?.box;
  if (view.zoom > 1 && box && !drag.isPointing) {
    const { x, y, width, height } = seen();
    const [across, down] = [box.x + box.width / 2, box.y + box.height / 2];
    if (across < x || across > x + width || down < y || down > y + height) {
      centre(box);
    }
  }
}

// Draws once for each picture of the screen, however much has changed. What is read is drawn less often.
function draw() {
  follow();
  drawing ??= requestAnimationFrame(() => {
    drawing = null;
    if (playback.picture !== undefined) {
      const inOrder = [...edits.targets].sort((one, other) => (one === edits.chosen) - (other === edits.chosen));
      const color = (pulled === null ? edits.chosen : targetOf(pulled.id))?.color ?? NEW_COLOR;
      drawStage(byId("stage"), { picture: playback.picture, size: size(), view: seen(), boxes: inOrder.flatMap(drawn), proposed, color });
    }
  });
  reading ??= setTimeout(() => {
    reading = null;
    drawReadings();
  }, READINGS_MS);
}

// The events of a target. Of an hour they take a while, so they are not found anew for each answer.
function events(target) {
  const { id, locks } = target;
  const version = answers.version(id);
  const known = happened.get(id);
  if (known !== undefined && known.version === version && known.locks === locks) {
    return known.events;
  }
  if (known !== undefined && known.locks === locks && performance.now() - known.at < EVENTS_MS) {
    setTimeout(draw, EVENTS_MS);
    return known.events;
  }
  const found = { version, locks, events: eventsOf(answers.states(id), locks), at: performance.now() };
  happened.set(id, found);
  return found.events;
}

function allEvents() {
  const isNamed = edits.targets.length > 1;
  const all = edits.targets.flatMap((target) => events(target).map((event) => (isNamed ? { ...event, name: nameOf(target) } : event)));
  return all.sort((one, other) => one.frame - other.frame);
}

function drawReadings() {
  const { chosen } = edits;
  const { first, last } = playback;
  drawTargets(chosen);
  timeline.draw({
    first, last, frame: playback.shown ?? first, followed, timeOf,
    strips: edits.targets.map((target) => ({ name: nameOf(target), color: target.color, isChosen: target === chosen, states: (number) => answers.state(target.id, number) })),
    marks: chosen === null ? [] : events(chosen),
  });
  drawEvents(byId("events"), allEvents(), { timeOf, goTo: visit, chosen: playback.shown });
  drawChosen(chosen);
  drawControls(chosen);
  drawCommands(byId("commands"), kind === "live" ? { track: "" } : { track: "", report: "-o report.html" }, source, edits.targets);
}

function drawTargets(chosen) {
  const named = edits.targets.map((target) => ({ ...target, name: nameOf(target), isFollowed: true }));
  drawList(byId("targets"), { targets: named, chosen, choose, rename, remove: (target) => [edits.remove(target), changed()] });
  edits.targets.forEach((target, at) => {
    write(byId("targets").children[at].querySelector(".now"), answers.state(target.id, playback.shown) ?? "–");
  });
}

const named = (number) => (number > playback.last ? "" : timeOf(number) === null ? String(number) : clock(timeOf(number)));

// Of the tracker that follows, what app.js shows of both.
function drawChosen(chosen) {
  const { shown, first, last } = playback;
  const on = Object.fromEntries(METHODS.map((method) => [method, method === source.method]));
  const now = chosen === null ? undefined : answers.at(chosen.id, shown);
  figures.draw({ now: { [source.method]: now ?? {} }, time: () => NaN }, on);
  if (seesCurves() && shown !== null) {
    const end = Math.max(Math.min(shown + FRAMES / 2, last), Math.min(first + FRAMES - 1, Math.max(last, FRAMES)));
    const history = chosen === null ? undefined : answers.around(chosen.id, end - FRAMES + 1, end);
    const charts = chartsOf(byId("curves"), { histories: { [source.method]: history } }, on);
    graph.draw({ charts, first: end - FRAMES + 1, last: end, now: shown, named, timeOf });
  }
}

function drawControls(chosen) {
  const { isPlaying, shown, first, last } = playback;
  byId("newest").checked = playback.followsNewest;
  write(byId("play"), isPlaying ? "❚❚" : "▶");
  byId("play").setAttribute("aria-label", isPlaying ? "Pause" : "Play");
  const isHere = lockIn(chosen, shown) !== undefined;
  const off = { back: playback.frame <= first, on: playback.frame >= last, undo: !edits.canUndo, redo: !edits.canRedo, unlock: !isHere, add: chosen === null, stop: hasEnded };
  Object.entries(off).forEach(([id, isOff]) => (byId(id).disabled = isOff));
  write(byId("place"), shown === null ? "" : placed(shown));
  const lost = chosen === null ? undefined : events(chosen).find((event) => event.kind === "lost" && event.frame <= shown && shown <= event.until);
  write(byId("lost"), lost === undefined ? "" : `Lost since ${placeOf(lost.frame, timeOf)}. Drag a box over it to lock again.`);
  byId("lost").hidden = lost === undefined;
  write(byId("load"), load());
  write(byId("about"), about());
  byId("stage").setAttribute("aria-label", `Frame ${shown}, ${said(chosen)}`);
}

function placed(number) {
  const of = kind === "live" || source.frames === null ? "" : ` of ${playback.last}`;
  return `frame ${number}${of}${timeOf(number) === null ? "" : `, ${clock(timeOf(number))}`}`;
}

function said(chosen) {
  const found = boxOf(chosen);
  if (found === null) {
    return edits.targets.length === 0 ? "no box yet" : "no box here";
  }
  const { x, y, width, height } = whole(found.box);
  return `${nameOf(chosen)} ${found.state}: left ${x}, top ${y}, ${width} x ${height} pixels`;
}

function about() {
  const long = kind === "live" || source.frames === null ? "" : `, ${source.frames} frames${timeOf(playback.last) === null ? "" : `, ${clock(timeOf(playback.last))}`}`;
  return `${source.width}x${source.height} pixels${long}`;
}

function load() {
  const { progress, live } = news;
  const dropped = live && `${droppedOf(live)}. The picture is ${Math.round(live.latency_ms)} ms old.`;
  const following = !live && progress && `Following: frame ${progress.frame}, ${Math.round(progress.rate)} frames a second.`;
  const hint = edits.targets.length === 0 ? "Drag a box over what is to be followed." : edits.chosen === null ? "Drag a box over the new target." : "";
  return [dropped, following, hint].filter(Boolean).join(" ");
}

function write(node, text) {
  if (node.textContent !== text) {
    node.textContent = text;
  }
}

function droppedOf({ dropped }) {
  return dropped === 0 ? "No frame was dropped" : `${dropped} ${dropped === 1 ? "frame was" : "frames were"} dropped: this machine was behind`;
}

// ---- actions of the user

function pressed(event) {
  const { key, target, ctrlKey, metaKey, altKey, shiftKey } = event;
  const isTyping = target.matches("input[type=text], select, textarea");
  // Radio buttons have arrows of their own, buttons and links the space.
  const isOwn = key === " " ? target.matches("button, a, summary, input:not([type=range])") : target.matches("input[type=radio]");
  if (event.defaultPrevented || isTyping || altKey) {
    return;
  }
  if (ctrlKey || metaKey) {
    const isRedo = key.toLowerCase() === "y" || shiftKey;
    if (["z", "y"].includes(key.toLowerCase())) {
      event.preventDefault();
      undo(isRedo);
    }
  } else if (!isOwn && acted(event)) {
    event.preventDefault();
  }
}

function acted(event) {
  const unlocks = ["Delete", "Backspace"].includes(event.key);
  if (unlocks) {
    unlock();
  }
  return unlocks || playback.key(event);
}

function listen() {
  document.addEventListener("keydown", pressed);
  byId("back").addEventListener("click", () => visit(playback.frame - 1));
  byId("on").addEventListener("click", () => visit(playback.frame + 1));
  byId("play").addEventListener("click", () => playback.toggle());
  byId("newest").addEventListener("change", () => {
    playback.followsNewest = byId("newest").checked;
    measure();
  });
  byId("speed").addEventListener("change", () => playback.restart());
  byId("zoom").addEventListener("change", zoom);
  byId("stop").addEventListener("click", stop);
  byId("undo").addEventListener("click", () => undo(false));
  byId("redo").addEventListener("click", () => undo(true));
  byId("unlock").addEventListener("click", unlock);
  byId("add").addEventListener("click", () => {
    choose(null);
    byId("stage").focus({ preventScroll: true });
  });
  ["method", "settings"].forEach((id) => byId(id).addEventListener("change", useMethod));
  byId("firmware").addEventListener("toggle", async () => {
    byId("firmware").lastElementChild.textContent = byId("firmware").open ? await trying(connection.firmware()) : "";
  });
  byId("stage").addEventListener("wheel", (event) => {
    if (view.zoom > 1) {
      event.preventDefault();
      const part = seen().width / byId("stage").clientWidth;
      moveView(view.x + event.deltaX * part, view.y + event.deltaY * part);
      draw();
    }
  });
  new ResizeObserver(draw).observe(byId("stage"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
}

function zoom() {
  view.zoom = Number(byId("zoom").value);
  centre(boxOf(edits.chosen)?.box ?? { x: 0, y: 0, width: source.width, height: source.height });
  draw();
}

// Options that the page does not show stay as they were given.
function useMethod() {
  const method = byId("method").value;
  const { set = [], config, ...others } = method === source.method ? source.options : {};
  const isOn = (id) => byId(id).checked;
  const robust = { reach: Number(byId("reach").value), size: isOn("size"), sweep: isOn("sweep"), refiner: isOn("refiner") };
  const { set: own = [], ...options } = optionsOf(method, { robust, smr: { config: byId("config").value } });
  const all = [...set.filter((one) => !(one.split("=")[0] in robust)), ...own];
  [source.method, source.options] = [method, { ...others, ...options, ...(all.length === 0 ? {} : { set: all }) }];
  trying(connection.method(source.method, source.options));
  // It tells of the settings before.
  byId("firmware").open = false;
  showMethod();
  draw();
}

function showMethod() {
  byId("method").value = source.method;
  document.querySelectorAll("[data-method]").forEach((node) => (node.hidden = node.dataset.method !== source.method));
}

// As they are in the options of host-sim.
function showSettings({ set = [], config }) {
  const given = Object.fromEntries(set.map((one) => one.split("=")));
  const reach = given.reach ?? SETTINGS.robust.reach;
  if (![...byId("reach").options].some(({ value }) => value === String(reach))) {
    byId("reach").append(htmlNode("option", {}, reach));
  }
  byId("reach").value = reach;
  ["size", "sweep", "refiner"].forEach((part) => (byId(part).checked = !["off", "0"].includes(given[part])));
  byId("refiner").checked &&= config !== "robust" || "refiner" in given;
  byId("config").value = source.method === "smr" ? (config ?? "paper") : SETTINGS.smr.config;
}

async function stop() {
  if ((await trying(connection.stop())) !== "") {
    play(false);
    say("Stopped. The last minutes can still be looked through.");
  }
}

async function trying(promise) {
  try {
    return await promise;
  } catch (error) {
    say(error.message);
    return "";
  }
}

async function take(format) {
  const file = await trying(connection.boxes(format));
  if (file !== "") {
    save(file.name, file.bytes);
    drawTaken(byId("made"), file.name);
  }
}

async function make(what, options) {
  const id = await trying(connection.make(what, options));
  if (id !== "" && !byId(`made${id}`)) {
    drawMade(byId("made"), { id, done: null });
  }
}

function prepare() {
  kind = source.live ? "live" : "recording";
  document.querySelectorAll("[data-in]").forEach((node) => (node.hidden = node.dataset.in !== kind));
  document.title = source.name;
  byId("name").textContent = source.name;
  byId("version").textContent = `host-sim ${source.version}`;
  byId("stage").style.setProperty("--ratio", source.width / source.height);
  playback = new Playback({
    picture: (number) => connection.picture(number), isLive: kind === "live", timeOf, speed: () => Number(byId("speed").value),
    isHeld: () => proposed !== null, changed: draw, failed: (error) => say(error.message), marks: () => allEvents().map((event) => event.frame),
  });
  timeline = new Timeline(byId("timeline"), { goTo: visit });
  drag = new Drag(byId("stage"), {
    size, start: startBox, view: seen, grip: gripAt, click: clicked, lock, arrowsStart: false,
    propose: (box, grip) => {
      [proposed, pulled] = [box, grip];
      draw();
    },
  });
  edits.load(source.targets);
  byId("method").append(...source.methods.map((method) => htmlNode("option", { value: method }, TITLES[method])));
  showSettings(source.options);
  showMethod();
  graph = new Graph({ goTo: visit });
  figures = new Figures(byId("figures"), NOT_THERE);
  seesCurves = inView(byId("curves"), draw);
  drawFiles(byId("files"), source, take, make);
}

async function start() {
  source = await connection.open();
  prepare();
  listen();
  measure();
  playback.begin(playback.first);
  await connection.listen(heard, gone, () => playback.shown ?? playback.first);
}

start().catch((error) => {
  document.body.classList.add("failed");
  say(error.message);
});
