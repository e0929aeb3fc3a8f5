// The curves over the frames, by uPlot. Part of the page's script, see page.html.

const CURVES = [
  { title: "IoU", key: "iou", most: 1, digits: 2 },
  { title: "Centre error, pixels", key: "error", digits: 1 },
  { title: "Confidence", key: "confidence", most: 1, digits: 3 },
  { title: "Size, pixels (root of the box's area)", key: "size", digits: 1, truth: true },
  { title: "Ratio (dotted: runner-up)", key: "ratio", second: "runner_up", most: 1, digits: 3 },
  { title: "Alpha, gray levels", key: "alpha", digits: 0 },
  { title: "Cost, comparisons or products", key: "work", digits: 0 },
];
const LEFT = 56, RIGHT = 14, HEIGHT = 104, BAND = 18, AXIS = 22;
const WHOLE = [1, 10, 100, 1000, 1e4, 1e5].flatMap((unit) => [unit, 2 * unit, 5 * unit]);
const short = (value) => value >= 1e6 ? value / 1e6 + "M" : value >= 1e4 ? value / 1e3 + "k" : String(value);

/** The color and the dashes, in pixels of a canvas, of lines of this look; runners-up are dotted. */
function strokeOf(look, isSecond) {
  const probe = sample(look, isSecond);
  document.body.append(probe);
  const { stroke, strokeDasharray } = getComputedStyle(probe.firstChild);
  probe.remove();
  const dashes = strokeDasharray.split(/[\s,]+/).map((length) => parseFloat(length) * devicePixelRatio);
  return { color: stroke, dash: strokeDasharray === "none" ? undefined : dashes };
}

/** First and last index of every run of the same value that is not null. */
function runs(valueAt) {
  const found = [];
  for (let index = 0; index < recording.frames; index++) {
    const value = valueAt(index);
    const last = found[found.length - 1];
    if (value === null) continue;
    if (last && last.value === value && last.to === index - 1) last.to = index;
    else found.push({ value, from: index, to: index });
  }
  return found;
}

/** Fills the frames of each run, from `top` on; frame numbers are in their middle. */
function fillRuns(plot, found, top, height, colorOf) {
  const x = (number) => Math.min(Math.max(plot.valToPos(number, "x", true), plot.bbox.left), plot.bbox.left + plot.bbox.width);
  for (const { value, from, to } of found) {
    plot.ctx.fillStyle = colorOf(value);
    plot.ctx.fillRect(x(numberOf(from) - 0.5), plot.bbox.top + top * devicePixelRatio, x(numberOf(to) + 0.5) - x(numberOf(from) - 0.5), height * devicePixelRatio);
  }
}

/** A name on a band, whole however narrow the margin is. */
function writeName(plot, text, top) {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
  [ctx.textAlign, ctx.textBaseline, ctx.lineJoin, ctx.lineWidth] = ["left", "middle", "round", 3 * devicePixelRatio];
  [ctx.strokeStyle, ctx.fillStyle] = [palette().panel, palette().ink];
  const at = [bbox.left + 4 * devicePixelRatio, bbox.top + (top + BAND / 2) * devicePixelRatio];
  ctx.strokeText(text, ...at);
  ctx.fillText(text, ...at);
  ctx.restore();
}

/** A line as uPlot has it. */
function series({ label, look, isSecond, read }) {
  const { color, dash } = strokeOf(look, isSecond);
  // A value between two that are missing has no line: it is a point.
  const alone = (plot, at) => {
    const values = plot.data[at];
    return [...values.keys()].filter((i) => values[i] !== null && (values[i - 1] ?? null) === null && (values[i + 1] ?? null) === null);
  };
  return {
    label, width: isSecond ? 1.2 : 1.6, stroke: color, dash, value: (_, value, at, index) => index === null ? "–" : read(index),
    points: { show: true, size: 3, stroke: color, fill: color, filter: alone },
  };
}

/** A panel with these lines over the frames, the first on top: a `label`, `values`, a `look`, whether it `isSecond` of it, and how a
 *  value is `read`. */
function addPanel({ title, height, most, ticks, draw, lines }, isLast) {
  const name = htmlNode("div", { class: "name" }, htmlNode("b", {}, title));
  const panel = htmlNode("div", { class: "panel", role: "group", "aria-label": title + " over frames" }, name);
  byId("curves").append(panel);
  const marker = htmlNode("div", { class: "cursor" });
  const hidden = recording.truth ? runs((index) => (recording.truth[index] ? null : "gone")) : [];
  const place = (plot) => {
    const left = plot.valToPos(numberOf(frame), "x");
    marker.style.left = left + "px";
    marker.hidden = left < 0 || left > plot.over.clientWidth;
  };
  const follow = (plot) => { if (plot.cursor.left < 0) plot.setLegend({ idx: frame }); };
  const drawn = [...lines].reverse();
  const axis = { stroke: () => palette().faint, font: "11px system-ui, sans-serif", ticks: { show: false } };
  const plot = new uPlot({
    width: width(), height: height + (isLast ? AXIS : 0), padding: [6, RIGHT, 6, 0],
    legend: { mount: (_, legend) => name.append(legend) },
    cursor: { sync: { key: "frames" }, y: false, points: { show: !draw } },
    scales: { x: { time: false }, y: { range: (_, least, largest) => [0, most ?? Math.max(1, largest * 1.05)] } },
    axes: [
      { ...axis, show: isLast, size: AXIS, gap: 2, grid: { show: false }, incrs: WHOLE },
      { ...axis, size: LEFT, gap: 4, space: 30, grid: { stroke: () => palette().rule, width: 1 }, ...ticks },
    ],
    series: [{ label: "frame", value: (_, number) => number === null ? "" : number + (timeOf(number) === null ? "" : `, ${clock(timeOf(number))}`) + (isVisible(number - recording.first) ? "" : ", hidden") }, ...drawn.map(series)],
    hooks: {
      drawClear: [(plot) => fillRuns(plot, hidden, 0, plot.bbox.height / devicePixelRatio, () => getComputedStyle(document.documentElement).getPropertyValue("--gone"))],
      draw: [(plot) => draw && draw(plot), place],
      setCursor: [follow],
    },
  }, [Array.from({ length: recording.frames }, (_, index) => numberOf(index)), ...drawn.map((line) => line.values)], panel);
  const legend = name.querySelector("tbody");
  const rows = [...legend.children].slice(1).reverse();
  rows.forEach((row, at) => row.querySelector(".u-marker").replaceWith(sample(lines[at].look, lines[at].isSecond)));
  legend.append(...rows);
  plot.over.append(marker);
  addZoom(plot);
  plot.over.addEventListener("click", (event) => {
    // With shift it was a move.
    if (event.shiftKey) return;
    play(false);
    goTo(plot.posToIdx(event.clientX - plot.over.getBoundingClientRect().left));
  });
  panels.push({ plot, read: () => { place(plot); follow(plot); } });
}

const width = () => Math.max(280, byId("curves").clientWidth);

function drawCurves() {
  panels.forEach(({ plot }) => plot.destroy());
  panels = [];
  byId("curves").replaceChildren();
  const wanted = [];
  const list = shown();
  const withStates = list.filter((entrant) => entrant.states);
  if (withStates.length) {
    const count = withStates.length;
    const states = withStates.map((entrant) => runs((index) => entrant.states[index]));
    const color = (state) => palette()[state];
    const said = (run) => run ? `${run.value} in ${numberOf(run.from)} to ${numberOf(run.to)}` : "not begun";
    wanted.push({
      title: "States", height: count * BAND + 12, most: count,
      ticks: { values: () => [], grid: { show: false } },
      draw: (plot) => states.forEach((found, row) => {
        fillRuns(plot, found, row * BAND + 1, BAND - 2, color);
        writeName(plot, withStates[row].title, row * BAND);
      }),
      lines: withStates.map((entrant, row) => ({
        label: entrant.title, look: entrant.look, values: entrant.states.map(() => null),
        read: (index) => said(states[row].find((run) => run.from <= index && index <= run.to)),
      })),
    });
  }
  for (const { title, key, second, most, digits, truth } of CURVES) {
    const lines = list.filter((entrant) => entrant[key]);
    if (!lines.length) continue;
    const line = (label, look, values) => ({ label, look, values, read: (index) => values[index] === null ? "–" : values[index].toFixed(digits) });
    const all = lines.flatMap((entrant) => [
      line(entrant.title, entrant.look, entrant[key]),
      ...(second && entrant[second] ? [{ ...line(`${entrant.title} runner-up`, entrant.look, entrant[second]), isSecond: true }] : []),
    ]);
    if (truth && recording.truth && !off.has(TRUTH)) all.push(line("truth", data.truth, recording.truth.map((box) => box && Math.sqrt(box[2] * box[3]))));
    wanted.push({ title, height: HEIGHT, most, ticks: { values: (_, values) => values.map(short) }, lines: all });
  }
  wanted.forEach((panel, at) => addPanel(panel, at === wanted.length - 1));
  drawReadout();
}

const drawReadout = () => panels.forEach((panel) => panel.read());
