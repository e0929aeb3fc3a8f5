// What was compared in a frame: templates, differences, histograms. Part of the page's script, see page.html.

function drawComparisons() {
  const pictures = recording.pictures;
  const at = pictures ? Math.floor(frame / pictures.every) : 0;
  const kept = pictures ? at * pictures.every : 0;
  const all = pictures ? pictures.comparisons[at] : [];
  const list = shown().filter((entrant) => entrant.method !== null && all[entrant.method]);
  const named = placeOf(numberOf(kept), timeOf).replace(/^f/, "F");
  const which = kept === frame ? named : `${named}, the nearest before with its picture`;
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
    return htmlNode("figure", { class: "card" },
      htmlNode("div", { class: "pair" }, picture(template, `template of ${entrant.title}`), picture(map, `differences of ${entrant.title}`)),
      htmlNode("figcaption", {}, sample(entrant.look), `${entrant.title}: ${counts}${believed}`));
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
  const width = Math.max(280, svg.parentNode.clientWidth), height = 170, top = 10, bottom = height - 34;
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
    const look = `look-${entrant.look}`;
    const steps = one.histogram.map((part, bar) => `V${y(part).toFixed(1)}H${x(bar + 1).toFixed(1)}`).join("");
    const d = `M${LEFT} ${bottom}${steps}V${bottom}`;
    nodes.push(svgNode("path", place === 0 ? { class: "bars " + look, d: d + "z" } : { class: "line " + look, d }));
    if (alpha !== null && alpha !== undefined) {
      const at = x(Math.min(alpha / data.bar, data.bars));
      nodes.push(svgNode("path", { class: "threshold " + look, d: `M${at} ${top}V${bottom}` }));
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
