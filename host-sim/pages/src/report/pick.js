// The page on which boxes are dragged. What is shown follows from the targets, the active one of them, the frame and the zoom.
"use strict";
(() => {
  const byId = (id) => document.getElementById(id);
  const data = JSON.parse(byId("data").textContent);
  const { width, height, frames } = data;
  const [leastWidth, leastHeight] = data.least;
  const COLORS = ["#ff6ec7", "#4aa8ff", "#ffb02e", "#3ddc84", "#c58bff", "#ff5a4f", "#35d6e6", "#d6e35a"];
  const stage = byId("stage");

  const svgNode = (name, attributes, text) => {
    const node = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    if (text !== undefined) node.textContent = text;
    return node;
  };
  const clamp = (value, least, most) => Math.min(Math.max(value, least), most);
  /** A target has a `name`, a `color`, and, once it is drawn, a `box` in the `frame` of that number. */
  const targets = [{ name: "", color: COLORS[0], box: data.box && fitted(data.box), frame: data.shown }];
  let active = targets[0];
  let at = 0;
  const view = { x: 0, y: 0, zoom: 1 };

  const number = () => frames[at][0];
  /** Pixels of the recording for one of the screen. */
  const unit = () => width / view.zoom / (stage.getBoundingClientRect().width || width);

  // ---- boxes

  /** Whole pixels in the frame, not smaller than a tracker takes. */
  function fitted({ x, y, w, h }) {
    const size = (value, least, most) => clamp(Math.round(value) || 0, Math.min(least, most), most);
    const [wide, high] = [size(w, leastWidth, width), size(h, leastHeight, height)];
    return { x: clamp(Math.round(x) || 0, 0, width - wide), y: clamp(Math.round(y) || 0, 0, height - high), w: wide, h: high };
  }

  /** The box between two corners; each corner is on an edge between pixels. */
  function between(a, b) {
    const edge = (value, most) => clamp(Math.round(value), 0, most);
    const [left, right] = [edge(a.x, width), edge(b.x, width)].sort((one, other) => one - other);
    const [top, bottom] = [edge(a.y, height), edge(b.y, height)].sort((one, other) => one - other);
    return { x: left, y: top, w: right - left, h: bottom - top };
  }

  const inTheMiddle = () => ({ x: width * 0.375, y: height * 0.375, w: width / 4, h: height / 4 });

  /** The box of the active target, in the frame that is shown. */
  function setBox(box) {
    active.box = fitted(box);
    active.frame = number();
    show();
  }

  /** Puts the middle of the active box, if there is one, into the middle of the view. */
  function centreView() {
    const { x, y, w, h } = active.box ?? { x: 0, y: 0, w: width, h: height };
    const start = (middle, whole) => clamp(middle - whole / view.zoom / 2, 0, whole - whole / view.zoom);
    [view.x, view.y] = [start(x + w / 2, width), start(y + h / 2, height)];
  }

  /** Of a box that is moved by keys and fields: the view follows when its middle is out of it. */
  function follow() {
    const { x, y, w, h } = active.box;
    const isIn = (middle, from, whole) => middle >= from && middle <= from + whole / view.zoom;
    if (isIn(x + w / 2, view.x, width) && isIn(y + h / 2, view.y, height)) return;
    centreView();
    show();
  }

  // ---- what is shown

  function drawStage() {
    const [wide, high, px] = [width / view.zoom, height / view.zoom, unit()];
    stage.setAttribute("viewBox", [view.x, view.y, wide, high].join(" "));
    const href = "data:image/jpeg;base64," + frames[at][1];
    const picture = svgNode("image", { href, width, height, preserveAspectRatio: "none", class: px < 0.25 ? "sharp" : "" });
    const drawn = targets.filter((target) => target.box && target !== active);
    if (active.box) drawn.push(active);
    stage.replaceChildren(picture, ...drawn.map((target) => outline(target, px)));
    const box = active.box;
    const words = box ? `${nameOf(active) || "box"}: left ${box.x}, top ${box.y}, ${box.w} x ${box.h} pixels` : "no box yet";
    stage.setAttribute("aria-label", `Frame ${number()}, ${words}`);
  }

  function outline(target, px) {
    const { x, y, w, h } = target.box;
    const group = svgNode("g", { style: `--c:${target.color}`, class: target.frame === number() ? "here" : "elsewhere" });
    for (const name of ["under", "box"]) group.append(svgNode("rect", { class: name, x, y, width: w, height: h }));
    const letters = 14 * px;
    const above = y - view.y > 2 * letters;
    const text = [nameOf(target), target.frame === number() ? "" : `frame ${target.frame}`].filter(Boolean).join(", ");
    group.append(svgNode("text", { x, y: above ? y - 9 * px : y + h + 1.8 * letters, "font-size": letters }, text));
    if (target === active) {
      const side = (matchMedia("(pointer: coarse)").matches ? 18 : 9) * px;
      for (const across of [0, 0.5, 1]) for (const down of [0, 0.5, 1]) {
        if (across === 0.5 && down === 0.5) continue;
        group.append(svgNode("rect", { class: "handle", x: x + across * w - side / 2, y: y + down * h - side / 2, width: side, height: side }));
      }
    }
    return group;
  }

  function drawFrameNumber() {
    const said = `frame ${number()} of ${data.last}`;
    byId("place").value = said;
    byId("scrub").value = at;
    byId("scrub").setAttribute("aria-valuetext", said);
    byId("back").disabled = at === 0;
    byId("on").disabled = at === frames.length - 1;
  }

  function drawNumbers() {
    const box = active.box;
    for (const key of ["x", "y", "w", "h"]) byId(key).value = box ? box[key] : "";
    const where = box && active.frame !== number() ? ` The box is of frame ${active.frame}: change it, and it is of frame ${number()}.` : "";
    byId("said").textContent = box ? `${box.w} x ${box.h} pixels at (${box.x}, ${box.y}).${where}` : "Drag a box over the target.";
  }

  /** The names as they stand in the command line: what a shell and host-sim take without quotes, and none twice. */
  function names() {
    const taken = [];
    for (const [place, { name }] of targets.entries()) {
      const plain = name.trim().replace(/[^\p{L}\p{N}_-]+/gu, "_").replace(/^-+/, "");
      const wanted = plain || (targets.length > 1 ? `target${place + 1}` : "");
      let free = wanted;
      for (let count = 2; free && taken.includes(free); count += 1) free = `${wanted}_${count}`;
      taken.push(free);
    }
    return taken;
  }

  const nameOf = (target) => names()[targets.indexOf(target)];

  function drawCommands() {
    const init = (target) => {
      const { x, y, w, h } = target.box;
      const name = nameOf(target);
      return `--init ${name && name + "="}${[x, y, w, h].join(",")}${target.frame === 1 ? "" : "@" + target.frame}`;
    };
    const chosen = targets.filter((target) => target.box);
    for (const command of ["track", "report"]) {
      const [before, after] = data[command];
      byId(command).textContent = chosen.length ? [before, ...chosen.map(init), after].filter(Boolean).join(" ") : "Drag a box first.";
      document.querySelector(`[data-of=${command}]`).disabled = !chosen.length;
    }
  }

  /** The list of targets is made anew only when there are more or fewer: the field that is typed in stays. */
  function drawTargets() {
    const list = byId("targets");
    if (list.children.length !== targets.length) list.replaceChildren(...targets.map(row));
    [...list.children].forEach((item, place) => {
      const { box, frame, color } = targets[place];
      item.style.setProperty("--c", color);
      item.classList.toggle("active", targets[place] === active);
      item.querySelector("[type=radio]").checked = targets[place] === active;
      item.querySelector("[type=text]").placeholder = nameOf(targets[place]) || "name (optional)";
      item.querySelector("span").textContent = box ? `frame ${frame}: ${box.x},${box.y},${box.w},${box.h}` : "no box yet";
      item.querySelector(".where button").hidden = !box || frame === number();
    });
  }

  function row(target, place) {
    const item = document.createElement("li");
    item.innerHTML = `<input type="radio" name="active"><input type="text" maxlength="40"><button type="button">Remove</button>
      <div class="where"><span></span><button type="button">Go there</button></div>`;
    const [radio, name] = item.querySelectorAll("input");
    const [remove, go] = item.querySelectorAll("button");
    radio.setAttribute("aria-label", `Draw target ${place + 1}`);
    name.setAttribute("aria-label", `Name of target ${place + 1}`);
    remove.setAttribute("aria-label", `Remove target ${place + 1}`);
    name.value = target.name;
    radio.addEventListener("change", () => { active = target; show(); });
    name.addEventListener("input", () => { target.name = name.value; show(); });
    remove.disabled = targets.length === 1;
    remove.addEventListener("click", () => {
      targets.splice(targets.indexOf(target), 1);
      if (active === target) active = targets[0];
      show();
      byId("add").focus();
    });
    go.addEventListener("click", () => { active = target; goTo(nearest(target.frame)); stage.focus(); });
    return item;
  }

  function show() {
    drawStage();
    drawFrameNumber();
    drawNumbers();
    drawTargets();
    drawCommands();
  }

  // ---- frames

  /** The place of the frame whose number is nearest. */
  function nearest(wanted) {
    const far = (place) => Math.abs(frames[place][0] - wanted);
    return frames.reduce((best, _, place) => (far(place) < far(best) ? place : best), 0);
  }

  function goTo(place) {
    at = clamp(place, 0, frames.length - 1);
    show();
    writeAddress();
  }

  /** Browsers refuse an address that changes too often. */
  let writing = null;
  function writeAddress() {
    writing ??= setTimeout(() => { writing = null; history.replaceState(null, "", "#frame=" + number()); }, 400);
  }

  function readAddress() {
    const wanted = Number(new URLSearchParams(location.hash.slice(1)).get("frame"));
    if (wanted) { at = nearest(wanted); show(); }
  }

  // ---- mouse, pen and finger

  const place = (event) => {
    const { left, top } = stage.getBoundingClientRect();
    return { x: view.x + (event.clientX - left) * unit(), y: view.y + (event.clientY - top) * unit() };
  };

  /** What of the box is under the pointer: an edge or corner as [-1, 0 or 1 across, the same down], its inside as [0, 0], or nothing. */
  function grip(box, { x, y }, reach) {
    const side = (value, from, size) => {
      // A small box keeps an inside to move it by.
      const inner = Math.min(reach, size / 4);
      if (value < from - reach || value > from + size + reach) return null;
      return value < from + inner ? -1 : value > from + size - inner ? 1 : 0;
    };
    const found = [side(x, box.x, box.w), side(y, box.y, box.h)];
    return found.includes(null) ? null : found;
  }

  function gripAt(event) {
    const reach = ({ touch: 26, pen: 16 }[event.pointerType] ?? 10) * unit();
    const [point, inside] = [place(event), (target) => target.box && target.frame === number() && grip(target.box, place(event), 0)];
    const held = active.box && grip(active.box, point, reach);
    if (held) return { target: active, held };
    const other = targets.find((target) => inside(target));
    return other ? { target: other, held: [0, 0] } : { target: active, held: null };
  }

  /** The box when what was held at `from` is at `to`. */
  function dragged(box, held, from, to) {
    if (held === null) return between(from, to);
    const [dx, dy] = [to.x - from.x, to.y - from.y];
    const [across, down] = held;
    if (!across && !down) return { ...box, x: box.x + dx, y: box.y + dy };
    const ends = (start, size, side, by) => [start + (side < 0 ? by : 0), start + size + (side > 0 ? by : 0)];
    const [left, right] = ends(box.x, box.w, across, dx);
    const [top, bottom] = ends(box.y, box.h, down, dy);
    return between({ x: left, y: top }, { x: right, y: bottom });
  }

  let drag = null;
  stage.addEventListener("pointerdown", (event) => {
    if (drag || event.button !== 0) return;
    event.preventDefault();
    stage.focus({ preventScroll: true });
    const { target, held } = gripAt(event);
    active = target;
    drag = { id: event.pointerId, held, from: place(event), before: { box: target.box, frame: target.frame }, moved: false };
    try { stage.setPointerCapture(event.pointerId); } catch { /* the pointer is gone already */ }
    show();
  });
  stage.addEventListener("pointermove", (event) => {
    if (!drag) { stage.style.cursor = cursorOf(gripAt(event).held); return; }
    if (event.pointerId !== drag.id) return;
    const to = place(event);
    // A click is no drag.
    drag.moved ||= Math.hypot(to.x - drag.from.x, to.y - drag.from.y) > 3 * unit();
    if (drag.moved) setBox(dragged(drag.before.box, drag.held, drag.from, to));
  });
  const cursorOf = (held) => {
    if (!held) return "crosshair";
    const [across, down] = held;
    if (!across && !down) return "move";
    return !down ? "ew-resize" : !across ? "ns-resize" : across === down ? "nwse-resize" : "nesw-resize";
  };
  stage.addEventListener("pointerup", (event) => { if (drag && event.pointerId === drag.id) drag = null; });
  stage.addEventListener("pointercancel", (event) => {
    if (!drag || event.pointerId !== drag.id) return;
    Object.assign(active, drag.before);
    drag = null;
    show();
  });

  // ---- keys, fields and buttons

  const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  stage.addEventListener("keydown", (event) => {
    const step = STEPS[event.key];
    const resizes = event.ctrlKey || event.altKey;
    if (event.metaKey) return;
    if (step) {
      const by = event.shiftKey ? 10 : 1;
      const [dx, dy] = [step[0] * by, step[1] * by];
      const box = active.box ?? inTheMiddle();
      if (!active.box) setBox(box);
      else if (resizes) setBox({ ...box, w: clamp(box.w + dx, 0, width - box.x), h: clamp(box.h + dy, 0, height - box.y) });
      else setBox({ ...box, x: box.x + dx, y: box.y + dy });
      follow();
    } else if (event.key === "Enter" && !active.box) setBox(inTheMiddle());
    else if (event.key === "PageDown") goTo(at + 1);
    else if (event.key === "PageUp") goTo(at - 1);
    else return;
    event.preventDefault();
  });
  for (const key of ["x", "y", "w", "h"]) {
    byId(key).min = { w: leastWidth, h: leastHeight }[key] ?? 0;
    byId(key).max = { x: width - leastWidth, y: height - leastHeight, w: width, h: height }[key];
    byId(key).addEventListener("change", (event) => {
      if (event.target.value === "") return show();
      setBox({ ...(active.box ?? fitted(inTheMiddle())), [key]: Number(event.target.value) });
      follow();
    });
  }
  byId("add").addEventListener("click", () => {
    const free = COLORS.find((color) => targets.every((target) => target.color !== color));
    active = { name: "", color: free ?? COLORS[targets.length % COLORS.length], box: null, frame: number() };
    targets.push(active);
    show();
    byId("targets").lastElementChild.querySelector("[type=text]").focus();
  });
  byId("back").addEventListener("click", () => goTo(at - 1));
  byId("on").addEventListener("click", () => goTo(at + 1));
  byId("scrub").addEventListener("input", (event) => goTo(Number(event.target.value)));
  byId("zoom").addEventListener("change", (event) => {
    view.zoom = Number(event.target.value);
    centreView();
    show();
  });
  for (const button of document.querySelectorAll("[data-of]")) button.addEventListener("click", () => copy(button));

  async function copy(button) {
    const text = byId(button.dataset.of);
    try {
      await navigator.clipboard.writeText(text.textContent);
      button.textContent = "Copied";
    } catch {
      // Without the right to the clipboard, the text is there to be copied by hand.
      getSelection().selectAllChildren(text);
      button.textContent = document.execCommand("copy") ? "Copied" : "Selected";
    }
    setTimeout(() => { button.textContent = "Copy"; }, 2000);
  }

  addEventListener("resize", show);
  addEventListener("hashchange", readAddress);
  byId("scrub").max = frames.length - 1;
  at = nearest(data.shown);
  show();
  readAddress();
})();
