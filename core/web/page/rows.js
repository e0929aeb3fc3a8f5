// Answers in the formats of host-sim: `host-sim track --format csv` and `host-sim track --json`.

import { optionsOf } from "./command.js";

const CSV_NAMES = "frame,x,y,width,height,state,confidence,ratio,runner_up_ratio,alpha,scale,work\n";

// Rounds to six digits, as host-sim does.
const rounded = (value, unit) => (Number.isNaN(value) ? null : Math.round((value / unit) * 1e6) / 1e6);
const figure = (value) => (Number.isNaN(value) ? null : value);

/** The rows of all targets of a method, in the order of the frames. `named` is a list of [name, history]. */
export function csv(named) {
  const isNamed = named.length > 1;
  const lines = inOrder(named).map(([name, row]) => `${isNamed ? `${name},` : ""}${csvLine(row)}\n`);
  return (isNamed ? "target," : "") + CSV_NAMES + lines.join("");
}

/** One JSON object on each line. */
export function json(named, method, settings, version) {
  const origin = { version, method, options: optionsOf(method, settings) };
  const isNamed = named.length > 1;
  return inOrder(named).map(([name, row]) => `${JSON.stringify({ ...origin, ...(isNamed ? { target: name } : {}), ...ofRow(row) })}\n`).join("");
}

function inOrder(named) {
  const all = named.flatMap(([name, history]) => [...history.rows()].map((row) => [name, row]));
  return all.sort(([, one], [, other]) => one.number - other.number);
}

function csvLine(row) {
  const { frame, state, fine, confidence, ratio, runner_up_ratio, alpha, scale, work } = ofRow(row);
  const box = fine === null ? ["", "", "", ""] : [fine.x, fine.y, fine.width, fine.height];
  return [frame, ...box, state, confidence, ratio, runner_up_ratio, alpha, scale, work].map((value) => value ?? "").join(",");
}

function ofRow(row) {
  const isLost = row.state === "lost";
  return {
    frame: row.number,
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
