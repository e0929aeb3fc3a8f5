// What is shown, the address, and what the user does. Part of the page's script, see page.html.

function show() {
  drawStage();
  drawReadout();
  drawComparisons();
  writeAddress();
}

function open(index, at) {
  recording = data.recordings[index];
  byId("recording").value = index;
  byId("scrub").min = recording.first;
  byId("scrub").max = lastNumber();
  play(false);
  drawSwitches();
  frame = clamp(at, 0, recording.frames - 1);
  drawCurves();
  show();
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
byId("play").addEventListener("click", () => {
  if (timer === null && frame === recording.frames - 1) goTo(0);
  play(timer === null);
});
byId("back").addEventListener("click", () => { play(false); step(-1); });
byId("on").addEventListener("click", () => { play(false); step(1); });
byId("scrub").addEventListener("input", (event) => { play(false); goTo(Number(event.target.value) - recording.first); });
byId("speed").addEventListener("change", () => play(timer !== null));
byId("recording").addEventListener("change", (event) => open(Number(event.target.value), 0));
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("input, select, button, a, summary, .strip, .scroll")) return;
  const by = event.shiftKey ? 10 : 1;
  const moves = { ArrowLeft: () => goTo(frame - by), ArrowRight: () => goTo(frame + by), Home: () => goTo(0), End: () => goTo(recording.frames - 1) };
  const zooms = { "+": () => zoomBy(0.5), "-": () => zoomBy(2), 0: showAll };
  if (event.key === " ") play(timer === null);
  else if (moves[event.key]) { play(false); moves[event.key](); }
  else if (zooms[event.key]) zooms[event.key]();
  else return;
  event.preventDefault();
});
for (const link of document.querySelectorAll("a.still")) {
  const index = data.recordings.findIndex((one) => one.name === link.closest(".strip").dataset.recording);
  link.addEventListener("click", (event) => {
    event.preventDefault();
    open(index, Number(link.dataset.frame) - data.recordings[index].first);
    byId("player").scrollIntoView();
  });
}
let resized = null;
addEventListener("resize", () => { clearTimeout(resized); resized = setTimeout(() => { panels.forEach(({ plot }) => plot.setSize({ width: width(), height: plot.height })); show(); }, 100); });
addEventListener("hashchange", readAddress);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawCurves);
document.querySelectorAll(".scroll table").forEach(makeSortable);
drawScale();
if (!readAddress()) open(0, 0);
