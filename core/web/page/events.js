// The events of a target with their frames: locks, corrections, losses and doubts, in a list that can be clicked.

import { htmlNode } from "./dom.js";

// A target that is uncertain or leaving for less than this is a flicker, which nobody would look for.
const LEAST_FRAMES = 10;
const AS_STATE = { locked: "tracking", corrected: "tracking", found: "tracking", back: "tracking" };

/**
 * The events of one target, each { kind, frame, until }: `kind` is locked, corrected, gone, back, lost, found, uncertain or
 * leaving, and `until` the last frame of it. `rows`: its answers { number, state } in the order of frames. `locks`: { number, box }, the same;
 * the box is null where the target is gone.
 */
export function eventsOf(rows, locks) {
  const events = locks.map((lock, at) => event(kindOf(lock, locks[at - 1]), lock.number));
  const isLock = new Set(locks.map(({ number }) => number));
  let last = null; // the span of equal states that goes on
  for (const { number, state } of rows) {
    if (state === last?.kind && !isLock.has(number)) {
      last.until = number;
      last.frames += 1;
      continue;
    }
    if (last?.kind === "lost" && state !== "lost" && !isLock.has(number)) {
      events.push(event("found", number));
    }
    addSpan(events, last);
    last = { ...event(state, number), frames: 1 };
  }
  addSpan(events, last);
  return events.sort((one, other) => one.frame - other.frame);
}

function kindOf({ box }, before) {
  if (box === null) {
    return "gone";
  }
  return before === undefined ? "locked" : before.box === null ? "back" : "corrected";
}

const event = (kind, frame) => ({ kind, frame, until: frame });

function addSpan(events, span) {
  if (span === null || span.kind === "tracking" || (span.kind !== "lost" && span.frames < LEAST_FRAMES)) {
    return;
  }
  const { kind, frame, until } = span;
  events.push({ kind, frame, until });
}

/** Seconds as minutes and seconds, 0:12.4, and with hours from one hour on, 1:02:03.4. */
export function clock(seconds) {
  const tenths = Math.round(seconds * 10);
  const whole = Math.floor(tenths / 10);
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  const two = (value) => String(value).padStart(2, "0");
  return `${hours > 0 ? `${hours}:${two(minutes)}` : minutes}:${two(whole % 60)}.${tenths % 10}`;
}

/** Where a frame is: 0:12.4 (frame 311). `timeOf(frame)` is its time in seconds, undefined or null if it is unknown. */
export function placeOf(frame, timeOf) {
  const time = timeOf?.(frame) ?? null;
  return time === null ? `frame ${frame}` : `${clock(time)} (frame ${frame})`;
}

/** An event in words: lost at 0:12.4. An event may have the `name` of its target. */
export function sentence({ kind, frame, name }, timeOf) {
  const time = timeOf?.(frame) ?? null;
  return `${name === undefined ? "" : `${name} `}${kind} at ${time === null ? `frame ${frame}` : clock(time)}`;
}

/**
 * Fills the list `place` with the events. A click on one calls `goTo(frame)`. The last one at or before the frame `chosen`
 * is marked. What is already there stays, so that it keeps the focus.
 */
export function drawEvents(place, events, { timeOf, goTo, chosen }) {
  const words = events.map((one) => sentence(one, timeOf));
  const isSame = (at) => place.children[at]?.textContent === words[at] && place.children[at].dataset.frame === String(events[at].frame);
  let same = 0;
  while (same < events.length && isSame(same)) {
    same += 1;
  }
  while (place.children.length > same) {
    place.lastElementChild.remove();
  }
  place.append(...events.slice(same).map((one, at) => item(one, words[same + at], goTo)));
  mark(place, events.findLastIndex(({ frame }) => frame <= chosen));
}

function item({ kind, frame }, words, goTo) {
  const button = htmlNode("button", { type: "button" }, htmlNode("span", { class: `key ${AS_STATE[kind] ?? kind}` }), words);
  button.addEventListener("click", () => goTo(frame));
  return htmlNode("li", { "data-frame": frame }, button);
}

function mark(place, at) {
  const wanted = place.children[at]?.firstElementChild ?? null;
  const marked = place.querySelector("[aria-current]");
  if (marked !== wanted) {
    marked?.removeAttribute("aria-current");
    wanted?.setAttribute("aria-current", "true");
  }
}
