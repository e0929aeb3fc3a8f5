// Script of the page of `host-sim report`: shows frames with the boxes of all trackers, curves and events, from the
// JSON in the page.

import { byId, htmlNode, sample } from "./dom.js";
import { clock, drawEvents, eventsOf } from "./events.js";
import { Graph, spansOf } from "./graph.js";
import { lookOf } from "./palette.js";
import { Playback } from "./playback.js";
import { drawComparisons } from "./report-compared.js";
import { makeSortable } from "./report-tables.js";
import { drawStage, stateWords } from "./stage.js";
import { Timeline } from "./timeline.js";

const CURVES = [
  { title: "IoU", key: "iou", most: 1, digits: 2 },
  { title: "Confidence", key: "confidence", most: 1, digits: 3 },
  { title: "Identity", key: "identity", most: 1, digits: 3 },
  { title: "Centre error, pixels", key: "error", digits: 1 },
  { title: "Size, pixels (root of the box's area)", key: "size", digits: 1 },
  { title: "Ratio (dotted: runner-up)", key: "ratio", second: "runner_up", most: 1, digits: 3 },
  { title: "Alpha, gray levels", key: "alpha", digits: 0 },
  { title: "Cost, comparisons or products", key: "work", digits: 0 },
];
const OPEN = 2; // curves that are seen at once
const MAX_STATES = 2; // on the frame

// Smallest difference in gray levels that is drawn at full brightness.
const BRIGHTEST = 127;
const bright = (level) => Math.floor(Math.sqrt((255 * 255 * Math.min(level, BRIGHTEST)) / BRIGHTEST));
const GRAY = (shade) => [shade, shade, shade];
const GREEN = (shade) => [Math.floor(shade / 3), 105 + Math.floor(shade / 3), 65 + Math.floor(shade / 3)];

const data = JSON.parse(byId("data").textContent);
const off = new Set(data.recordings.flatMap(({ entrants }) => entrants).filter(({ method, isTruth }) => method === null && !isTruth).map(({ name }) => name));
let recording = null;
let [numbers, hidden, events] = [[], [], []];
let drawing = null;

// Registered before the playback's own listener, so that the recording is open before the frame number is read.
addEventListener("hashchange", () => open(addressed() ?? recording));
const playback = new Playback({
  image, isLive: () => false, timeOf: (number) => timeOf(number), speed: () => Number(byId("speed").value), isHeld: () => false, isAwaited: () => false, changed: draw, failed: () => {},
  marks: () => [...new Set(events.map(({ frame }) => frame))],
});
const visit = (number) => playback.visit(number);
const timeline = new Timeline(byId("timeline"), { goTo: visit });
const graph = new Graph({ goTo: visit, zooms: true });

const shown = () => recording.entrants.filter(({ name }) => !off.has(name));
const withStates = () => shown().filter(({ states }) => states);
const timeOf = (number) => recording.times?.[number - recording.first] ?? null;

async function image(number) {
  const { every, frames } = recording.images;
  const image = new Image();
  image.src = `data:image/jpeg;base64,${frames[Math.floor((number - recording.first) / every)]}`;
  await image.decode();
  return image;
}

// ---- recordings

/** Returns the recording that the page's address names, or undefined. */
function addressed() {
  const name = new URLSearchParams(location.hash.slice(1)).get("recording");
  return data.recordings.find((one) => one.name === name);
}

function open(one) {
  if (one === recording) {
    return;
  }
  const at = data.recordings.indexOf(one);
  recording = one;
  const { first, frames, entrants, width, height, margin } = one;
  const truth = entrants.find(({ isTruth }) => isTruth);
  numbers = Array.from({ length: frames }, (_, index) => first + index);
  hidden = truth === undefined ? [] : spansOf(truth.boxes.map((box) => (box === null ? "hidden" : null))).map(({ from, to }) => [first + from, first + to]);
  events = eventsOfAll();
  byId("recording").value = at;
  byId("stage").style.setProperty("--ratio", (width + 2 * margin) / (height + 2 * margin));
  [...(byId("sentences")?.children ?? [])].forEach((node, index) => (node.hidden = index !== at));
  drawSwitches(entrants);
  playback.forget(first, first + frames - 1);
  drawCurves();
  fit();
}

/** Returns the events of all targets, sorted by frame. If several methods track a target, the first one counts. */
function eventsOfAll() {
  const of = ({ name, locks }, target) => {
    const { states } = recording.entrants.find((entrant) => entrant.target === target);
    const rows = states.map((state, at) => ({ number: numbers[at], state })).filter(({ state }) => state !== null);
    return eventsOf(rows, locks.map((number) => ({ number }))).map((event) => (name === null ? event : { ...event, name }));
  };
  return recording.targets.flatMap(of).sort((one, other) => one.frame - other.frame);
}

function drawSwitches(entrants) {
  const labels = entrants.map(({ name, title, look }) => {
    const input = htmlNode("input", { type: "checkbox" });
    input.checked = !off.has(name);
    input.addEventListener("change", () => {
      input.checked ? off.delete(name) : off.add(name);
      drawCurves();
      draw();
    });
    return htmlNode("label", {}, input, sample(look), title);
  });
  byId("switches").replaceChildren(byId("switches").firstElementChild, ...labels);
}

// ---- drawing

function drawCurves() {
  const line = ({ short, look }, values, isSecond = false) => ({ title: isSecond ? `${short}, runner-up` : short, look, isSecond, numbers, values });
  const curves = CURVES.flatMap(({ key, second, ...chart }) => {
    const lines = shown().flatMap((entrant) => [
      ...(entrant[key] ? [line(entrant, entrant[key])] : []), ...(entrant[second] ? [line(entrant, entrant[second], true)] : []),
    ]);
    return lines.length === 0 ? [] : [{ ...chart, lines }];
  });
  const states = { title: "States", bands: withStates().map((entrant) => ({ ...line(entrant, entrant.states), read: (at) => span(entrant.states, at) })) };
  const charts = [...curves.slice(0, OPEN), ...(states.bands.length === 0 ? [] : [states]), ...curves.slice(OPEN)];
  const named = (number) => (timeOf(number) === null ? String(number) : clock(timeOf(number)));
  graph.draw({
    charts: charts.map((chart, at) => ({ ...chart, place: byId(at < OPEN ? "curves" : "more") })),
    first: numbers[0], last: numbers.at(-1), now: playback.frame, hidden, named, timeOf,
  });
  byId("more").parentNode.hidden = charts.length <= OPEN;
}

function span(states, at) {
  const { value, from, to } = spansOf(states).find(({ to }) => at <= to);
  return `${value} in ${numbers[from]} to ${numbers[to]}`;
}

/** Draws text and charts at once, and the frame in the next animation frame. */
function draw() {
  const { frame, first, last, isPlaying } = playback;
  const index = frame - first;
  const strips = withStates().map(({ look, states }, at) => ({ color: lookOf(look).onPage, isChosen: at === 0, states: (number) => states[number - first] ?? undefined }));
  timeline.draw({ first, last, frame, followed: last, strips, marks: events, timeOf });
  drawEvents(byId("events"), events, { timeOf, goTo: visit, chosen: frame });
  graph.mark(frame);
  byId("place").value = `frame ${frame} of ${last}${timeOf(frame) === null ? "" : `, ${clock(timeOf(frame))}`}`;
  byId("play").textContent = isPlaying ? "❚❚" : "▶";
  byId("play").setAttribute("aria-label", isPlaying ? "Pause" : "Play");
  byId("stage").setAttribute("aria-label", [byId("place").value, ...statesAt(index).map((words) => words.join(": "))].join(", "));
  if (byId("comparisons").closest("details").open) {
    drawComparisons(recording, shown(), index, { timeOf, data });
  }
  drawing ??= requestAnimationFrame(drawShown);
}

/** Returns [title, state] of the first MAX_STATES trackers in a frame, to display in its corner. */
function statesAt(index) {
  const truth = recording.entrants.find(({ isTruth }) => isTruth);
  const all = recording.entrants.filter(({ states }) => states).slice(0, MAX_STATES);
  return [...all.map(({ short, states }) => [short, states[index] ?? "not begun"]), ...(truth?.boxes[index] === null ? [["target", "hidden"]] : [])];
}

function drawShown() {
  drawing = null;
  if (playback.image === undefined) {
    return;
  }
  const { width, height, margin } = recording;
  const index = playback.shown - recording.first;
  const boxed = ({ look, boxes, lasts }) => {
    const [x, y, wide, high] = boxes[index] ?? lasts?.[index] ?? [];
    const { onFrame, dash } = lookOf(look);
    return x === undefined ? [] : [{ box: { x, y, width: wide, height: high }, color: onFrame, dash, isLast: boxes[index] === null }];
  };
  drawStage(byId("stage"), {
    image: playback.image, size: { width, height }, view: { x: -margin, y: -margin, width: width + 2 * margin, height: height + 2 * margin },
    boxes: shown().flatMap(boxed), words: stateWords(playback.shown, statesAt(index)),
  });
  byId("stage").dataset.frame = playback.shown;
}

// In a narrow window the player stays visible and shrinks while the user scrolls. It floats over an empty element of
// fixed height, so that the content below does not jump.
function fit() {
  const [screen, room, stage] = ["screen", "room", "stage"].map(byId);
  const high = (pixels) => stage.style.setProperty("--high", pixels);
  high("");
  const [full, rest] = [stage.clientHeight, screen.offsetHeight - stage.clientHeight];
  room.style.height = `${full + rest}px`;
  if (room.clientHeight === 0) {
    return;
  }
  high(`max(26vh, ${Math.min(room.getBoundingClientRect().bottom - rest, full)}px)`);
  // At the end of the curves, the player scrolls out of view with them.
  screen.style.transform = `translateY(${Math.min(byId("player").getBoundingClientRect().bottom - screen.offsetHeight, 0)}px)`;
}

// ---- actions of the user

function pressed(event) {
  const { ctrlKey, altKey, metaKey, target } = event;
  if (!ctrlKey && !altKey && !metaKey && !target.closest("input, select, button, a, summary, .scroll") && (playback.key(event) || graph.key(event))) {
    event.preventDefault();
  }
}

function listen() {
  byId("timeline").querySelector("input").id = "scrub";
  byId("play").addEventListener("click", () => playback.toggle());
  byId("back").addEventListener("click", () => visit(playback.frame - 1));
  byId("on").addEventListener("click", () => visit(playback.frame + 1));
  byId("speed").addEventListener("change", () => playback.restart());
  byId("recording").addEventListener("change", ({ target }) => {
    open(data.recordings[target.value]);
    history.replaceState(null, "", `#${new URLSearchParams({ recording: recording.name })}`);
    visit(recording.first);
  });
  document.addEventListener("keydown", pressed);
  addEventListener("scroll", fit, { passive: true });
  new ResizeObserver(draw).observe(byId("stage"));
  addEventListener("resize", fit);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  byId("comparisons").closest("details").addEventListener("toggle", draw);
  document.querySelectorAll(".scroll table").forEach(makeSortable);
}

function drawScale(place) {
  const stops = (color) => Array.from({ length: 17 }, (_, at) => `rgb(${color(bright((at * BRIGHTEST) / 16)).join()})`).join(", ");
  const line = (text, color) => {
    const bar = htmlNode("span", { class: "ramp" });
    bar.style.background = `linear-gradient(to right, ${stops(color)})`;
    return htmlNode("div", {}, htmlNode("span", {}, "0"), bar, htmlNode("span", {}, `127+ ${text}`));
  };
  place.replaceChildren(line("gray levels", GRAY), line("that count", GREEN));
}

function start() {
  byId("player").hidden = false;
  drawScale(byId("scale"));
  listen();
  open(addressed() ?? data.recordings[0]);
  const isCalm = location.hash !== "" || matchMedia("(prefers-reduced-motion: reduce)").matches;
  playback.begin(isCalm ? (recording.parting ?? recording.first) : recording.first);
  if (!isCalm) {
    playback.play(true);
  }
}

start();
