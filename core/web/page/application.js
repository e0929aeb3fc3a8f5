// The application: shows the frames of a source (connection.js or local.js) with the targets' boxes, and handles the
// boxes that the user draws.

import { choose, dragOn, goOrComeBack, isAwaited, remove, rename, settle, undo, unlock } from "./boxes.js";
import { byId } from "./dom.js";
import { allEvents, draw, forget, prepareDrawing } from "./drawing.js";
import { drawMade, drawMenu } from "./exports.js";
import { cancel, make, read, take } from "./files.js";
import { pressed } from "./keys.js";
import { dropLength, measure as measureLength, takeLength } from "./length.js";
import { ENDED } from "./messages.js";
import { Playback, frameNamed } from "./playback.js";
import { answers, app, begin, focusStage, say, silent, size, targetOf, timeOf, trying } from "./state.js";
import { chosenTracker, showMethod, showTracker } from "./tracker-settings.js";
import { Truth } from "./truth.js";
import { Viewport } from "./viewport.js";

const MAX_LATE = 50; // frames

const clamp = (value, least, most) => Math.min(Math.max(value, least), most);

// ---- frames

function visit(number) {
  say("");
  app.drag.drop();
  app.playback.visit(number);
}

function visitNamed() {
  const { playback } = app;
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

// ---- messages from the source

function heard(told) {
  if (told.opened !== undefined) {
    // The frame number in the address was for the former source.
    history.replaceState(null, "", "#");
    opened(told.opened);
    return;
  }
  app.news = { ...told, live: told.live ?? app.news.live };
  say("", "connection");
  answers.clear(told.clear ?? []);
  answers.take(told.rows);
  app.followed = told.followed > 0 ? app.recording.first + told.followed - 1 : null;
  for (const fact of ["frames", "times", "words"]) {
    app.recording[fact] = told[fact] ?? app.recording[fact];
  }
  app.recording.session = told.session;
  app.recording.length = told.length ?? null;
  if (told.targets !== undefined) {
    app.edits.load(told.targets, told.ids);
    answers.keep(app.edits.targets.map(({ id }) => id));
    if (app.asked?.id && targetOf(app.asked.id) === null) {
      app.drag.drop();
    }
  }
  if (silent().length === 0) {
    say("", "silence");
  }
  if (told.said !== undefined) {
    say(told.said, told.cause ?? (app.kind === "live" ? "source" : silent().length > 0 ? "silence" : "act"));
  }
  told.exports?.forEach((one) => drawMade(byId("made"), one, cancel));
  measure();
  draw();
}

// Updates the range of frames that can be shown.
function measure() {
  const { kind, news, playback, recording, followed } = app;
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
      playback.goTo(app.edits.targets.length === 0 || followed === null ? newest : clamp(followed, newest - MAX_LATE, newest));
    }
  }
}

function gone() {
  const { playback, recording } = app;
  app.hasEnded = true;
  playback.play(false);
  const isKept = recording.session ? `: what was drawn is kept in ${recording.session}, and in` : ": what was drawn is in";
  say("", "connection");
  say(`host-sim has ended${isKept} the command line below. Start it again to go on.`, ENDED);
  draw();
}

// ---- actions of the user

function listen() {
  const clicks = {
    back: () => visit(app.playback.frame - 1),
    on: () => visit(app.playback.frame + 1),
    play: () => app.playback.toggle(),
    smaller: () => app.viewport.smaller(),
    larger: () => app.viewport.larger(),
    whole: () => app.viewport.whole(),
    fresh: () => settle("fresh"),
    correct: () => settle("correct"),
    drop: () => app.drag.drop(),
    undo: () => undo(false),
    redo: () => undo(true),
    gone: goOrComeBack,
    unlock, stop, dropLength,
    length: measureLength,
    add: () => {
      choose(null);
      focusStage();
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
      app.playback.followsNewest = byId("newest").checked;
      measure();
    },
    speed: () => app.playback.restart(),
    trail: draw,
    curve: draw,
    method: useMethod,
    settings: useMethod,
    boxes: () => read(byId("boxes").files[0]),
  };
  Object.entries(fields).forEach(listenTo("change"));
  listenTo("submit")(["measured", takeLength]);
  document.addEventListener("keydown", pressed);
  addEventListener("beforeunload", (event) => app.source.hasWork && event.preventDefault());
  document.addEventListener("dragover", (event) => event.preventDefault());
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    [...event.dataTransfer.files].reduce((before, file) => before.then(() => read(file)), Promise.resolve());
  });
  document.addEventListener("pointerdown", ({ target }) => (byId("export").open &&= byId("export").contains(target)));
  byId("firmware").addEventListener("toggle", async () => {
    byId("firmware").lastElementChild.textContent = byId("firmware").open ? await trying(app.source.firmware()) : "";
  });
  new ResizeObserver(draw).observe(byId("stage"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
}

function useMethod() {
  const { edits, recording } = app;
  edits.forget();
  Object.assign(recording, chosenTracker(recording));
  trying(app.source.method(recording.method, recording.options));
  // Closes the element `firmware`, because it shows the former settings.
  byId("firmware").open = false;
  showMethod();
  draw();
}

async function stop() {
  if ((await trying(app.source.stop())) !== "") {
    app.playback.play(false);
    say("Stopped. The last frames can still be looked through.", "source");
  }
}

function prepare() {
  app.playback = new Playback({
    image: (number) => app.source.image(number), isLive: () => app.kind === "live", timeOf, speed: () => Number(byId("speed").value),
    isHeld: () => app.proposed !== null, isAwaited, changed: draw, failed: ({ message }) => say(message, "image"), marks: () => allEvents().map((event) => event.frame),
    visited: (number) => app.source.place && trying(app.source.place(number)),
  });
  app.drag = dragOn(byId("stage"));
  app.viewport = new Viewport(byId("stage"), { size, changed: draw, pinched: () => app.drag.drop() });
  prepareDrawing({ visit, choose, rename, remove });
  app.truth.prepare();
}

// Resets the page for a recording or camera that the source has opened.
function opened(facts) {
  app.drag.drop();
  app.measured = null;
  begin(facts);
  const { recording, playback, kind } = app;
  say("");
  document.querySelectorAll("[data-in]").forEach((node) => (node.hidden = node.dataset.in !== kind));
  // Of several recordings, the links to all call each by a name of its own.
  document.title = byId("name").textContent = document.querySelector("nav [aria-current]")?.textContent ?? recording.name;
  byId("version").textContent = recording.version;
  byId("stage").style.setProperty("--ratio", recording.width / recording.height);
  forget();
  showTracker(recording);
  drawMenu(byId("files"), recording, { take, make: kind === "live" || !recording.films ? undefined : make });
  playback.forget(recording.first, recording.first);
  app.viewport.whole();
  measure();
  playback.begin(recording.frame ?? playback.first);
  if (recording.plays && !matchMedia("(prefers-reduced-motion: reduce)").matches) {
    playback.play(true);
  }
}

function open(act) {
  // What was looked at belongs to the former source.
  app.truth.send();
  trying(act());
}

/** Runs the application on a source. `openers` maps ids of buttons or fields to actions that open another source. */
export async function run(of, openers = {}) {
  try {
    [app.source, app.truth] = [of, new Truth()];
    const facts = await app.source.open();
    prepare();
    listen();
    opened(facts);
    Object.entries(openers).forEach(([id, act]) => byId(id).addEventListener(byId(id).type === "file" ? "change" : "click", () => open(act)));
    await app.source.listen(heard, gone, () => app.playback.shown ?? app.playback.first);
  } catch (error) {
    document.body.classList.add("failed");
    say(error.message);
  }
}
