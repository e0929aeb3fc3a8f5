// What is shown, the address, and what the user does. Part of the page's script, see page.html.

function show() {
  drawStage();
  drawReadout();
  drawComparisons();
  writeAddress();
}

// Where it is narrow, the player lies over the room that it takes, and gets smaller when that is scrolled away: what is below does not
// jump.
let full = { stage: 0, rest: 0 };
function fit() {
  const [stage, room] = [byId("stage"), byId("room")];
  stage.style.maxHeight = "";
  full = { stage: stage.clientHeight, rest: byId("screen").offsetHeight - stage.clientHeight };
  room.style.height = full.stage + full.rest + "px";
  shrink();
}
function shrink() {
  const room = byId("room");
  byId("screen").style.transform = "";
  if (room.clientHeight === 0) return;
  const left = room.getBoundingClientRect().bottom - full.rest;
  byId("stage").style.maxHeight = `max(26vh, ${Math.min(left, full.stage)}px)`;
  // It goes away with the last of the curves.
  const screen = byId("screen");
  screen.style.transform = `translateY(${Math.min(byId("player").getBoundingClientRect().bottom - screen.offsetHeight, 0)}px)`;
}

function open(index, at) {
  recording = data.recordings[index];
  byId("recording").value = index;
  [...byId("sentences")?.children ?? []].forEach((one, at) => { one.hidden = at !== index; });
  events = eventsOfAll();
  play(false);
  drawSwitches();
  frame = clamp(at, 0, recording.frames - 1);
  drawCurves();
  show();
  fit();
}

/** The address names the frame. Browsers refuse one that changes too often. */
let writing = null;
function writeAddress() {
  writing ??= setTimeout(() => {
    writing = null;
    const words = new URLSearchParams(data.recordings.length > 1 ? { recording: recording.name } : {});
    words.set("frame", numberOf(frame));
    history.replaceState(null, "", "#" + words);
  }, 400);
}

/** Goes to the frame in the address; false if there is none. */
function readAddress() {
  const words = new URLSearchParams(location.hash.slice(1));
  const named = data.recordings.findIndex((one) => one.name === words.get("recording"));
  const index = named < 0 ? data.recordings.indexOf(recording) : named;
  const number = Number(words.get("frame") || NaN);
  if (named < 0 && Number.isNaN(number)) return false;
  open(index, Number.isNaN(number) ? 0 : Math.round(number) - data.recordings[index].first);
  return true;
}

for (const one of data.recordings) for (const entrant of one.entrants) if (entrant.method === null) off.add(entrant.name);
byId("player").hidden = false;
byId("timeline").querySelector("input").id = "scrub";
byId("play").addEventListener("click", () => {
  if (timer === null && frame === recording.frames - 1) goTo(0);
  play(timer === null);
});
byId("back").addEventListener("click", () => { play(false); step(-1); });
byId("on").addEventListener("click", () => { play(false); step(1); });
byId("speed").addEventListener("change", () => play(timer !== null));
byId("recording").addEventListener("change", (event) => open(Number(event.target.value), 0));
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("input, select, button, a, summary, .scroll")) return;
  const by = event.shiftKey ? 10 : 1;
  const moves = { "[": () => goToEvent(-1), "]": () => goToEvent(1), ArrowLeft: () => goTo(frame - by), ArrowRight: () => goTo(frame + by), Home: () => goTo(0), End: () => goTo(recording.frames - 1) };
  const zooms = { "+": () => zoomBy(0.5), "-": () => zoomBy(2), 0: showAll };
  if (event.key === " ") play(timer === null);
  else if (moves[event.key]) { play(false); moves[event.key](); }
  else if (zooms[event.key]) zooms[event.key]();
  else return;
  event.preventDefault();
});
let resized = null;
addEventListener("resize", () => { clearTimeout(resized); resized = setTimeout(() => { panels.forEach(({ plot }) => plot.setSize({ width: width(), height: plot.height })); fit(); show(); }, 100); });
addEventListener("scroll", shrink, { passive: true });
addEventListener("hashchange", readAddress);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { drawCurves(); drawTimeline(); });
document.querySelectorAll(".scroll table").forEach(makeSortable);
drawScale();
if (!readAddress()) open(0, 0);
