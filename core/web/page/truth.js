// The truth about the targets, which `host-sim view` writes as a recording for `host-sim eval`, and the page into a session:
// boxes by hand, lines between them, frames in which a target is hidden or gone, and what the user has looked at of the
// tracker's boxes.

import { changed, goOrComeBack, isAwaited } from "./boxes.js";
import { byId, htmlNode } from "./dom.js";
import { draw, events } from "./drawing.js";
import { isGone, isHidden, lineIn, lockIn } from "./edits.js";
import { placeOf } from "./events.js";
import { MAX_STEP } from "./playback.js";
import { lengthOf, minus, plus, rangeOf } from "./ranges.js";
import { answers, app, say, timeOf, trying, write } from "./state.js";

const REST_MS = 300; // a frame that is shown for this long was looked at
const SEND_MS = 1000;
const COUNT_MS = 400;
// A box that moves by more than this part of its side, or grows by more than this factor, from one frame to the next.
const JUMP = 0.5, GROWTH = 1.2;
const DOUBTS = { lost: "The target is lost", uncertain: "The tracker is uncertain", leaving: "The target leaves the picture", jump: "The box jumps", size: "The size changes" };
const ADVICE = "draw its box, or press H if it is hidden, G if it is gone.";

export class Truth {
  #last = null; // what was looked at last: { number, locks, isPlaying }
  #resting = null;
  #sending = null;
  #unsent = new Set(); // ids of targets
  #known = null; // the last result of `#count`, with what it was made of
  #hint = null; // { number, target, text }: a sentence about a target in a frame

  /** Makes the buttons. */
  prepare() {
    const button = (id, title, text, act) => {
      const node = htmlNode("button", { type: "button", id, title }, text);
      node.addEventListener("click", act);
      return node;
    };
    byId("truth").append(
      htmlNode("output", { id: "share", title: "Frames in which you have looked at this target's box, or said where it is" }),
      button("look", "Go to the next frame that is not checked (N)", "Next", () => this.next()),
      button("line", "The boxes between two of yours lie on a line between them (B)", "By hand", () => this.line()),
      button("hide", "Something covers the target: from here, or up to here (H)", "Hidden", () => this.hide()),
    );
  }

  key({ key, shiftKey }) {
    const act = shiftKey ? undefined : { n: () => this.next(), b: () => this.line(), h: () => this.hide(), g: () => byId("gone").disabled || goOrComeBack() }[key];
    if (act === undefined || app.kind === "live") {
      return false;
    }
    // A key that acts clears the former sentence first.
    queueMicrotask(act);
    return true;
  }

  /** Returns the instruction for the shown frame. */
  get hint() {
    const { number, target, text } = this.#hint ?? {};
    return number === app.playback.shown && target === app.edits.chosen ? text : "";
  }

  /** Notes that the shown frame is looked at, with the box of the chosen target. Call it whenever a frame is drawn. */
  look() {
    const { playback, edits } = app;
    const [{ chosen }, number, last] = [edits, playback.shown, this.#last];
    if (chosen === null || app.kind === "live" || isAwaited(number)) {
      return;
    }
    const by = last?.locks === chosen.locks ? number - last.number : 0;
    const wasPlaying = by === 0 ? playback.isPlaying : last.isPlaying;
    this.#last = { number, locks: chosen.locks, isPlaying: playback.isPlaying };
    if (by === 0 && last?.locks === chosen.locks) {
      return;
    }
    clearTimeout(this.#resting);
    if (wasPlaying && by > 0 && by <= MAX_STEP) {
      this.#check(chosen, last.number + 1, number);
    } else if (wasPlaying || Math.abs(by) === 1) {
      this.#check(chosen, number, number);
    } else {
      const isStill = () => playback.shown === number && edits.chosen?.locks === chosen.locks;
      this.#resting = setTimeout(() => isStill() && this.#check(chosen, number, number), REST_MS);
    }
  }

  #check(target, first, to) {
    const [{ id, locks }, { edits }] = [target, app];
    const from = Math.max(first, locks[0].number);
    if (from > to) {
      return;
    }
    edits.check(target, from, to);
    draw();
    this.#unsent.add(id);
    this.#sending ??= setTimeout(() => this.send(), SEND_MS);
  }

  /** Sends what is checked to the source, without waiting for more. */
  async send() {
    clearTimeout(this.#sending);
    this.#sending = null;
    const ids = app.edits.targets.map(({ id }) => id).filter((id) => this.#unsent.has(id));
    this.#unsent.clear();
    // What is checked now: a change of boxes meanwhile has taken frames away.
    await Promise.all(ids.map((id) => trying(app.source.checked(id, app.edits.checked.get(id) ?? []))));
  }

  /** Returns what the timeline shows of a target: the ranges that are known, hidden, and on a line. */
  marks(target) {
    const lines = target.locks.flatMap(({ number, byHand }, at) => (byHand ? [[number, target.locks[at + 1].number]] : []));
    return { known: this.#count(target), hidden: target.hidden, lines };
  }

  draw(chosen) {
    const { shown, last } = app.playback;
    byId("truth").hidden = chosen === null || app.kind === "live";
    if (chosen === null || shown === null) {
      return;
    }
    const all = last - chosen.locks[0].number + 1;
    const known = lengthOf(this.#count(chosen));
    write(byId("share"), `${Math.floor((100 * known) / Math.max(all, 1))} % checked`);
    const line = this.#lineHere(chosen);
    byId("line").disabled = line === undefined;
    byId("line").setAttribute("aria-pressed", line?.[0].byHand === true);
    byId("hide").disabled = chosen.locks[0].number >= shown || isGone(chosen, shown);
    byId("hide").setAttribute("aria-pressed", isHidden(chosen, shown));
  }

  // Returns the ranges of frames in which the truth is known. They are counted at most every COUNT_MS.
  #count(target) {
    const { last } = app.playback;
    const of = { target, last, version: answers.version(target.id), checked: app.edits.checked.get(target.id) ?? [] };
    const isSame = (name) => this.#known?.of[name] === of[name];
    if (Object.keys(of).every(isSame)) {
      return this.#known.ranges;
    }
    if (isSame("target") && performance.now() - this.#known.at < COUNT_MS) {
      setTimeout(draw, COUNT_MS);
      return this.#known.ranges;
    }
    const seen = [];
    for (const [from, to] of of.checked) {
      for (let number = from; number <= Math.min(to, last); number++) {
        const state = answers.state(target.id, number);
        if ((state === undefined || state === "lost") && !isTold(target, number)) {
          continue;
        }
        seen.at(-1)?.[1] === number - 1 ? (seen.at(-1)[1] = number) : seen.push([number, number]);
      }
    }
    const ranges = target.locks.reduce((all, { number }) => plus(all, number, number), seen);
    this.#known = { of, ranges, at: performance.now() };
    return ranges;
  }

  /** Goes to the next doubt in frames that are not checked; if there is none, plays from the first such frame. */
  next() {
    const { edits, playback } = app;
    const { chosen } = edits;
    if (chosen === null) {
      return;
    }
    this.#known = null;
    const known = this.#count(chosen);
    const open = known.reduce((left, [from, to]) => minus(left, from, to), [[chosen.locks[0].number, playback.last]]);
    const isDoubt = (number) => rangeOf(open, number) !== undefined && !isTold(chosen, number);
    const doubts = doubtsOf(chosen, open).flatMap(({ kind, frame, until }) => {
      const number = Array.from({ length: until - frame + 1 }, (_, at) => frame + at).find(isDoubt);
      return number === undefined ? [] : [{ kind, number }];
    });
    doubts.sort((one, other) => one.number - other.number);
    const next = doubts.find(({ number }) => number > playback.frame) ?? doubts[0] ?? open.map(([number]) => ({ kind: "unseen", number }))[0];
    if (next === undefined) {
      say(`All frames are checked: Files, ${app.source.make ? "Recording with truth" : "Session"}.`);
      return;
    }
    playback.visit(next.number);
    if (next.kind === "unseen") {
      playback.play(true);
      return;
    }
    this.#hint = { number: next.number, target: chosen, text: `${DOUBTS[next.kind]}: ${next.kind === "lost" ? ADVICE : "if the box is wrong, correct it."}` };
    draw();
  }

  // Returns the box that begins the line through the shown frame, or to it; while it plays, else the last line before it:
  // playing begins when a box is drawn.
  #lineHere({ locks }) {
    const { shown, isPlaying } = app.playback;
    const at = locks.findLastIndex(({ number }) => number < shown);
    const pairs = [locks.slice(at, at + 2), isPlaying ? locks.slice(Math.max(at - 1, 0), at + 1) : []];
    return pairs.find((pair) => at >= 0 && pair.length === 2 && pair.every(({ box }) => box));
  }

  line() {
    const { chosen } = app.edits;
    const [from, to] = (chosen && this.#lineHere(chosen)) ?? [];
    if (!from) {
      say("Draw a box in an earlier frame and one in a later frame: between two, the boxes can lie on a line.");
      return;
    }
    if (to.number < app.playback.shown) {
      app.playback.visit(to.number); // The user sees what changes.
    }
    app.edits.setByHand(chosen, from.number, !from.byHand);
    changed();
  }

  // Begins or ends a range in which the target is hidden: up to the frame before this one, or from here until the target
  // is tracked again, has a box by hand, or the recording ends.
  hide() {
    const { edits, playback } = app;
    const [{ chosen }, here] = [edits, playback.shown];
    if (chosen === null || byId("hide").disabled) {
      return;
    }
    const range = rangeOf(chosen.hidden, here);
    if (range !== undefined) {
      edits.setHidden(chosen, minus(chosen.hidden, here, range[1]));
    } else {
      const lost = events(chosen).find(({ kind, frame, until }) => kind === "lost" && frame <= here && here <= until);
      const drawn = chosen.locks.find(({ number }) => number > here)?.number ?? Infinity;
      const [from, to] = [lockIn(chosen, here) ? here + 1 : here, Math.min(lost?.until ?? playback.last, drawn - 1)];
      if (from > to) {
        return;
      }
      edits.setHidden(chosen, plus(chosen.hidden, from, to));
      this.#hint = { number: here, target: edits.chosen, text: `Hidden up to ${placeOf(to, timeOf)}: where it is visible before, press H again.` };
    }
    changed();
  }
}

// True if the user says what is true in a frame, whatever the tracker answers.
const isTold = (target, number) => lockIn(target, number) !== undefined || isGone(target, number) || isHidden(target, number) || lineIn(target, number) !== undefined;

// Returns the frames of a target in which its box may be wrong: { kind, frame, until }.
function doubtsOf(target, open) {
  const doubts = events(target).filter(({ kind }) => kind in DOUBTS);
  for (const [from, to] of open) {
    let before = answers.at(target.id, from - 1);
    for (let number = from; number <= to; number++) {
      const now = answers.at(target.id, number);
      const kind = before && now && !isTold(target, number) && changeOf(before.box, now.box);
      if (kind) {
        doubts.push({ kind, frame: number, until: number });
      }
      before = now;
    }
  }
  return doubts;
}

function changeOf(before, now) {
  const sides = ({ width, height }) => Math.sqrt(width * height);
  const way = Math.hypot(now.x + now.width / 2 - before.x - before.width / 2, now.y + now.height / 2 - before.y - before.height / 2);
  const growth = sides(now) / sides(before);
  return way > JUMP * sides(before) ? "jump" : Math.max(growth, 1 / growth) > GROWTH ? "size" : null;
}
