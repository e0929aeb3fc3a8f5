// Elements of the page.

export const byId = (id) => document.getElementById(id);

export const htmlNode = (name, attributes, ...children) => filled(document.createElement(name), attributes, children);
export const svgNode = (name, attributes, ...children) => filled(document.createElementNS("http://www.w3.org/2000/svg", name), attributes, children);

function filled(node, attributes, children) {
  Object.entries(attributes).forEach(([key, value]) => node.setAttribute(key, value));
  node.append(...children);
  return node;
}

/** A short line with the color and the dashes of a method; runners-up are dotted. */
export function sample(method, isSecond = false) {
  const line = { class: `sample look-${method}${isSecond ? " second" : ""}`, viewBox: "0 0 52 6", "aria-hidden": "true" };
  return svgNode("svg", line, svgNode("path", { d: "M0 3H52" }));
}

// The sizes of canvases, in pixels of the page. Asking an element each time would make the browser lay out the page.
const sizes = new WeakMap();
const resized = new ResizeObserver((entries) => entries.forEach(({ target, contentRect }) => sizes.set(target, contentRect)));

/**
 * Returns the width and height of a canvas in pixels of the page, and gives it as many pixels of its own as the screen
 * has there.
 */
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

/**
 * Returns a function that says whether `node` is in view, or nearly. Only nodes in view need to be drawn. `changed` is
 * called when it comes into view.
 */
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
