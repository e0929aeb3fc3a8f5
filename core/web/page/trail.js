// The path of a target through the last frames.

const FRAMES = 75;

/** Draws the path of the box's centre until a frame. `boxAt(number)` is a box or null; `placed(box)` its place on the canvas. */
export function drawTrail(context, number, { boxAt, placed, color }) {
  const points = Array.from({ length: FRAMES }, (_, back) => boxAt(number - FRAMES + 1 + back)).map((box) => (box ? centre(placed(box)) : null));
  context.setLineDash([]);
  context.lineWidth = 2;
  context.strokeStyle = color;
  points.forEach((to, at) => {
    const from = points[at - 1];
    if (from && to) {
      context.globalAlpha = at / FRAMES;
      context.beginPath();
      context.moveTo(...from);
      context.lineTo(...to);
      context.stroke();
    }
  });
  context.globalAlpha = 1;
}

const centre = ([x, y, width, height]) => [x + width / 2, y + height / 2];
