export const byId = (id) => document.getElementById(id);

export const htmlNode = (name, attributes, ...children) => filled(document.createElement(name), attributes, children);
export const svgNode = (name, attributes, ...children) => filled(document.createElementNS("http://www.w3.org/2000/svg", name), attributes, children);

function filled(node, attributes, children) {
  Object.entries(attributes).forEach(([key, value]) => node.setAttribute(key, value));
  node.append(...children);
  return node;
}

/** Returns a legend's sample line in the color and dashes of `method`; dotted if `isSecond` (the runner-up's curve). */
export function sample(method, isSecond = false) {
  const line = { class: `sample look-${method}${isSecond ? " second" : ""}`, viewBox: "0 0 52 6", "aria-hidden": "true" };
  return svgNode("svg", line, svgNode("path", { d: "M0 3H52" }));
}

// Sizes of canvases in CSS pixels, cached because reading them from an element can force a layout.
const sizes = new WeakMap();
const resized = new ResizeObserver((entries) => entries.forEach(({ target, contentRect }) => sizes.set(target, contentRect)));

/** Sets a canvas to the screen's resolution. Returns its width and height in CSS pixels. */
export function fitted(canvas) {
  if (!sizes.has(canvas)) {
    sizes.set(canvas, { width: canvas.clientWidth, height: canvas.clientHeight });
    resized.observe(canvas);
  }
  const { width, height } = sizes.get(canvas);
  const [wide, high] = [Math.round(width * devicePixelRatio), Math.round(height * devicePixelRatio)];
  if (canvas.width !== wide || canvas.height !== high) {
    [canvas.width, canvas.height] = [wide, high];
  }
  return { width, height };
}

/** Returns a function that tells if `node` is in or near the visible area. Calls `changed` when `node` enters it. */
export function inView(node, changed) {
  let isSeen = true;
  const observer = new IntersectionObserver(
    (entries) => {
      isSeen = entries.at(-1).isIntersecting;
      if (isSeen) {
        changed();
      }
    },
    { rootMargin: "200px" },
  );
  observer.observe(node);
  return () => isSeen;
}
