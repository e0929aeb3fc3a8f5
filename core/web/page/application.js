// The application: shows the frames of a source (connection.js or local.js) with the targets' boxes, and handles the
// boxes that the user draws.

import { Answers } from "./answers.js";
import { drawCommands } from "./command-lines.js";
import { Detail } from "./detail.js";
import { byId, htmlNode, inView } from "./dom.js";
import { Drag, gripOf, inside } from "./drag.js";
import { Edits, isGone, lockIn, nameOf } from "./edits.js";
import { clock, drawEvents, eventsOf, placeOf } from "./events.js";
import { drawLimits, drawMade, drawMenu, drawTaken } from "./exports.js";
import { FRAMES, chartsOf, drawFigures } from "./figures.js";
import { Graph } from "./graph.js";
import { drawList } from "./list.js";
import { ENDED, Messages } from "./messages.js";
import { Playback, frameNamed } from "./playback.js";
import { Preview } from "./preview.js";
import { doubtOf } from "./question.js";
import { drawStage } from "./stage.js";
import { Timeline } from "./timeline.js";
import { chosenTracker, showMethod, showTracker } from "./tracker-settings.js";
import { Viewport } from "./viewport.js";

const READINGS_MS = 80;
const EVENTS_MS = 400;
const LOADING_MS = 200; // a shorter wait is not worth a word
const MAX_LATE = 50; // frames
const NEW_COLOR = "#fff";
const TRAIL = 75; // the last frames through which the path of a target is drawn

const clamp = (value, least, most) => Math.min(Math.max(value, least), most);
const answers = new Answers();
const happened = new Map(); // events by the id of a target
let edits; // see edits.js
let source; // see connection.js
let recording; // the facts that it opened with
let kind; // recorded or live
let followed = null; // the last frame that all targets have answers for
let news = {};
let proposed = null; // a box that is being drawn
let pulled = null; // the grip that it is pulled by
let asked = null; // a box of which the user has to say what it is for: { box, grip, id, first }
let hovered = { number: null }; // the frame under the mouse on the timeline
let hasEnded = false;
let sent = []; // the targets that were sent last
const underWay = new Set(); // lists of ids of targets whose change the source has not answered yet
let messages = new Messages();
let [drawing, reading, loading] = [null, null, null];
let playback, viewport, detail, timeline, preview, graph, drag, seesCurves;

// The sentence of the cause "act" is about the user's last action.
function say(text, cause = "act") {
  messages.say(text, cause);
  write(byId("said"), messages.text);
  byId("said").hidden = messages.text === "";
}

function complain({ message, cause }) {
  const isGone = cause === "connection";
  if (!isGone || !hasEnded) {
    say(message, isGone ? cause : "act");
  }
}

// ---- frames

const size = () => (playback.shown === null ? null : { width: recording.width, height: recording.height });
const timeOf = (number) => recording.timeOf?.(number) ?? recording.times?.[number - recording.first] ?? (recording.rate ? (number - recording.first) / recording.rate : null);

function visit(number) {
  say("");
  drag.drop();
  playback.visit(number);
}

function visitNamed() {
  if (byId("go").value.trim() === "") {
    return;
  }
  const number = frameNamed(byId("go").value, playback, timeOf);
  if (number === null) {
    const times = timeOf(playback.last) === null ? "" : ", or a time such as 1:02.5";
    say(`No frame is called "${byId("go").value}": expected a number from ${playback.first} to ${playback.last}${times}.`);
    return;
  }
  byId("go").value = "";
  visit(number);
}

// ---- boxes that the user draws

// Returns the grip from which drawing by keys starts: the inside of the chosen target's box or, with the id null, of a
// box in the middle of the view.
function startGrip() {
  const { x, y, width, height } = viewport.seen;
  const found = boxOf(edits.chosen);
  const box = found?.box ?? { x: x + width * 0.375, y: y + height * 0.375, width: width / 4, height: height / 4 };
  return { box: whole(box), held: [0, 0], id: found && edits.chosen.id };
}

function whole({ x, y, width, height }) {
  return { x: Math.round(x), y: Math.round(y), width: Math.round(width), height: Math.round(height) };
}

// Takes a box that the user has drawn, or pulled by a grip. Returns false if the user must say first what it is for.
function lock(box, grip) {
  if (box.width * box.height === 0) {
    say("The box has no pixels: drag from one corner to the other.");
    return true;
  }
  if (asked !== null && JSON.stringify(asked.box) === JSON.stringify(box)) {
    settle(asked.first);
    return true;
  }
  const held = grip ?? asked?.grip ?? null;
  const target = held === null ? edits.chosen : targetOf(held.id);
  const doubt = target && doubtOf(box, { name: nameOf(target), isPulled: held !== null, ...formerOf(target, held) });
  if (doubt) {
    ask({ box, grip: held, id: target.id, first: held === null ? "fresh" : "correct" }, doubt);
    return false;
  }
  lockOn(box, target, held !== null);
  return true;
}

// Returns the box that a target had before the user's: the pulled one, its box in the shown frame, or else its nearest
// known one; null if the target is gone.
function formerOf(target, grip) {
  const here = playback.shown;
  if (grip !== null || isGone(target, here)) {
    return { former: grip?.box ?? null };
  }
  const { number, box } = target.locks.findLast((one) => one.number <= here) ?? target.locks[0];
  const found = boxOf(target) ?? answers.last(target.id, number, here) ?? { box };
  return { former: whole(found.box), isLost: found.state === "lost" };
}

function lockOn(box, target, isPulled) {
  edits.lock(playback.shown, box, target);
  changed();
  if (!isPulled && kind === "recorded" && byId("plays").checked) {
    // Deferred, because playback cannot leave the frame until the drawn box is cleared.
    queueMicrotask(() => playback.play(true));
  }
}

// Shows or, for null, hides the question what a box is for.
function ask(what, words = "") {
  asked = what;
  byId("asked").hidden = what === null;
  byId("asked").firstElementChild.textContent = words;
  if (what !== null) {
    write(byId("correct"), `Correct ${nameOf(targetOf(what.id))}`);
    byId("asked").insertBefore(byId(what.first), byId("asked").querySelector("button"));
  }
}

function settle(answer) {
  const { box, grip, id } = asked;
  lockOn(box, answer === "fresh" ? null : targetOf(id), grip !== null);
}

const targetOf = (id) => edits.targets.find((target) => target.id === id) ?? null;

// Returns the box at a point and the part of it to drag: only the chosen target has edges and corners to drag. Returns
// null while a target is being added, so that every drag draws a box.
function gripAt(point, reach) {
  const chosen = edits.chosen;
  for (const target of chosen === null ? [] : [chosen, ...edits.targets]) {
    const box = boxOf(target)?.box;
    const held = box && gripOf(box, point, target === chosen ? reach : 0);
    if (held) {
      return { box: whole(box), held, id: target.id };
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
  say("");
  edits.choose(target);
  draw();
}

// Sends the whole list of targets to the source after a change, and reverts the change if the source refuses it.
async function changed() {
  const { targets } = edits;
  say("");
  drag.drop();
  draw();
  const ids = targets.filter((target) => !sent.includes(target)).map(({ id }) => id);
  underWay.add(ids);
  sent = targets;
  try {
    await source.targets(targets, edits.ids);
    answers.keep(edits.targets.map(({ id }) => id));
  } catch (error) {
    edits.takeBack(targets);
    complain(error);
    draw();
  } finally {
    underWay.delete(ids);
  }
}

function rename(target, text) {
  const refused = edits.rename(target, text);
  refused === null ? changed() : say(refused);
}

// True if the requested frame is shown: a click while it is still loading refers to no frame.
const isThere = () => kind === "live" || playback.isPlaying || !playback.isLoading;

function unlock() {
  if (isThere() && lockIn(edits.chosen, playback.shown) !== undefined) {
    edits.unlock(edits.chosen, playback.shown);
    changed();
  }
}

// Marks the chosen target as gone from the shown frame on or, if it is gone, locks it again on its last box.
function goOrComeBack() {
  const { chosen } = edits;
  const here = playback.shown;
  if (!isThere()) {
    return;
  }
  if (!isGone(chosen, here)) {
    edits.lose(chosen, here);
    changed();
    return;
  }
  const { number, box } = chosen.locks.findLast((one) => one.number < here && one.box !== null);
  edits.lock(here, inside(whole(answers.last(chosen.id, number, here)?.box ?? box), recording), chosen);
  changed();
  say("Pull the box to where the target is.");
}

function undo(isRedo) {
  // A box that waits for an answer or for Enter is undone first.
  if (proposed !== null && !isRedo) {
    drag.drop();
  } else if (isRedo ? edits.canRedo : edits.canUndo) {
    isRedo ? edits.redo() : edits.undo();
    changed();
  }
}

// ---- messages from the source

function heard(told) {
  if (told.opened !== undefined) {
    // The frame number in the address was for the former source.
    history.replaceState(null, "", "#");
    opened(told.opened);
    return;
  }
  news = { ...told, live: told.live ?? news.live };
  say("", "connection");
  answers.clear(told.clear ?? []);
  answers.take(told.rows);
  followed = told.followed > 0 ? recording.first + told.followed - 1 : null;
  for (const fact of ["frames", "times", "words"]) {
    recording[fact] = told[fact] ?? recording[fact];
  }
  recording.session = told.session;
  if (told.targets !== undefined) {
    edits.load(told.targets, told.ids);
    answers.keep(edits.targets.map(({ id }) => id));
    if (asked !== null && targetOf(asked.id) === null) {
      drag.drop();
    }
  }
  if (silent().length === 0) {
    say("", "silence");
  }
  if (told.said !== undefined) {
    say(told.said, told.cause ?? (kind === "live" ? "source" : silent().length > 0 ? "silence" : "act"));
  }
  told.exports?.forEach((one) => drawMade(byId("made"), one, cancel));
  measure();
  draw();
}

// Updates the range of frames that can be shown.
function measure() {
  if (kind !== "live") {
    const known = recording.frames === null ? Math.max(followed ?? 0, playback.frame ?? 0, recording.first) : recording.first + recording.frames - 1;
    playback.reach(recording.first, known);
    if (playback.frame > known) {
      // The first count of frames, an estimate, was too large.
      playback.goTo(known);
    }
  } else if (news.live) {
    const { oldest, newest } = news.live;
    playback.reach(oldest, newest);
    answers.forget(oldest);
    if (playback.followsNewest) {
      // Shows the newest frame whose boxes are known, but stays at most MAX_LATE frames behind the newest one.
      playback.goTo(edits.targets.length === 0 || followed === null ? newest : clamp(followed, newest - MAX_LATE, newest));
    }
  }
}

// Lists where the answers of a target end early: [id, frame of its lock, first frame without an answer].
const silent = () => news.silent ?? [];

// True while the chosen target's answer in a frame is still to come: playback must not pass it.
function isAwaited(number) {
  const { chosen } = edits;
  const lock = chosen?.locks.findLast((one) => one.number <= number);
  if (kind === "live" || hasEnded || !lock?.box) {
    return false;
  }
  const isSilent = ([id, locked, from]) => id === chosen.id && locked === lock.number && from <= number;
  return [...underWay].flat().includes(chosen.id) || (answers.state(chosen.id, number) === undefined && !silent().some(isSilent));
}

function gone() {
  hasEnded = true;
  playback.play(false);
  const isKept = recording.session ? `: what was drawn is kept in ${recording.session}, and in` : ": what was drawn is in";
  say("", "connection");
  say(`host-sim has ended${isKept} the command line below. Start it again to go on.`, ENDED);
  draw();
}

// ---- drawing

// Returns the box of a target in the shown frame: the user's, else the tracker's.
const boxOf = (target) => boxIn(target, playback.shown);

function boxIn(target, number) {
  const answer = target && answers.at(target.id, number);
  const box = target && (lockIn(target, number)?.box ?? answer?.box);
  return box && !isGone(target, number) ? { box, state: answer?.state ?? "tracking" } : null;
}

function drawn(target) {
  const found = boxOf(target);
  const isChosen = target === edits.chosen;
  // Omits a box that the user drags, because it is drawn separately at its new position.
  if (found === null || (proposed !== null && pulled?.id === target.id)) {
    return [];
  }
  const { box, state } = found;
  const words = state === "tracking" ? nameOf(target) : `${nameOf(target)}: ${state}`;
  return [{ box, color: target.color, words, isChosen, isLast: state === "lost", hasHandles: isChosen }];
}

function trailOf(target) {
  const isThere = (found) => found !== null && found.state !== "lost";
  return (number) => (isThere(boxIn(target, number)) ? boxIn(target, number).box : null);
}

// Moves an enlarged view so that the chosen target, or the box that is drawn by keys, stays visible.
function follow() {
  const box = proposed ?? boxOf(edits.chosen)?.box;
  if (viewport.zoom > 1 && box && !drag.isPointing && (playback.isPlaying || proposed !== null)) {
    viewport.show(box);
  }
}

// Schedules a redraw: the frame at most once per animation frame, text and charts less often.
function draw() {
  drawing ??= requestAnimationFrame(() => {
    drawing = null;
    if (playback.image !== undefined) {
      follow();
      drawFrame();
    }
  });
  reading ??= setTimeout(() => {
    reading = null;
    drawReadings();
  }, READINGS_MS);
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

function drawFrame() {
  const { image, shown } = playback;
  const view = viewport.seen;
  const { chosen } = edits;
  const inOrder = [...edits.targets].sort((one, other) => (one === chosen) - (other === chosen));
  const color = (pulled === null ? chosen : targetOf(pulled.id))?.color ?? NEW_COLOR;
  if (kind === "recorded" && view.width < recording.width) {
    detail.want(shown, view, recording);
  }
  const under = (context, placed) => {
    detail.draw(context, shown, placed);
    if (byId("trail").checked) {
      edits.targets.forEach((target) => drawTrail(context, shown, { boxAt: trailOf(target), placed, color: target.color }));
    }
  };
  drawStage(byId("stage"), { image, size: size(), view, under, boxes: inOrder.flatMap(drawn), proposed, color });
}

// Returns the events of a target. They are cached for a while, because computing those of an hour of frames is slow.
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
  const { first, last, shown } = playback;
  drawTargets(chosen);
  timeline.draw({
    first, last, frame: shown ?? first, followed, timeOf,
    strips: edits.targets.map((target) => ({ name: nameOf(target), color: target.color, isChosen: target === chosen, states: (number) => answers.state(target.id, number) })),
    marks: chosen === null ? [] : events(chosen),
  });
  preview.draw({ ...hovered, image: playback.imageOf(hovered.number), size: recording, timeOf });
  drawEvents(byId("events"), allEvents(), { timeOf, goTo: visit, chosen: shown });
  drawChosen(chosen);
  drawControls(chosen);
  drawLimits(byId("files"), edits.targets.length);
  drawCommands(byId("commands"), kind === "live" ? { track: "" } : { view: "", track: "", report: "-o report.html" }, recording, edits.targets);
}

function drawTargets(chosen) {
  const named = edits.targets.map((target) => ({ ...target, name: nameOf(target) }));
  drawList(byId("targets"), { targets: named, chosen, choose, rename, remove: (target) => [edits.remove(target), changed()] });
  edits.targets.forEach((target, at) => {
    const state = isGone(target, playback.shown) ? "gone" : (answers.state(target.id, playback.shown) ?? "–");
    write(byId("targets").children[at].querySelector(".now"), state);
  });
}

const named = (number) => (number > playback.last ? "" : timeOf(number) === null ? String(number) : clock(timeOf(number)));

function drawChosen(chosen) {
  const { shown, first, last } = playback;
  drawFigures(byId("figures"), recording.method, chosen === null ? undefined : answers.at(chosen.id, shown));
  if (seesCurves() && shown !== null) {
    const end = Math.max(Math.min(shown + FRAMES / 2, last), Math.min(first + FRAMES - 1, Math.max(last, FRAMES)));
    const charts = chartsOf(byId("curves"), recording.method, chosen === null ? undefined : answers.around(chosen.id, end - FRAMES + 1, end));
    graph.draw({ charts, first: end - FRAMES + 1, last: end, now: shown, named, timeOf });
  }
}

function drawControls(chosen) {
  const { isPlaying, shown, frame, first, last } = playback;
  byId("newest").checked = playback.followsNewest;
  write(byId("play"), isPlaying ? "❚❚" : "▶");
  byId("play").setAttribute("aria-label", isPlaying ? "Pause" : "Play");
  const isHere = lockIn(chosen, shown) !== undefined;
  const isBegun = chosen !== null && chosen.locks[0].number < shown;
  const off = { back: frame <= first, on: frame >= last, undo: !edits.canUndo && proposed === null, redo: !edits.canRedo, unlock: !isHere, gone: !isBegun, add: chosen === null, stop: hasEnded };
  Object.entries(off).forEach(([id, isOff]) => (byId(id).disabled = isOff));
  write(byId("gone"), isGone(chosen, shown) ? "Back here" : "Gone from here");
  write(byId("whole"), `${viewport.zoom < 10 ? Number(viewport.zoom.toFixed(1)) : Math.round(viewport.zoom)}×`);
  write(byId("place"), shown === null ? "" : placed(shown));
  drawLoading();
  const lost = chosen === null ? undefined : events(chosen).find((event) => event.kind === "lost" && event.frame <= shown && shown <= event.until);
  write(byId("lost"), lost === undefined ? "" : `Lost since ${placeOf(lost.frame, timeOf)}. Drag a box over it to lock again.`);
  byId("lost").hidden = lost === undefined;
  write(byId("load"), load());
  write(byId("about"), about());
  byId("stage").setAttribute("aria-label", `Frame ${shown}, ${said(chosen)}`);
}

function drawLoading() {
  const { isLoading, isWaiting, frame, shown } = playback;
  if (frame === shown) {
    say("", "image");
  }
  loading = isLoading || isWaiting ? (loading ?? performance.now()) : null;
  const isLong = loading !== null && performance.now() - loading > LOADING_MS;
  write(byId("loading"), isLong ? (isLoading ? `Loading frame ${frame}` : `Waiting for ${nameOf(edits.chosen)} in frame ${frame + 1}`) : "");
  byId("loading").hidden = !isLong;
  if (loading !== null && !isLong) {
    setTimeout(draw, LOADING_MS);
  }
}

function placed(number) {
  const of = kind === "live" || recording.frames === null ? "" : ` of ${playback.last}`;
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
  const end = timeOf(playback.last);
  const long = kind === "live" || recording.frames === null ? "" : `, ${recording.frames} ${recording.frames === 1 ? "frame" : "frames"}${end === null ? "" : `, ${clock(end)}`}`;
  const kept = recording.session && edits.targets.length > 0 ? `. Your work is kept in ${recording.session}` : "";
  return `${recording.width}x${recording.height} pixels${long}${kept}`;
}

function load() {
  const { progress, live } = news;
  const dropped = live && `${droppedOf(live)}. The picture is ${Math.round(live.latency_ms)} ms old.`;
  const pace = progress?.rate >= 1 ? `, ${Math.round(progress.rate)} frames a second` : "";
  const following = !live && progress && `Following: frame ${progress.frame}${pace}.`;
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
  // Radio buttons handle the arrow keys themselves; buttons and links handle the space bar.
  const isOwn = key === " " ? target.matches("button, a, summary, input:not([type=range])") : target.matches("input[type=radio]");
  if (event.defaultPrevented || altKey) {
    return;
  }
  if (key === "Escape") {
    if (closed() || (!isTyping && escaped())) {
      event.preventDefault();
    }
  } else if (isTyping) {
    return;
  } else if (ctrlKey || metaKey) {
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
  const own = { Delete: unlock, Backspace: unlock, "?": () => byId("help").togglePopover() }[event.key];
  own?.();
  const isActed = own !== undefined || playback.key(event) || viewport.key(event);
  if (isActed) {
    say("");
  }
  return isActed;
}

// Closes the help or the menu of exports. Returns false if neither is open.
function closed() {
  const [help, menu] = [byId("help"), byId("export")];
  if (help.matches(":popover-open")) {
    help.hidePopover();
    return true;
  }
  const isOpen = menu.open;
  if (isOpen && menu.contains(document.activeElement)) {
    menu.firstElementChild.focus();
  }
  menu.open = false;
  return isOpen;
}

// Drops a box that is not taken yet or, if there is none, stops adding a target.
function escaped() {
  if (proposed !== null) {
    drag.drop();
  } else if (edits.chosen === null) {
    choose(edits.targets.at(-1) ?? null);
  }
  return true;
}

function listen() {
  const clicks = {
    back: () => visit(playback.frame - 1),
    on: () => visit(playback.frame + 1),
    play: () => playback.toggle(),
    smaller: () => viewport.smaller(),
    larger: () => viewport.larger(),
    whole: () => viewport.whole(),
    fresh: () => settle("fresh"),
    correct: () => settle("correct"),
    drop: () => drag.drop(),
    undo: () => undo(false),
    redo: () => undo(true),
    gone: goOrComeBack,
    unlock, stop,
    add: () => {
      choose(null);
      byId("stage").focus({ preventScroll: true });
    },
  };
  const listenTo = (event) => ([id, act]) =>
    byId(id).addEventListener(event, () => {
      say("");
      act();
    });
  Object.entries(clicks).forEach(listenTo("click"));
  const fields = {
    go: visitNamed,
    newest: () => {
      playback.followsNewest = byId("newest").checked;
      measure();
    },
    speed: () => playback.restart(),
    trail: draw,
    method: useMethod,
    settings: useMethod,
    boxes: () => read(byId("boxes").files[0]),
  };
  Object.entries(fields).forEach(listenTo("change"));
  document.addEventListener("keydown", pressed);
  addEventListener("beforeunload", (event) => source.hasWork && event.preventDefault());
  document.addEventListener("dragover", (event) => event.preventDefault());
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    [...event.dataTransfer.files].reduce((before, file) => before.then(() => read(file)), Promise.resolve());
  });
  document.addEventListener("pointerdown", ({ target }) => (byId("export").open &&= byId("export").contains(target)));
  byId("firmware").addEventListener("toggle", async () => {
    byId("firmware").lastElementChild.textContent = byId("firmware").open ? await trying(source.firmware()) : "";
  });
  new ResizeObserver(draw).observe(byId("stage"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
}

function useMethod() {
  Object.assign(recording, chosenTracker(recording));
  trying(source.method(recording.method, recording.options));
  // Closes the element `firmware`, because it shows the former settings.
  byId("firmware").open = false;
  showMethod();
  draw();
}

async function stop() {
  if ((await trying(source.stop())) !== "") {
    playback.play(false);
    say("Stopped. The last frames can still be looked through.", "source");
  }
}

async function trying(promise) {
  try {
    return await promise;
  } catch (error) {
    complain(error);
    return "";
  }
}

const TYPES = { csv: "text/csv", jsonl: "application/x-ndjson", smr: "application/octet-stream" };
/** Lets the browser save `content` (text, bytes or a blob) as the file `name`. */
function save(name, content) {
  const type = TYPES[name.split(".").at(-1)];
  const address = URL.createObjectURL(new Blob([content], { type }));
  htmlNode("a", { href: address, download: name }).click();
  // The address is revoked later, because the browser reads the file after this call.
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

async function take(format) {
  const file = await trying(source.boxes(format, edits.chosen));
  if (file !== "") {
    save(file.name, file.bytes);
    drawTaken(byId("made"), file.name);
  }
}

async function make(what, options) {
  const made = await trying(source.make(what, options));
  if (made !== "" && !byId(`made${made.id}`)) {
    drawMade(byId("made"), made, cancel);
  }
}

const cancel = (id) => trying(source.cancel(id));

// Reads a file that the user chose or dropped: boxes, or a video if the source accepts one.
async function read(file) {
  if (file === undefined) {
    return;
  }
  say("");
  byId("boxes").value = "";
  const targets = await trying(source.read(file));
  if (targets !== "") {
    edits.add(targets);
    await changed();
  }
}

function prepare() {
  playback = new Playback({
    image: (number) => source.image(number), isLive: () => kind === "live", timeOf, speed: () => Number(byId("speed").value),
    isHeld: () => proposed !== null, isAwaited, changed: draw, failed: ({ message }) => say(message, "image"), marks: () => allEvents().map((event) => event.frame),
    visited: (number) => source.place && trying(source.place(number)),
  });
  timeline = new Timeline(byId("timeline"), { goTo: visit, hover });
  preview = new Preview(byId("timeline"));
  drag = new Drag(byId("stage"), {
    size, start: startGrip, view: () => viewport.seen, grip: gripAt, click: clicked, lock,
    propose: (box, grip) => {
      if (box !== null && proposed === null) {
        say("");
      }
      [proposed, pulled] = [box, grip ?? asked?.grip ?? null];
      if (box === null) {
        ask(null);
      }
      draw();
    },
  });
  viewport = new Viewport(byId("stage"), { size, changed: draw, pinched: () => drag.drop() });
  graph = new Graph({ goTo: visit });
  seesCurves = inView(byId("curves"), draw);
}

// Resets the page for a recording or camera that the source has opened.
function opened(facts) {
  recording = { first: 1, ...facts };
  kind = recording.live ? "live" : "recorded";
  [news, followed, hasEnded, hovered, messages] = [{}, null, false, { number: null }, new Messages()];
  say("");
  document.querySelectorAll("[data-in]").forEach((node) => (node.hidden = node.dataset.in !== kind));
  document.title = recording.name;
  byId("name").textContent = recording.name;
  byId("version").textContent = recording.version;
  byId("stage").style.setProperty("--ratio", recording.width / recording.height);
  answers.keep([]);
  happened.clear();
  edits = new Edits();
  edits.load(recording.targets, recording.ids);
  detail = new Detail((number, part) => source.part(number, part), draw);
  showTracker(recording);
  drawMenu(byId("files"), recording, { take, make: kind === "live" || !recording.films ? undefined : make });
  playback.forget(recording.first, recording.first);
  viewport.whole();
  measure();
  playback.begin(recording.frame ?? playback.first);
  if (recording.plays && !matchMedia("(prefers-reduced-motion: reduce)").matches) {
    playback.play(true);
  }
}

function hover(number, x) {
  if (kind === "live") {
    return;
  }
  hovered = { number, x };
  playback.peek(number);
  draw();
}

/** Runs the application on a source. `openers` maps ids of buttons or fields to actions that open another source. */
export async function run(of, openers = {}) {
  try {
    source = of;
    const facts = await source.open();
    prepare();
    listen();
    opened(facts);
    Object.entries(openers).forEach(([id, act]) => byId(id).addEventListener(byId(id).type === "file" ? "change" : "click", () => trying(act())));
    await source.listen(heard, gone, () => playback.shown ?? playback.first);
  } catch (error) {
    document.body.classList.add("failed");
    say(error.message);
  }
}
