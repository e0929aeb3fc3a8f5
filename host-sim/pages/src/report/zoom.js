// The part of the frames that all curves show: zoomed by a drag (by uPlot), pinched and moved here. Part of the page's script, see page.html.

const whole = () => ({ min: recording.first, max: lastNumber() });
/** What is shown; a curve that has just been made does not know yet. */
const part = () => {
  const { min, max } = panels.length ? panels[0].plot.scales.x : {};
  return min === undefined || min === null ? whole() : { min, max };
};
const isWhole = () => part().min <= recording.first && part().max >= lastNumber();

/** All curves show the same frames, at least a few of them, and none that there is not. */
function setPart(min, max) {
  if (!panels.length) return;
  const all = whole();
  const length = clamp(max - min, Math.min(5, all.max - all.min), all.max - all.min);
  const start = clamp(min + (max - min - length) / 2, all.min, all.max - length);
  for (const { plot } of panels) plot.setScale("x", { min: start, max: start + length });
}

function showAll() {
  setPart(recording.first, lastNumber());
}

function moveBy(frames) {
  setPart(part().min + frames, part().max + frames);
}

/** Around the frame in the player, or around `middle`: so many times as many frames. */
function zoomBy(factor, middle = numberOf(frame)) {
  if (!panels.length) return;
  const { min, max } = part();
  const around = clamp(middle, min, max);
  setPart(around - (around - min) * factor, around + (max - around) * factor);
}

/** What moves and pinches the curves that `plot` shows. */
function addZoom(plot) {
  const over = plot.over;
  const frames = (pixels) => pixels * (part().max - part().min) / over.clientWidth;
  const numberAt = (x) => plot.posToVal(x - over.getBoundingClientRect().left, "x");

  // uPlot takes a drag as a zoom; with shift it is ours.
  over.addEventListener("mousedown", (event) => {
    if (!event.shiftKey || event.button !== 0) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    let last = event.clientX;
    const move = (moved) => { moveBy(frames(last - moved.clientX)); last = moved.clientX; };
    const stop = () => {
      document.removeEventListener("mousemove", move);
      document.removeEventListener("mouseup", stop);
    };
    document.addEventListener("mousemove", move);
    document.addEventListener("mouseup", stop);
  }, true);

  // Up and down, the wheel scrolls the page; sideways, or with shift, it is ours.
  over.addEventListener("wheel", (event) => {
    const isSideways = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
    if (event.ctrlKey || isWhole() || !isSideways) return;
    event.preventDefault();
    moveBy(frames(event.deltaX || event.deltaY));
  }, { passive: false });

  // One finger moves, two pinch. A finger that goes up or down scrolls the page: see `touch-action`.
  const fingers = new Map();
  over.addEventListener("pointerdown", (event) => { if (event.pointerType === "touch") fingers.set(event.pointerId, event.clientX); });
  over.addEventListener("pointermove", (event) => {
    if (!fingers.has(event.pointerId)) return;
    const before = [...fingers.values()];
    fingers.set(event.pointerId, event.clientX);
    const now = [...fingers.values()];
    if (now.length === 1) { if (!isWhole()) moveBy(frames(before[0] - now[0])); return; }
    const apart = ([a, b]) => Math.max(Math.abs(a - b), 10);
    zoomBy(apart(before) / apart(now), numberAt((now[0] + now[1]) / 2));
  });
  for (const kind of ["pointerup", "pointercancel", "pointerleave"]) over.addEventListener(kind, (event) => fingers.delete(event.pointerId));
}
