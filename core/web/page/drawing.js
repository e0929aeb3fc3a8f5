// Draws the application: the frame with its boxes at most once per animation frame, text and charts less often.

import { drawCommands } from "./command-lines.js";
import { Detail } from "./detail.js";
import { byId, inView } from "./dom.js";
import { isGone, isHidden, lockIn, nameOf } from "./edits.js";
import { clock, drawEvents, eventsOf, placeOf } from "./events.js";
import { drawLimits } from "./exports.js";
import { FRAMES, chartsOf, drawFigures } from "./figures.js";
import { Graph } from "./graph.js";
import { drawList } from "./list.js";
import { drawLine, movementOf, scaleOf } from "./movement.js";
import { colorOf } from "./palette.js";
import { Preview } from "./preview.js";
import { drawStage } from "./stage.js";
import { answers, app, boxIn, boxOf, say, size, targetOf, timeOf, whole, write } from "./state.js";
import { Timeline } from "./timeline.js";

const READINGS_MS = 80;
const EVENTS_MS = 400;
const LOADING_MS = 200; // a shorter wait is not worth a word
const CURVE = 48; // height of a chart in pixels: all stand beside the picture
const TRAIL = 75; // the last frames through which the path of a target is drawn

let [drawing, reading, loading] = [null, null, null];
const happened = new Map(); // events by the id of a target
let act; // the user's actions: { visit, choose, rename, remove }
let detail, timeline, preview, graph, seesCurves;

/** Makes what is drawn respond to the user. */
export function prepareDrawing(actions) {
  act = actions;
  timeline = new Timeline(byId("timeline"), { goTo: act.visit, hover });
  preview = new Preview(byId("timeline"));
  graph = new Graph({ goTo: act.visit, height: CURVE });
  seesCurves = inView(byId("curves"), draw);
}

/** Drops what was drawn of the former recording. */
export function forget() {
  happened.clear();
  detail = new Detail((number, part) => app.source.part(number, part), draw);
}

// Schedules a redraw: the frame at most once per animation frame, text and charts less often.
export function draw() {
  drawing ??= requestAnimationFrame(() => {
    drawing = null;
    if (app.playback.image !== undefined) {
      follow();
      drawFrame();
    }
  });
  reading ??= setTimeout(() => {
    reading = null;
    drawReadings();
  }, READINGS_MS);
}

// Moves an enlarged view so that the chosen target, or the box that is drawn by keys, stays visible.
function follow() {
  const { drag, edits, playback, proposed, viewport } = app;
  const box = proposed ?? boxOf(edits.chosen)?.box;
  if (viewport.zoom > 1 && box && !drag.isPointing && (playback.isPlaying || proposed !== null)) {
    viewport.show(box);
  }
}

function drawFrame() {
  const { image, shown } = app.playback;
  const view = app.viewport.seen;
  const { chosen } = app.edits;
  const inOrder = [...app.edits.targets].sort((one, other) => (one === chosen) - (other === chosen));
  const drawing = app.pulled === null ? chosen?.id : app.pulled.id;
  if (app.kind === "recorded" && view.width < app.recording.width) {
    detail.want(shown, view, app.recording);
  }
  const under = (context, placed) => {
    detail.draw(context, shown, placed);
    if (byId("trail").checked) {
      app.edits.targets.forEach((target) => drawTrail(context, shown, { boxAt: trailOf(target), placed, color: colorOf(target.id) }));
    }
    const line = app.measured?.drawn ?? app.measured?.line;
    if (line) {
      drawLine(context, placed(line));
    }
  };
  drawStage(byId("stage"), { image, size: size(), view, under, boxes: inOrder.flatMap(drawn), proposed: app.proposed, color: drawing ? colorOf(drawing) : undefined });
  app.truth.look();
}

function drawn(target) {
  const found = boxOf(target);
  const isChosen = target === app.edits.chosen;
  // Omits a box that the user drags, because it is drawn separately at its new position.
  if (found === null || (app.proposed !== null && app.pulled?.id === target.id)) {
    return [];
  }
  const { box, state } = found;
  const words = state === "tracking" ? nameOf(target) : `${nameOf(target)}: ${state}`;
  return [{ box, color: colorOf(target.id), words, isChosen, isLast: isUnseen(state), hasHandles: isChosen }];
}

const isUnseen = (state) => state === "lost" || state === "hidden";

function trailOf(target) {
  const isThere = (found) => found !== null && !isUnseen(found.state);
  return (number) => (isThere(boxIn(target, number)) ? boxIn(target, number).box : null);
}

/** Draws the path of a box's centre up to frame `number`. `placed(box)` converts a box to canvas pixels. */
function drawTrail(context, number, { boxAt, placed, color }) {
  const points = Array.from({ length: TRAIL }, (_, back) => boxAt(number - TRAIL + 1 + back)).map((box) => (box ? centre(placed(box)) : null));
  context.setLineDash([]);
  context.lineWidth = 2;
  context.strokeStyle = color;
  points.forEach((to, at) => {
    const from = points[at - 1];
    if (from && to) {
      context.globalAlpha = at / TRAIL;
      context.beginPath();
      context.moveTo(...from);
      context.lineTo(...to);
      context.stroke();
    }
  });
  context.globalAlpha = 1;
}

const centre = ([x, y, width, height]) => [x + width / 2, y + height / 2];

// Returns the events of a target. They are cached for a while, because computing those of an hour of frames is slow.
export function events(target) {
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

export function allEvents() {
  const isNamed = app.edits.targets.length > 1;
  const all = app.edits.targets.flatMap((target) => events(target).map((event) => (isNamed ? { ...event, name: nameOf(target) } : event)));
  return all.sort((one, other) => one.frame - other.frame);
}

function drawReadings() {
  const { edits, followed, hovered, kind, playback, recording } = app;
  const { chosen } = edits;
  const { first, last, shown } = playback;
  drawTargets(chosen);
  timeline.draw({
    first, last, frame: shown ?? first, followed, timeOf,
    strips: edits.targets.map((target) => ({ name: nameOf(target), color: colorOf(target.id), isChosen: target === chosen, states: (number) => answers.state(target.id, number) })),
    marks: chosen === null ? [] : events(chosen),
    truth: chosen && app.truth.marks(chosen),
  });
  preview.draw({ ...hovered, image: playback.imageOf(hovered.number), size: recording, timeOf });
  drawEvents(byId("events"), allEvents(), { timeOf, goTo: act.visit, chosen: shown });
  drawChosen(chosen);
  drawControls(chosen);
  drawLength();
  app.truth.draw(chosen);
  drawLimits(byId("files"), edits.targets.length, chosen);
  drawCommands(byId("commands"), kind === "live" ? { track: "" } : { view: "", track: "", report: "-o report.html" }, recording, edits.targets);
}

// Draws the fields for a length in the picture.
export function drawLength() {
  const { measured, recording } = app;
  byId("length").ariaPressed = measured !== null;
  byId("measured").hidden = measured === null;
  byId("metres").disabled = byId("takeLength").disabled = !measured?.line;
  byId("dropLength").disabled = !recording.length;
  write(byId("scale"), scaleOf(recording.length));
  byId("scale").hidden = !recording.length || byId("curve").value !== "movement";
}

function drawTargets(chosen) {
  const { edits, playback } = app;
  const named = edits.targets.map((target) => ({ ...target, name: nameOf(target) }));
  drawList(byId("targets"), { ...act, targets: named, chosen });
  edits.targets.forEach((target, at) => {
    const number = playback.shown;
    const state = isGone(target, number) ? "gone" : isHidden(target, number) ? "hidden" : (answers.state(target.id, number) ?? "–");
    write(byId("targets").children[at].querySelector(".now"), state);
  });
}

const named = (number) => (number > app.playback.last ? "" : timeOf(number) === null ? String(number) : clock(timeOf(number)));

function drawChosen(chosen) {
  const { shown, first, last } = app.playback;
  byId("now").hidden = chosen === null;
  drawFigures(byId("figures"), app.recording.method, chosen === null ? undefined : answers.at(chosen.id, shown));
  byId("curves").hidden = chosen === null;
  write(byId("whose"), chosen === null ? "" : nameOf(chosen));
  if (chosen !== null && seesCurves() && shown !== null) {
    const isOpen = app.kind === "live" || app.recording.frames === null;
    const count = isOpen ? FRAMES : Math.min(FRAMES, last - first + 1);
    const end = Math.max(Math.min(shown + FRAMES / 2, last), Math.min(first + count - 1, Math.max(last, FRAMES)));
    const range = { first: end - count + 1, last: end };
    const { method, length } = app.recording;
    byId("whose").style.setProperty("--of", colorOf(chosen.id));
    const charts = byId("curve").value === "movement"
      ? movementOf(byId("curves"), `target${chosen.id}`, { ...range, boxAt: trailOf(chosen), timeOf, length })
      : chartsOf(byId("curves"), `target${chosen.id}`, method, answers.around(chosen.id, range.first, range.last));
    graph.draw({ charts, ...range, now: shown, named, timeOf });
  }
}

function drawControls(chosen) {
  const { isPlaying, shown, frame, first, last } = app.playback;
  byId("newest").checked = app.playback.followsNewest;
  write(byId("play"), isPlaying ? "❚❚" : "▶");
  byId("play").setAttribute("aria-label", isPlaying ? "Pause" : "Play");
  const isHere = lockIn(chosen, shown) !== undefined;
  const isBegun = chosen !== null && chosen.locks[0].number < shown;
  const off = { back: frame <= first, on: frame >= last, undo: !app.edits.canUndo && app.proposed === null, redo: !app.edits.canRedo, unlock: !isHere, gone: !isBegun, add: chosen === null, stop: app.hasEnded };
  Object.entries(off).forEach(([id, isOff]) => (byId(id).disabled = isOff));
  write(byId("gone"), isGone(chosen, shown) ? "Back" : "Gone");
  write(byId("whole"), `${app.viewport.zoom < 10 ? Number(app.viewport.zoom.toFixed(1)) : Math.round(app.viewport.zoom)}×`);
  write(byId("place"), shown === null ? "" : placed(shown));
  drawLoading();
  const lost = chosen === null ? undefined : events(chosen).find((event) => event.kind === "lost" && event.frame <= shown && shown <= event.until);
  write(byId("lost"), lost === undefined ? "" : `Lost since ${placeOf(lost.frame, timeOf)}. Drag a box over it to lock again.`);
  byId("lost").hidden = lost === undefined;
  write(byId("hint"), hint(chosen));
  byId("hint").hidden = byId("hint").textContent === "";
  write(byId("load"), load());
  write(byId("about"), about());
  byId("stage").setAttribute("aria-label", `Frame ${shown}, ${said(chosen)}`);
}

function drawLoading() {
  const { isLoading, isWaiting, frame, shown } = app.playback;
  if (frame === shown) {
    say("", "image");
  }
  loading = isLoading || isWaiting ? (loading ?? performance.now()) : null;
  const isLong = loading !== null && performance.now() - loading > LOADING_MS;
  write(byId("loading"), isLong ? (isLoading ? `Loading frame ${frame}` : `Waiting for ${nameOf(app.edits.chosen)} in frame ${frame + 1}`) : "");
  byId("loading").hidden = !isLong;
  if (loading !== null && !isLong) {
    setTimeout(draw, LOADING_MS);
  }
}

function placed(number) {
  const of = app.kind === "live" || app.recording.frames === null ? "" : ` of ${app.playback.last}`;
  return `frame ${number}${of}${timeOf(number) === null ? "" : `, ${clock(timeOf(number))}`}`;
}

function said(chosen) {
  const found = boxOf(chosen);
  if (found === null) {
    return app.edits.targets.length === 0 ? "no box yet" : "no box here";
  }
  const { x, y, width, height } = whole(found.box);
  return `${nameOf(chosen)} ${found.state}: left ${x}, top ${y}, ${width} x ${height} pixels`;
}

function about() {
  const { edits, kind, recording } = app;
  const end = timeOf(app.playback.last);
  const long = kind === "live" || recording.frames === null ? "" : `, ${recording.frames} ${recording.frames === 1 ? "frame" : "frames"}${end === null ? "" : `, ${clock(end)}`}`;
  const kept = recording.session && edits.targets.length > 0 ? `. Your work is kept in ${recording.session}` : "";
  return `${recording.width}x${recording.height} pixels${long}${kept}`;
}

function load() {
  const { progress, live } = app.news;
  const dropped = live && `${droppedOf(live)}. The picture is ${Math.round(live.latency_ms)} ms old.`;
  const pace = progress?.rate >= 1 ? `, ${Math.round(progress.rate)} frames a second` : "";
  const following = !live && progress && `Following: frame ${progress.frame}${pace}.`;
  return [dropped, following].filter(Boolean).join(" ");
}

// Returns the sentence that stands in the picture: what to do next.
function hint(chosen) {
  if (app.measured !== null) {
    return "Drag a line along something whose length you know.";
  }
  if (chosen === null) {
    return app.edits.targets.length === 0 ? "Drag a box over what is to be followed." : "Drag a box over the new target.";
  }
  return app.truth.hint;
}

function droppedOf({ dropped }) {
  return dropped === 0 ? "No frame was dropped" : `${dropped} ${dropped === 1 ? "frame was" : "frames were"} dropped: this machine was behind`;
}

function hover(number, x) {
  if (app.kind === "live") {
    return;
  }
  app.hovered = { number, x };
  app.playback.peek(number);
  draw();
}
