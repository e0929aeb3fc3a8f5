// Ranges of frames [from, to], both ends included: in order, apart from each other.

/** Adds a range. */
export function plus(ranges, from, to) {
  const near = ranges.filter(([first, last]) => first <= to + 1 && last >= from - 1);
  const whole = [Math.min(from, ...near.map(([first]) => first)), Math.max(to, ...near.map(([, last]) => last))];
  return [...ranges.filter((range) => !near.includes(range)), whole].sort(([one], [other]) => one - other);
}

/** Takes a range away. */
export function minus(ranges, from, to) {
  return ranges.flatMap(([first, last]) => [[first, Math.min(last, from - 1)], [Math.max(first, to + 1), last]].filter(([begin, end]) => begin <= end));
}

/** Returns the range that a frame is in; undefined if there is none. */
export const rangeOf = (ranges, number) => ranges.find(([first, last]) => first <= number && number <= last);

export const lengthOf = (ranges) => ranges.reduce((sum, [first, last]) => sum + last - first + 1, 0);
