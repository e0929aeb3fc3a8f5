// Events of a target (locks, corrections, losses, doubts) with their frames, and a clickable list of them.

import { htmlNode } from "./dom.js";

// Minimum length in frames of an event in which a target is uncertain or leaving; a shorter one is flicker.
const MIN_FRAMES = 10;
const AS_STATE = { locked: "tracking", corrected: "tracking", found: "tracking", back: "tracking" };

/**
 * Returns the events of one target: { kind, frame, until }. `kind` is locked, corrected, gone, back, lost, found,
 * uncertain or leaving; `until` is the event's last frame. `rows` are the answers { number, state } and `locks` the
 * boxes { number, box }, by ascending frame number; a null box means that the target is gone.
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
  if (span === null || span.kind === "tracking" || (span.kind !== "lost" && span.frames < MIN_FRAMES)) {
    return;
  }
  const { kind, frame, until } = span;
  events.push({ kind, frame, until });
}

/** Formats seconds as 0:12.4, or with hours as 1:02:03.4. */
export function clock(seconds) {
  const tenths = Math.round(seconds * 10);
  const whole = Math.floor(tenths / 10);
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  const two = (value) => String(value).padStart(2, "0");
  return `${hours > 0 ? `${hours}:${two(minutes)}` : minutes}:${two(whole % 60)}.${tenths % 10}`;
}

/** Formats a frame's position as `0:12.4 (frame 311)`. `timeOf(frame)` is in seconds, or null if unknown. */
export function placeOf(frame, timeOf) {
  const time = timeOf?.(frame) ?? null;
  return time === null ? `frame ${frame}` : `${clock(time)} (frame ${frame})`;
}

/** Formats an event as `lost at 0:12.4`, or as `lost at frame 311` if the time is unknown; puts `name`, if any, first. */
export function sentence({ kind, frame, name }, timeOf) {
  const time = timeOf?.(frame) ?? null;
  return `${name === undefined ? "" : `${name} `}${kind} at ${time === null ? `frame ${frame}` : clock(time)}`;
}

/**
 * Fills the list element `place` with events. A click on one calls `goTo(frame)`. The last event at or before frame
 * `chosen` is marked, and the list scrolls to it. Unchanged items are not replaced, so that they keep the keyboard focus.
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
    if (wanted !== null) {
      reveal(place, wanted);
    }
  }
}

/** Scrolls a list, but not the page, as little as `node` needs to be seen. */
export function reveal(place, node) {
  const [list, { top, bottom }] = [place.getBoundingClientRect(), node.getBoundingClientRect()];
  place.scrollTop += Math.min(top - list.top, 0) + Math.max(bottom - list.bottom, 0);
}
