// Answers in the formats of host-sim: `host-sim track --format csv` and `host-sim track --json`.

import { optionsOf } from "./command.js";

const CSV_NAMES = "frame,time,x,y,width,height,state,confidence,ratio,runner_up_ratio,alpha,scale,work\n";

// Rounds to six digits, as host-sim does.
const rounded = (value, unit) => (Number.isNaN(value) ? null : Math.round((value / unit) * 1e6) / 1e6);
const figure = (value) => (Number.isNaN(value) ? null : value);

/**
 * The rows of all targets of a method, in the order of the frames. `named` is a list of [name, history]; `timeOf(frame)` is the
 * time of a frame in seconds, or null.
 */
export function csv(named, timeOf) {
  const isNamed = named.length > 1;
  const lines = inOrder(named).map(([name, row]) => `${isNamed ? `${name},` : ""}${csvLine(row, timeOf)}\n`);
  return (isNamed ? "target," : "") + CSV_NAMES + lines.join("");
}

/** One JSON object on each line. */
export function json(named, method, settings, version, timeOf) {
  const origin = { version, method, options: optionsOf(method, settings) };
  const isNamed = named.length > 1;
  return inOrder(named).map(([name, row]) => `${JSON.stringify({ ...origin, ...(isNamed ? { target: name } : {}), ...ofRow(row, timeOf) })}\n`).join("");
}

function inOrder(named) {
  const all = named.flatMap(([name, history]) => [...history.rows()].map((row) => [name, row]));
  return all.sort(([, one], [, other]) => one.number - other.number);
}

function csvLine(row, timeOf) {
  const { frame, time, state, fine, confidence, ratio, runner_up_ratio, alpha, scale, work } = ofRow(row, timeOf);
  const box = fine === null ? ["", "", "", ""] : [fine.x, fine.y, fine.width, fine.height];
  return [frame, time, ...box, state, confidence, ratio, runner_up_ratio, alpha, scale, work].map((value) => value ?? "").join(",");
}

function ofRow(row, timeOf) {
  const isLost = row.state === "lost";
  return {
    frame: row.number,
    time: rounded(timeOf(row.number) ?? NaN, 1),
    state: row.state,
    box: isLost ? null : { x: row.x, y: row.y, width: row.width, height: row.height },
    fine: isLost ? null : { x: row.fineX / 256, y: row.fineY / 256, width: row.fineWidth / 256, height: row.fineHeight / 256 },
    confidence: rounded(row.confidence, 65535),
    ratio: rounded(row.ratio, 65535),
    runner_up_ratio: rounded(row.runnerUpRatio, 65535),
    alpha: figure(row.alpha),
    scale: rounded(row.scale, 65536),
    found_again: Number.isNaN(row.foundAgain) ? null : row.foundAgain === 1,
    work: figure(row.work),
    quality: rounded(row.quality, 65535),
  };
}
