// The player: the frame with its boxes, who is switched on, and what moves it. Part of the page's script, see page.html.

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
  const box = (of, name, style = "") =>
    nodes.push(svgNode("rect", { class: "box " + name, x: of[0], y: of[1], width: of[2], height: of[3], style }));
  const list = shown();
  for (const entrant of list) if (entrant.lasts && entrant.lasts[frame]) box(entrant.lasts[frame], `method last look-${entrant.look}`);
  const boxes = list.filter((entrant) => entrant.boxes[frame]).map((entrant) => [entrant.boxes[frame], `method look-${entrant.look}`]);
  if (recording.truth && recording.truth[frame] && !off.has(TRUTH)) boxes.push([recording.truth[frame], `truth look-${data.truth}`]);
  const scale = Math.min(stage.clientWidth / whole[2], stage.clientHeight / whole[3]) || 1;
  for (const together of coinciding(boxes, scale)) {
    together.forEach(([of, name], place) => box(of, name, dashes(place, together.length)));
  }
  const letters = whole[2] / 22;
  const first = recording.entrants.find((entrant) => entrant.states);
  const words = svgNode("text", { x: whole[0] + letters / 2, y: whole[1] + letters * 1.2, "font-size": letters });
  const state = first.states[frame] ?? "not begun";
  words.append(`${numberOf(frame)} ${first.name}: `, svgNode("tspan", { class: state }, state));
  if (!isVisible(frame)) words.append(", target hidden");
  nodes.push(words);
  stage.replaceChildren(...nodes);
  const said = `frame ${numberOf(frame)} of ${lastNumber()}`;
  stage.setAttribute("aria-label", `${said}, ${first.name}: ${state}`);
  byId("place").value = said;
  byId("scrub").value = numberOf(frame);
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
  const names = recording.entrants.map((entrant) => [entrant.name, entrant.title, entrant.look]);
  if (recording.truth) names.push([TRUTH, TRUTH, data.truth]);
  const labels = names.map(([name, title, look]) => {
    const input = htmlNode("input", { type: "checkbox" });
    input.checked = !off.has(name);
    input.addEventListener("change", () => {
      if (input.checked) off.delete(name);
      else off.add(name);
      const { min, max } = part();
      drawCurves();
      setPart(min, max);
      show();
    });
    return htmlNode("label", {}, input, sample(look), title);
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
  frame = clamp(index, 0, recording.frames - 1);
  show();
}
