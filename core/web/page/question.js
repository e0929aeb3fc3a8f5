// Decides when the page asks what a box is for, because a wrong guess would move a target onto something else.

const MIN_OVERLAP = 1 / 4; // intersection over union
const MIN_PART = 1 / 4; // of the former area: a smaller box may be a slip
const MIN_SIDE = 8; // pixels of a new target: with less, the drag may be a slip, and trackers hardly tell it from others

/** Returns the sentence before the question whether a box is a new target; null if it clearly is. */
export const slipOf = ({ width, height }) => (Math.min(width, height) < MIN_SIDE ? `This box has ${width}x${height} pixels: a target of less than ${MIN_SIDE}x${MIN_SIDE} is hard to follow.` : null);

/**
 * Returns the sentence before the question "new target or correction?"; null if `box` is clearly a correction of the
 * target `name`. `former` is the box that was pulled if `isPulled`, else the target's box in this frame; null if the
 * target is gone. A target that `isLost` can be anywhere.
 */
export function doubtOf(box, { name, former, isPulled, isLost }) {
  if (former === null) {
    return `${name} is gone in this frame.`;
  }
  const [area, before, common] = [areaOf(box), areaOf(former), commonOf(box, former)];
  const isElsewhere = !isPulled && !isLost && common < (area + before - common) * MIN_OVERLAP;
  if (area >= before * MIN_PART && !isElsewhere) {
    return null;
  }
  return isElsewhere && common < Math.min(area, before) / 2
    ? `This box hardly overlaps that of ${name}.`
    : `This box has ${box.width}x${box.height} pixels, and that of ${name} ${former.width}x${former.height}.`;
}

const areaOf = ({ width, height }) => width * height;

function commonOf(one, other) {
  const shared = (from, length) => Math.max(Math.min(one[from] + one[length], other[from] + other[length]) - Math.max(one[from], other[from]), 0);
  return shared("x", "width") * shared("y", "height");
}
