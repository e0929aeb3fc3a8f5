// Formats the trackers' answers as `host-sim track --format csv` and `host-sim track --json` do.

import { isHidden, lineIn, lockIn } from "./edits.js";
import { centreOf, speedOf } from "./movement.js";

const CSV_NAMES = "frame,time,x,y,width,height,state,confidence,ratio,runner_up_ratio,alpha,identity,scale,work,centre_x,centre_y,speed";
const METRE_NAMES = ",centre_x_m,centre_y_m,speed_m_s";

const NOWHERE = { x: 0, y: 0, width: 0, height: 0 };

// Rounds to six decimals, and halves away from zero, as host-sim does.
const rounded = (value, unit) => (Number.isFinite(value) ? (Math.sign(value) * Math.round(Math.abs(value / unit) * 1e6)) / 1e6 : null);

/**
 * Returns a target's row as the user says it: with the box on a line between two of theirs, or without one where something
 * hides the target; elsewhere, and in the frame of a box, as the tracker says it.
 */
export function saidOf(target, row) {
  const { number } = row;
  if (lockIn(target, number) !== undefined) {
    return row;
  }
  if (isHidden(target, number)) {
    return { number, state: "lost", box: NOWHERE, fineBox: NOWHERE };
  }
  const box = lineIn(target, number);
  const sides = (change) => Object.fromEntries(Object.entries(box).map(([side, value]) => [side, change(value)]));
  return box === undefined ? row : { number, state: "tracking", box: sides(Math.round), fineBox: sides((value) => 256 * value) };
}

/**
 * Returns CSV with the answers of all targets, by frame. `named` is a list of [name, rows], each row { number, state,
 * box, fineBox, ... }; `timeOf(frame)` is the time of a frame in seconds, or null. `length` is the known length in the
 * picture, if any.
 */
export function csv(named, timeOf, length) {
  const isNamed = named.length > 1;
  const formers = new Map();
  const lines = inOrder(named).map(([name, row]) => {
    const line = csvLine(row, timeOf, formers.get(name), length?.pixels_per_metre);
    formers.set(name, row);
    return `${isNamed ? `${name},` : ""}${line}\n`;
  });
  return `${isNamed ? "target," : ""}${CSV_NAMES}${length ? METRE_NAMES : ""}\n${lines.join("")}`;
}

/** Returns one JSON object per line, with the fields of `origin` first. */
export function json(named, origin, timeOf) {
  const isNamed = named.length > 1;
  return inOrder(named).map(([name, row]) => `${JSON.stringify({ ...origin, ...(isNamed ? { target: name } : {}), ...ofRow(row, timeOf) })}\n`).join("");
}

function inOrder(named) {
  const all = named.flatMap(([name, rows]) => rows.map((row) => [name, row]));
  return all.sort(([, one], [, other]) => one.number - other.number);
}

function csvLine(row, timeOf, former, per) {
  const { frame, time, state, fine, confidence, ratio, runner_up_ratio, alpha, identity, scale, work } = ofRow(row, timeOf);
  const box = fine === null ? ["", "", "", ""] : [fine.x, fine.y, fine.width, fine.height];
  const centre = ({ number, state, fineBox }) => (state === "lost" ? null : centreOf(fineBox, rounded(timeOf(number) ?? NaN, 1), 256));
  const [before, now] = [former?.number === row.number - 1 ? centre(former) : null, centre(row)];
  const speed = (per) => rounded(speedOf(before, now, per) ?? NaN, 1);
  const moved = [now?.x, now?.y, speed(1), ...(per ? [rounded(now?.x, per), rounded(now?.y, per), speed(per)] : [])];
  return [frame, time, ...box, state, confidence, ratio, runner_up_ratio, alpha, identity, scale, work, ...moved].map((value) => value ?? "").join(",");
}

function ofRow({ number, state, box: { x, y, width, height }, fineBox: fine, alpha, foundAgain, work, ...row }, timeOf) {
  const isLost = state === "lost";
  return {
    frame: number,
    time: rounded(timeOf(number) ?? NaN, 1),
    state,
    box: isLost ? null : { x, y, width, height },
    fine: isLost ? null : { x: fine.x / 256, y: fine.y / 256, width: fine.width / 256, height: fine.height / 256 },
    confidence: rounded(row.confidence, 65535),
    ratio: rounded(row.ratio, 65535),
    runner_up_ratio: rounded(row.runnerUpRatio ?? NaN, 65535),
    alpha: alpha ?? null,
    identity: rounded(row.identity ?? NaN, 65535),
    scale: rounded(row.scale, 65536),
    found_again: foundAgain ?? null,
    work: work ?? null,
    quality: rounded(row.quality, 65535),
  };
}
