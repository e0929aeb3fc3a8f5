// The movement of a target: its centre and speed in pixels or, with a known length in the picture, in metres.

const END = 7; // pixels from a line's end to the end of its mark

/** Returns the centre { x, y, time } of a box whose sides are in 1/`part` pixels; null if there is no box. */
export const centreOf = (box, time, part = 1) => box && { x: (box.x + box.width / 2) / part, y: (box.y + box.height / 2) / part, time };

/**
 * Returns the speed from a centre to that of the next frame, in units of `per` pixels a second; null if one of both
 * frames has no centre or no time.
 */
export function speedOf(from, to, per = 1) {
  const seconds = (to?.time ?? NaN) - (from?.time ?? NaN);
  return seconds > 0 ? Math.hypot((to.x - from.x) / per, (to.y - from.y) / per) / seconds : null;
}

const ends = ({ x, y, width, height }) => [x, y, x + width, y + height];

/** Returns the length that a line has if it is `text` metres long; null if the text is no such number. */
export function lengthOf(line, text) {
  const number = Math.hypot(line.width, line.height) / Number(text.trim().replace(",", "."));
  return number >= 1e-6 && number <= 1e6 ? { pixels_per_metre: Number(number.toPrecision(6)), line: ends(line) } : null;
}

/** Returns a length's line, whose width and height are negative to the left and up; null if none is drawn. */
export const lineOf = (length) => (length?.line ? { x: length.line[0], y: length.line[1], width: length.line[2] - length.line[0], height: length.line[3] - length.line[1] } : null);

const short = (number, digits = 4) => String(Number(number.toPrecision(digits)));

/** Returns the length of a length's line in metres, as text; empty if no line is drawn. */
export function metresOf(length) {
  const line = lineOf(length);
  return line === null ? "" : short(Math.hypot(line.width, line.height) / length.pixels_per_metre, 5);
}

/** Returns a sentence about a length; empty if none is known. */
export const scaleOf = (length) => (length ? `1 m = ${short(length.pixels_per_metre)} pixels` : "");

/** Draws a line with its ends on a canvas, from (x, y) across and down. */
export function drawLine(context, [x, y, across, down]) {
  const long = Math.hypot(across, down);
  const [right, below] = [(-END * down) / long, (END * across) / long];
  context.setLineDash([]);
  for (const [color, width] of [["#000", 4], ["#fff", 2]]) {
    [context.strokeStyle, context.lineWidth] = [color, width];
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + across, y + down);
    for (const [atX, atY] of [[x, y], [x + across, y + down]]) {
      context.moveTo(atX - right, atY - below);
      context.lineTo(atX + right, atY + below);
    }
    context.stroke();
  }
}

/**
 * Returns charts for graph.js of a target's centre and speed in the frames from `first` to `last`. `boxAt(number)` is the
 * box of a frame or null, `length` the known length or null.
 */
export function movementOf(place, look, { first, last, boxAt, timeOf, length }) {
  const numbers = Array.from({ length: last - first + 2 }, (_, at) => first + at - 1);
  const centres = numbers.map((number) => centreOf(boxAt(number), timeOf(number)));
  const [unit, per] = length ? ["m", length.pixels_per_metre] : ["pixels", 1];
  const chart = (title, unit, values, ...lowest) => {
    const known = [...values.filter((value) => value !== null), ...lowest];
    const [low, high] = [Math.min(...known), Math.max(...known)];
    const margin = Math.max(0.05 * (high - low), 1 / per);
    return {
      place, title, least: lowest[0] ?? low - margin, most: high + margin,
      lines: [{ title: "", look, numbers, values, read: (at) => `${short(values[at])} ${unit}` }],
    };
  };
  return [
    ...[["x", "→"], ["y", "↓"]].map(([axis, way]) => chart(`Centre ${axis} ${way}`, unit, centres.map((centre) => centre && centre[axis] / per))),
    chart(centres.some((centre) => centre?.time === null) ? "Speed: no times" : "Speed", `${unit}/s`, centres.map((centre, at) => speedOf(centres[at - 1], centre, per)), 0),
  ];
}
