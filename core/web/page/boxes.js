// The boxes that the user draws: what each is for, and the change of the targets that it makes.

import { byId } from "./dom.js";
import { Drag, gripOf, inside } from "./drag.js";
import { draw } from "./drawing.js";
import { isGone, lockIn, nameOf } from "./edits.js";
import { lineDrag, useLength } from "./length.js";
import { doubtOf, slipOf } from "./question.js";
import { answers, app, boxOf, complain, isThere, say, silent, size, targetOf, whole, write } from "./state.js";

let sent = []; // the targets that were sent last
const underWay = new Set(); // lists of ids of targets whose change the source has not answered yet

// Returns the grip from which drawing by keys starts: the inside of the chosen target's box or, with the id null, of a
// box in the middle of the view.
function startGrip() {
  const { x, y, width, height } = app.viewport.seen;
  const found = boxOf(app.edits.chosen);
  const box = found?.box ?? { x: x + width * 0.375, y: y + height * 0.375, width: width / 4, height: height / 4 };
  return { box: whole(box), held: [0, 0], id: found && app.edits.chosen.id };
}

// Returns the box at a point and the part of it to drag: only the chosen target has edges and corners to drag. Returns
// null while a target is being added, so that every drag draws a box.
function gripAt(point, reach) {
  const chosen = app.edits.chosen;
  for (const target of chosen === null ? [] : [chosen, ...app.edits.targets]) {
    const box = boxOf(target)?.box;
    const held = box && gripOf(box, point, target === chosen ? reach : 0);
    if (held) {
      return { box: whole(box), held, id: target.id };
    }
  }
  return null;
}

function clicked(point) {
  const target = app.edits.targets.find((one) => boxOf(one) !== null && gripOf(boxOf(one).box, point, 0) !== null);
  if (target !== undefined) {
    choose(target);
  }
}

export function choose(target) {
  say("");
  app.edits.choose(target);
  draw();
}

// Takes a box that the user has drawn, or pulled by a grip. Returns false if the user must say first what it is for.
function lock(box, grip) {
  const { asked, edits } = app;
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
  const doubt = target === null ? slipOf(box) : doubtOf(box, { name: nameOf(target), isPulled: held !== null, ...formerOf(target, held) });
  if (doubt) {
    ask({ box, grip: held, id: target?.id ?? null, first: held === null ? "fresh" : "correct" }, doubt);
    return false;
  }
  lockOn(box, target, held !== null);
  return true;
}

// Returns the box that a target had before the user's: the pulled one, its box in the shown frame, or else its nearest
// known one; null if the target is gone.
function formerOf(target, grip) {
  const here = app.playback.shown;
  if (grip !== null || isGone(target, here)) {
    return { former: grip?.box ?? null };
  }
  const { number, box } = target.locks.findLast((one) => one.number <= here) ?? target.locks[0];
  const found = boxOf(target) ?? answers.last(target.id, number, here) ?? { box };
  return { former: whole(found.box), isLost: ["lost", "hidden"].includes(found.state) };
}

function lockOn(box, target, isPulled) {
  app.edits.lock(app.playback.shown, box, target);
  changed();
  if (!isPulled && app.kind === "recorded" && byId("plays").checked) {
    // Deferred, because playback cannot leave the frame until the drawn box is cleared.
    queueMicrotask(() => app.playback.play(true));
  }
}

// Shows or, for null, hides the question what a box is for.
function ask(what, words = "") {
  app.asked = what;
  byId("asked").hidden = what === null;
  byId("asked").firstElementChild.textContent = words;
  if (what !== null) {
    byId("correct").hidden = what.id === null;
    write(byId("correct"), what.id === null ? "" : `Correct ${nameOf(targetOf(what.id))}`);
    byId("asked").insertBefore(byId(what.first), byId("asked").querySelector("button"));
  }
}

export function settle(answer) {
  const { box, grip, id } = app.asked;
  lockOn(box, answer === "fresh" ? null : targetOf(id), grip !== null);
}

export function unlock() {
  const { edits, playback } = app;
  if (isThere() && lockIn(edits.chosen, playback.shown) !== undefined) {
    edits.unlock(edits.chosen, playback.shown);
    changed();
  }
}

// Marks the chosen target as gone from the shown frame on or, if it is gone, locks it again on its last box.
export function goOrComeBack() {
  const { edits, playback, recording } = app;
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

export function undo(isRedo) {
  const { drag, edits, proposed } = app;
  // A box that waits for an answer or for Enter is undone first.
  if (proposed !== null && !isRedo) {
    drag.drop();
  } else if (isRedo ? edits.canRedo : edits.canUndo) {
    const now = app.recording.length ?? null;
    const length = isRedo ? edits.redo(now) : edits.undo(now);
    length === undefined ? changed() : useLength(length);
  }
}

export function rename(target, text) {
  const refused = app.edits.rename(target, text);
  refused === null ? changed() : say(refused);
}

// Sends the whole list of targets to the source after a change, and reverts the change if the source refuses it.
export async function changed() {
  const { targets } = app.edits;
  say("");
  app.drag.drop();
  draw();
  const ids = targets.filter((target) => !sent.includes(target)).map(({ id }) => id);
  underWay.add(ids);
  sent = targets;
  try {
    await app.source.targets(targets, app.edits.ids, app.edits.checked);
    answers.keep(app.edits.targets.map(({ id }) => id));
  } catch (error) {
    app.edits.takeBack(targets);
    complain(error);
    draw();
  } finally {
    underWay.delete(ids);
  }
}

// True while the chosen target's answer in a frame is still to come: playback must not pass it.
export function isAwaited(number) {
  const { chosen } = app.edits;
  const lock = chosen?.locks.findLast((one) => one.number <= number);
  if (app.kind === "live" || app.hasEnded || !lock?.box) {
    return false;
  }
  const isSilent = ([id, locked, from]) => id === chosen.id && locked === lock.number && from <= number;
  return [...underWay].flat().includes(chosen.id) || (answers.state(chosen.id, number) === undefined && !silent().some(isSilent));
}

export function remove(target) {
  app.edits.remove(target);
  changed();
}

const boxDrag = { size, start: startGrip, view: () => app.viewport.seen, grip: gripAt, click: clicked, lock, propose };

/** Returns the drags on the element `stage` by which the user draws boxes, or the line of a length. */
export const dragOn = (stage) => new Drag(stage, () => (app.measured === null ? boxDrag : lineDrag));

function propose(box, grip) {
  if (box !== null && app.proposed === null) {
    say("");
  }
  [app.proposed, app.pulled] = [box, grip ?? app.asked?.grip ?? null];
  if (box === null) {
    ask(null);
  }
  draw();
}
