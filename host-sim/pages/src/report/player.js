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
  const first = recording.entrants.find((entrant) => entrant.states);
  const state = first.states[frame] ?? "not begun";
  const [before, after] = [`${numberOf(frame)} ${first.name}: `, isVisible(frame) ? "" : ", target hidden"];
  const letters = Math.min(whole[2] / 22, whole[2] / (0.6 * (before + state + after).length + 1));
  const words = svgNode("text", { x: whole[0] + letters / 2, y: whole[1] + letters * 1.2, "font-size": letters });
  words.append(before, svgNode("tspan", { class: state }, state), after);
  nodes.push(words);
  stage.replaceChildren(...nodes);
  const time = timeOf(numberOf(frame));
  const said = `frame ${numberOf(frame)} of ${lastNumber()}${time === null ? "" : `, ${clock(time)}`}`;
  stage.setAttribute("aria-label", `${said}, ${first.name}: ${state}`);
  byId("place").value = said;
  drawTimeline();
}

/** What happened to each target, in the order of frames; made when a recording is opened. */
function eventsOfAll() {
  const of = ({ name, locks }, entrant) => {
    const rows = entrant.states.map((state, index) => ({ number: numberOf(index), state })).filter(({ state }) => state !== null);
    const events = eventsOf(rows, locks.map((number) => ({ number })));
    return name === null ? events : events.map((event) => ({ ...event, name }));
  };
  const entrants = firsts();
  return recording.targets.flatMap((target, at) => of(target, entrants[at])).sort((one, other) => one.frame - other.frame);
}

function drawTimeline() {
  const strips = shown().filter((entrant) => entrant.states).map((entrant, at) => ({
    color: strokeOf(entrant.look).color, isChosen: at === 0, states: (number) => entrant.states[number - recording.first] ?? undefined,
  }));
  timeline.draw({ first: recording.first, last: lastNumber(), frame: numberOf(frame), followed: lastNumber(), strips, marks: events, timeOf });
  byId("eventless").hidden = events.some(({ kind }) => kind !== "locked" && kind !== "corrected");
  drawEvents(byId("events"), events, { timeOf, goTo: goToNumber, chosen: numberOf(frame) });
}

/** To the next event (1) or the one before (-1). */
function goToEvent(by) {
  const there = events.filter((event) => Math.sign(event.frame - numberOf(frame)) === by);
  if (there.length) goToNumber(there.at(by > 0 ? 0 : -1).frame);
}

function goToNumber(number) {
  play(false);
  goTo(number - recording.first);
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
