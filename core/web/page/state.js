// The state of the application, which all of its parts share, and what follows from it: the time of a frame, the box of
// a target in it, and the sentence that is said to the user.

import { Answers } from "./answers.js";
import { byId } from "./dom.js";
import { Edits, isGone, isHidden, lineIn, lockIn } from "./edits.js";
import { Messages } from "./messages.js";

export const answers = new Answers();
export const app = {
  edits: null, // see edits.js
  source: null, // see connection.js
  recording: null, // the facts that it opened with
  kind: null, // recorded or live
  followed: null, // the last frame that all targets have answers for
  news: {},
  proposed: null, // a box that is being drawn
  pulled: null, // the grip that it is pulled by
  measured: null, // a length that is being measured: { line, drawn }, its line and the one under the pointer
  asked: null, // a box of which the user has to say what it is for: { box, grip, id, first }
  hovered: { number: null }, // the frame under the mouse on the timeline
  hasEnded: false,
  messages: new Messages(),
  playback: null,
  viewport: null,
  drag: null,
  truth: null, // see truth.js
};

/** Resets the state for a recording or camera with these facts. */
export function begin(facts) {
  const recording = { first: 1, ...facts };
  const edits = new Edits();
  const kind = recording.live ? "live" : "recorded";
  Object.assign(app, { recording, edits, kind, news: {}, followed: null, hasEnded: false, hovered: { number: null }, measured: null, messages: new Messages() });
  answers.keep([]);
  edits.load(recording.targets, recording.ids);
}

// The sentence of the cause "act" is about the user's last action.
export function say(text, cause = "act") {
  app.messages.say(text, cause);
  write(byId("said"), app.messages.text);
  byId("said").hidden = app.messages.text === "";
}

export function complain({ message, cause }) {
  const isGone = cause === "connection";
  if (!isGone || !app.hasEnded) {
    say(message, isGone ? cause : "act");
  }
}

export async function trying(promise) {
  try {
    return await promise;
  } catch (error) {
    complain(error);
    return "";
  }
}

export function write(node, text) {
  if (node.textContent !== text) {
    node.textContent = text;
  }
}

/** Lets the user draw by keys. The page scrolls no further than the picture needs to be seen. */
export function focusStage() {
  byId("stage").focus({ preventScroll: true });
  byId("stage").scrollIntoView({ block: "nearest" });
}

export const size = () => (app.playback.shown === null ? null : { width: app.recording.width, height: app.recording.height });

export const timeOf = (number) => app.recording.timeOf?.(number) ?? app.recording.times?.[number - app.recording.first] ?? (app.recording.rate ? (number - app.recording.first) / app.recording.rate : null);

export function whole({ x, y, width, height }) {
  return { x: Math.round(x), y: Math.round(y), width: Math.round(width), height: Math.round(height) };
}

export const targetOf = (id) => app.edits.targets.find((target) => target.id === id) ?? null;

// True if the requested frame is shown: a click while it is still loading refers to no frame.
export const isThere = () => app.kind === "live" || app.playback.isPlaying || !app.playback.isLoading;

// Lists where the answers of a target end early: [id, frame of its lock, first frame without an answer].
export const silent = () => app.news.silent ?? [];

// Returns the box of a target in the shown frame: the user's, else that on the user's line, else the tracker's.
export const boxOf = (target) => boxIn(target, app.playback.shown);

export function boxIn(target, number) {
  const answer = target && answers.at(target.id, number);
  const own = target && (lockIn(target, number)?.box ?? lineIn(target, number));
  const box = own ?? answer?.box;
  const state = target && isHidden(target, number) ? "hidden" : own ? "tracking" : answer?.state;
  return box && !isGone(target, number) ? { box, state: state ?? "tracking" } : null;
}
