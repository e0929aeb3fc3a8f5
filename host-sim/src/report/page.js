// The player, the curves and the comparisons of the page. Everything that is shown follows from three things: the recording,
// the frame, and who is switched on.
"use strict";
(() => {
  const byId = (id) => document.getElementById(id);
  const data = JSON.parse(byId("data").textContent);
  const TRUTH = "ground truth";
  const off = new Set();
  for (const entrant of data.recordings.flatMap((one) => one.entrants)) entrant.color = `rgb(${entrant.color})`;
  let recording = data.recordings[0];
  let frame = 0;
  let timer = null;
  let panels = [];

  const svgNode = (name, attributes, text) => {
    const node = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    if (text !== undefined) node.textContent = text;
    return node;
  };
  const htmlNode = (name, attributes, ...children) => {
    const node = document.createElement(name);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    node.append(...children);
    return node;
  };
  const shown = () => recording.entrants.filter((entrant) => !off.has(entrant.name));
  const isVisible = (index) => recording.truth === null || recording.truth[index] !== null;

  // ---- player

  function drawStage() {
    const stage = byId("stage");
    const { width, height, margin, pictures } = recording;
    const whole = [-margin, -margin, width + 2 * margin, height + 2 * margin];
    stage.setAttribute("viewBox", whole.join(" "));
    const nodes = [svgNode("rect", { class: "padding", x: whole[0], y: whole[1], width: whole[2], height: whole[3] })];
    if (pictures) {
      const href = "data:image/jpeg;base64," + pictures.frames[Math.floor(frame / pictures.every)];
      nodes.push(svgNode("image", { href, width, height, preserveAspectRatio: "none" }));
    }
    const box = (of, name, style) =>
      nodes.push(svgNode("rect", { class: "box " + name, x: of[0], y: of[1], width: of[2], height: of[3], style }));
    const list = shown();
    for (const entrant of list) if (entrant.lasts && entrant.lasts[frame]) box(entrant.lasts[frame], "method last", `--c:${entrant.color}`);
    const boxes = list.filter((entrant) => entrant.boxes[frame]).map((entrant) => [entrant.boxes[frame], "method", entrant.color]);
    if (recording.truth && recording.truth[frame] && !off.has(TRUTH)) boxes.push([recording.truth[frame], "truth", "var(--truth)"]);
    const scale = Math.min(stage.clientWidth / whole[2], stage.clientHeight / whole[3]) || 1;
    for (const together of coinciding(boxes, scale)) {
      together.forEach(([of, name, color], place) => box(of, name, `--c:${color};${dashes(place, together.length)}`));
    }
    const letters = whole[2] / 22;
    const first = recording.entrants.find((entrant) => entrant.states);
    const words = svgNode("text", { x: whole[0] + letters / 2, y: whole[1] + letters * 1.2, "font-size": letters });
    words.append(frame + 1 + " ", svgNode("tspan", { class: first.states[frame] }, first.states[frame]));
    if (!isVisible(frame)) words.append(", target hidden");
    nodes.push(words);
    stage.replaceChildren(...nodes);
    const said = `frame ${frame + 1} of ${recording.frames}`;
    stage.setAttribute("aria-label", `${said}, ${first.title} ${first.states[frame]}`);
    byId("place").value = said;
    byId("scrub").value = frame + 1;
    byId("scrub").setAttribute("aria-valuetext", said);
  }

  /** Boxes in groups: those of one group lie on one another as far as the eye can tell. */
  function coinciding(boxes, scale) {
    const edges = ([x, y, width, height]) => [x, y, x + width, y + height];
    const near = (a, b) => edges(a).every((edge, at) => Math.abs(edge - edges(b)[at]) * scale < 2.5);
    const groups = [];
    for (const one of boxes) {
      const group = groups.find((group) => near(group[0][0], one[0]));
      if (group) group.push(one);
      else groups.push([one]);
    }
    return groups;
  }

  /** Boxes that coincide share one line, in turn a dash of each: all are seen. */
  const dashes = (place, of) => of > 1 ? `stroke-dasharray:10 ${10 * (of - 1)};stroke-dashoffset:${-10 * place}` : "";

  function drawSwitches() {
    const legend = byId("switches").firstElementChild;
    const names = recording.entrants.map((entrant) => [entrant.name, entrant.title, entrant.color]);
    if (recording.truth) names.push([TRUTH, TRUTH, "var(--truth)"]);
    const labels = names.map(([name, title, color]) => {
      const input = htmlNode("input", { type: "checkbox" });
      input.checked = !off.has(name);
      input.addEventListener("change", () => {
        if (input.checked) off.delete(name);
        else off.add(name);
        const { min, max } = panels.length ? panels[0].plot.scales.x : {};
        drawCurves();
        if (min) panels.forEach(({ plot }) => plot.setScale("x", { min, max }));
        show();
      });
      return htmlNode("label", {}, input, htmlNode("span", { class: "key", style: `--c:${color}` }), title);
    });
    byId("switches").replaceChildren(legend, ...labels);
    const every = recording.pictures ? recording.pictures.every : 1;
    byId("kept").textContent = every > 1 ? `To keep the page small, one of ${every} frames has its picture; boxes and curves have all.` : "";
  }

  function play(on) {
    clearInterval(timer);
    timer = on ? setInterval(step, 1000 / Number(byId("speed").value), 1) : null;
    byId("play").textContent = on ? "❚❚" : "▶";
    byId("play").setAttribute("aria-label", on ? "Pause" : "Play");
  }

  function step(by) {
    const last = recording.frames - 1;
    if (timer !== null && frame === last) play(false);
    else goTo(frame + by);
  }

  function goTo(index) {
    frame = Math.max(0, Math.min(recording.frames - 1, index));
    show();
  }

  // ---- curves

  const CURVES = [
    { title: "IoU", key: "iou", most: 1, digits: 2 },
    { title: "Centre error, pixels", key: "error", digits: 1 },
    { title: "Confidence", key: "confidence", most: 1, digits: 3 },
    { title: "Ratio (dotted: runner-up)", key: "ratio", second: "runner_up", most: 1, digits: 3 },
    { title: "Alpha, gray levels", key: "alpha", digits: 0 },
    { title: "Size, pixels (root of the box's area)", key: "size", digits: 1, truth: true },
    { title: "Cost, comparisons or products", key: "work", digits: 0 },
  ];
  const LEFT = 56, RIGHT = 14, HEIGHT = 104, BAND = 14, AXIS = 22;
  const WHOLE = [1, 10, 100, 1000, 1e4, 1e5].flatMap((unit) => [unit, 2 * unit, 5 * unit]);
  const short = (value) => value >= 1e6 ? value / 1e6 + "M" : value >= 1e4 ? value / 1e3 + "k" : String(value);
  const styleOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);
  
  /** A color as lines have it: what is seen on any frame is too bright on white. */
  function lineColor(color) {
    const probe = htmlNode("span", { class: "dash", style: `--c:${color}` });
    document.body.append(probe);
    const found = getComputedStyle(probe).borderTopColor;
    probe.remove();
    return found;
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
      plot.ctx.fillRect(x(from + 0.5), plot.bbox.top + top * devicePixelRatio, x(to + 1.5) - x(from + 0.5), height * devicePixelRatio);
    }
  }

  /** A panel with these lines over the frames, the first on top: a `label`, `values`, a `color`, and how a value is `read`. */
  function addPanel({ title, height, most, ticks, draw, lines }, isLast) {
    const name = htmlNode("div", { class: "name" }, htmlNode("b", {}, title));
    const panel = htmlNode("div", { class: "panel", role: "group", "aria-label": title + " over frames" }, name);
    byId("curves").append(panel);
    const marker = htmlNode("div", { class: "cursor" });
    const hidden = recording.truth ? runs((index) => (recording.truth[index] ? null : "gone")) : [];
    const place = (plot) => {
      const left = plot.valToPos(frame + 1, "x");
      marker.style.left = left + "px";
      marker.hidden = left < 0 || left > plot.over.clientWidth;
    };
    const follow = (plot) => { if (plot.cursor.left < 0) plot.setLegend({ idx: frame }); };
    // A value between two that are missing has no line: it is a point.
    const alone = (plot, at) => {
      const values = plot.data[at];
      return [...values.keys()].filter((i) => values[i] !== null && (values[i - 1] ?? null) === null && (values[i + 1] ?? null) === null);
    };
    const line = ({ label, values, color, read, dashed, width }) => ({
      label, width: width ?? 1.6, stroke: color, dash: dashed ? [2, 3] : undefined, value: (_, value, at, index) => index === null ? "–" : read(index),
      points: { show: true, size: 3, stroke: color, fill: color, filter: alone },
    });
    const drawn = [...lines].reverse();
    const axis = { stroke: () => styleOf("--faint"), font: "11px system-ui, sans-serif", ticks: { show: false } };
    const plot = new uPlot({
      width: width(), height: height + (isLast ? AXIS : 0), padding: [6, RIGHT, 6, 0],
      legend: { mount: (_, legend) => name.append(legend) },
      cursor: { sync: { key: "frames" }, y: false, points: { show: !draw } },
      scales: { x: { time: false }, y: { range: (_, least, largest) => [0, most ?? Math.max(1, largest * 1.05)] } },
      axes: [
        { ...axis, show: isLast, size: AXIS, gap: 2, grid: { show: false }, incrs: WHOLE },
        { ...axis, size: LEFT, gap: 4, space: 30, grid: { stroke: () => styleOf("--rule"), width: 1 }, ...ticks },
      ],
      series: [{ label: "frame", value: (_, number) => number === null ? "" : number + (isVisible(number - 1) ? "" : ", hidden") }, ...drawn.map(line)],
      hooks: {
        drawClear: [(plot) => fillRuns(plot, hidden, 0, plot.bbox.height / devicePixelRatio, () => styleOf("--gone"))],
        draw: [(plot) => draw && draw(plot), place],
        setCursor: [follow],
      },
    }, [Array.from({ length: recording.frames }, (_, index) => index + 1), ...drawn.map((line) => line.values)], panel);
    const legend = name.querySelector("tbody");
    legend.append(...[...legend.children].slice(1).reverse());
    plot.over.append(marker);
    plot.over.addEventListener("click", (event) => { play(false); goTo(plot.posToIdx(event.clientX - plot.over.getBoundingClientRect().left)); });
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
      const color = (state) => styleOf("--" + (state === "uncertain" ? "leaving" : state));
      const said = ({ value, from, to }) => `${value} in ${from + 1} to ${to + 1}`;
      wanted.push({
        title: "States", height: count * BAND + 12, most: count,
        ticks: { splits: () => withStates.map((_, row) => count - row - 0.5), values: () => withStates.map((entrant) => entrant.title.slice(0, 6)), grid: { show: false } },
        draw: (plot) => states.forEach((found, row) => fillRuns(plot, found, row * BAND + 1, BAND - 2, color)),
        lines: withStates.map((entrant, row) => ({
          label: entrant.title, color: lineColor(entrant.color), values: entrant.states.map(() => null),
          read: (index) => said(states[row].find((run) => index <= run.to)),
        })),
      });
    }
    for (const { title, key, second, most, digits, truth } of CURVES) {
      const lines = list.filter((entrant) => entrant[key]);
      if (!lines.length) continue;
      const line = (label, color, values) => ({ label, color: lineColor(color), values, read: (index) => values[index] === null ? "–" : values[index].toFixed(digits) });
      const all = lines.flatMap((entrant) => [
        line(entrant.title, entrant.color, entrant[key]),
        ...(second && entrant[second] ? [{ ...line(`${entrant.title} runner-up`, entrant.color, entrant[second]), dashed: true, width: 1.2 }] : []),
      ]);
      if (truth && recording.truth && !off.has(TRUTH)) all.push(line("truth", "var(--truth)", recording.truth.map((box) => box && Math.sqrt(box[2] * box[3]))));
      wanted.push({ title, height: HEIGHT, most, ticks: { values: (_, values) => values.map(short) }, lines: all });
    }
    wanted.forEach((panel, at) => addPanel(panel, at === wanted.length - 1));
    drawReadout();
  }

  const drawReadout = () => panels.forEach((panel) => panel.read());

  // ---- what was compared

  function drawComparisons() {
    const pictures = recording.pictures;
    const at = pictures ? Math.floor(frame / pictures.every) : 0;
    const kept = pictures ? at * pictures.every : 0;
    const all = pictures ? pictures.comparisons[at] : [];
    const list = shown().filter((entrant) => entrant.method !== null && all[entrant.method]);
    const which = kept === frame ? `Frame ${frame + 1}` : `Frame ${kept + 1}, the nearest before with its picture`;
    byId("compared").textContent = list.length
      ? `${which}. Left: the template. Right: how much each pixel of the box differs from it; green pixels differ by less than alpha and count. Below: how many pixels differ by how many gray levels.`
      : kept === 0
        ? `${which}: nothing is compared here, the trackers are locked on the target. Go to a later frame.`
        : `${which}: no method is switched on.`;
    const cards = list.map((entrant) => {
      const { template, map, counting } = all[entrant.method];
      const picture = (bytes, alt) => htmlNode("img", { src: "data:image/png;base64," + bytes, alt });
      const believed = entrant.boxes[kept] ? "" : ", not believed";
      const counts = counting === null ? "all pixels count" : `${Math.round(counting * 100)}% of the pixels count`;
      return htmlNode("figure", { class: "card", style: `--c:${entrant.color}` },
        htmlNode("div", { class: "pair" }, picture(template, `template of ${entrant.title}`), picture(map, `differences of ${entrant.title}`)),
        htmlNode("figcaption", {}, htmlNode("span", { class: "dash", style: `--c:${entrant.color}` }), `${entrant.title}: ${counts}${believed}`));
    });
    byId("comparisons").replaceChildren(...cards);
    byId("scale").hidden = !list.length;
    drawHistogram(list.map((entrant) => [entrant, all[entrant.method], entrant.alpha && entrant.alpha[kept]]));
  }

  function drawScale() {
    const bright = (level) => Math.floor(Math.sqrt((255 * 255 * level) / 127));
    const stops = (color) => Array.from({ length: 17 }, (_, at) => color(bright((at * 127) / 16))).join(", ");
    const bar = (color) => htmlNode("span", { class: "ramp", style: `background: linear-gradient(to right, ${stops(color)})` });
    const line = (text, color) => htmlNode("div", {}, htmlNode("span", {}, "0"), bar(color), htmlNode("span", {}, "127+ " + text));
    byId("scale").replaceChildren(
      line("gray levels", (shade) => `rgb(${shade}, ${shade}, ${shade})`),
      line("that count", (shade) => `rgb(${Math.floor(shade / 3)}, ${105 + Math.floor(shade / 3)}, ${65 + Math.floor(shade / 3)})`));
  }

  function drawHistogram(list) {
    const svg = byId("histogram");
    const width = Math.max(280, byId("player").clientWidth), height = 170, top = 10, bottom = height - 34;
    const inner = width - LEFT - 22;
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.toggleAttribute("hidden", !list.length);
    const most = Math.max(10, ...list.flatMap(([, one]) => one.histogram));
    const x = (bar) => LEFT + (inner * bar) / data.bars;
    const y = (part) => bottom - ((bottom - top) * part) / most;
    const nodes = [];
    for (const part of [0, most / 2, most]) {
      nodes.push(svgNode("path", { class: "grid", d: `M${LEFT} ${y(part)}H${x(data.bars)}` }));
      nodes.push(svgNode("text", { x: LEFT - 6, y: y(part) + 4, "text-anchor": "end" }, (part / 10).toFixed(0) + "%"));
    }
    list.forEach(([entrant, one, alpha], place) => {
      const style = `--c:${entrant.color}`;
      const steps = one.histogram.map((part, bar) => `V${y(part).toFixed(1)}H${x(bar + 1).toFixed(1)}`).join("");
      const d = `M${LEFT} ${bottom}${steps}V${bottom}`;
      nodes.push(svgNode("path", place === 0 ? { class: "bars", style, d: d + "z" } : { class: "line", style, d }));
      if (alpha !== null && alpha !== undefined) {
        const at = x(Math.min(alpha / data.bar, data.bars));
        nodes.push(svgNode("path", { class: "threshold", style, d: `M${at} ${top}V${bottom}` }));
        nodes.push(svgNode("text", { x: at + 4, y: top + 10 + 13 * place }, `alpha ${alpha} (${entrant.title})`));
      }
    });
    for (let bar = 0; bar <= data.bars; bar += data.bars / 8) {
      const label = bar * data.bar + (bar === data.bars ? "+" : "");
      nodes.push(svgNode("text", { x: x(bar), y: bottom + 14, "text-anchor": "middle" }, label));
    }
    nodes.push(svgNode("text", { x: x(data.bars), y: bottom + 30, "text-anchor": "end" }, "difference in gray levels"));
    svg.replaceChildren(...nodes);
  }

  // ---- all together

  function show() {
    drawStage();
    drawReadout();
    drawComparisons();
  }

  function open(index, at) {
    recording = data.recordings[index];
    byId("recording").value = index;
    byId("scrub").max = recording.frames;
    play(false);
    drawSwitches();
    frame = Math.max(0, Math.min(recording.frames - 1, at));
    drawCurves();
    show();
  }

  for (const one of data.recordings) for (const entrant of one.entrants) if (entrant.method === null) off.add(entrant.name);
  byId("player").hidden = false;
  byId("play").addEventListener("click", () => {
    if (timer === null && frame === recording.frames - 1) goTo(0);
    play(timer === null);
  });
  byId("back").addEventListener("click", () => { play(false); step(-1); });
  byId("on").addEventListener("click", () => { play(false); step(1); });
  byId("scrub").addEventListener("input", (event) => { play(false); goTo(Number(event.target.value) - 1); });
  byId("speed").addEventListener("change", () => play(timer !== null));
  byId("recording").addEventListener("change", (event) => open(Number(event.target.value), 0));
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("input, select, button, a, summary")) return;
    const by = event.shiftKey ? 10 : 1;
    const moves = { ArrowLeft: () => goTo(frame - by), ArrowRight: () => goTo(frame + by), Home: () => goTo(0), End: () => goTo(recording.frames - 1) };
    if (event.key === " ") play(timer === null);
    else if (moves[event.key]) { play(false); moves[event.key](); }
    else return;
    event.preventDefault();
  });
  for (const link of document.querySelectorAll("a.still")) {
    const name = link.closest(".strip").dataset.recording;
    link.addEventListener("click", () => open(data.recordings.findIndex((one) => one.name === name), Number(link.dataset.frame) - 1));
  }
  let resized = null;
  addEventListener("resize", () => { clearTimeout(resized); resized = setTimeout(() => { panels.forEach(({ plot }) => plot.setSize({ width: width(), height: plot.height })); show(); }, 100); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawCurves);
  drawScale();
  open(0, 0);
})();
