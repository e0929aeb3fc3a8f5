// The targets as edited by the user: their names, and the boxes that they are locked on. Each change can be undone.

import { minus, plus, rangeOf } from "./ranges.js";

const MAX_UNDONE = 500;
const MAX_UNDER_WAY = 50; // changes that host-sim may still refuse

/** Converts a name to one that a shell and host-sim accept without quotes. */
export const plainName = (name) => name.trim().replace(/[^\p{L}\p{N}_-]+/gu, "_").replace(/^-+/, "");

/** Returns the name of a target, or `target` and its id if it has none. */
export const nameOf = ({ id, name }) => name || `target${id}`;

export const lockIn = (target, number) => target?.locks.find((lock) => lock.number === number);

export const isGone = (target, number) => target?.locks.findLast((lock) => lock.number <= number)?.box === null;

export const isHidden = ({ hidden }, number) => rangeOf(hidden, number) !== undefined;

/** Returns the box on the line between two boxes by hand; undefined if a tracker finds the target in this frame. */
export function lineIn(target, number) {
  const at = target.locks.findLastIndex((lock) => lock.number <= number);
  const [from, to] = [target.locks[at], target.locks[at + 1]];
  if (!from?.byHand) {
    return undefined;
  }
  const part = (number - from.number) / (to.number - from.number);
  return Object.fromEntries(Object.keys(from.box).map((side) => [side, from.box[side] + (to.box[side] - from.box[side]) * part]));
}

/**
 * Converts a target from host-sim's form: { id, name, locks: [{ frame, box: [x, y, width, height] or null, by_hand }],
 * hidden, checked }.
 */
export function targetOf({ id, name, locks, hidden, checked }) {
  const boxOf = (box) => box && { x: box[0], y: box[1], width: box[2], height: box[3] };
  return { id, name, hidden, checked, locks: locks.map(({ frame, box, by_hand: byHand }) => lockOf(frame, boxOf(box), byHand)) };
}

/** Converts a target, and the frames in which it was looked at, to host-sim's form. */
export function toldOf(target, checked = []) {
  const { id, locks, hidden } = target;
  const told = ({ number, box, byHand }) => ({ frame: number, box: box && [box.x, box.y, box.width, box.height], by_hand: byHand ?? false });
  return { id, name: nameOf(target), locks: locks.map(told), hidden, checked };
}

export class Edits {
  /**
   * All targets: { id, name, locks: [{ number, box, byHand }], hidden }, locks by ascending frame number. A null
   * box means that the target is gone until its next box; `byHand`, that it goes to its next box on a line. `hidden` are
   * ranges, see ranges.js, in which something covers the target. The objects are replaced, never changed.
   */
  targets = [];
  /** Ranges of frames in which the user has looked at the present boxes, by the id of a target. */
  checked = new Map();
  /** The largest id that was ever given. It never goes back, so that no id is given twice. */
  ids = 0;
  #chosen = null; // an id; null: the next box is a new target
  #past = []; // { targets, chosen, checked } before each change; with `length`, if the length in the picture was changed
  #future = [];
  #steps = []; // the last changes: the targets after each, and all that was before

  /** The target that the next drawn box is for; null if that box creates a new target. */
  get chosen() {
    return this.targets.find(({ id }) => id === this.#chosen) ?? null;
  }

  get canUndo() {
    return this.#past.length > 0;
  }

  get canRedo() {
    return this.#future.length > 0;
  }

  choose(target) {
    this.#chosen = target?.id ?? null;
  }

  /**
   * Replaces all targets by { id, name, locks } of another page or a session, and clears the undo history. `ids` is the
   * largest id that was ever given there.
   */
  load(targets, ids = 0) {
    [this.#past, this.#future, this.#steps] = [[], [], []];
    const isAdding = this.targets.length > 0 && this.#chosen === null;
    this.#take(targets, ids);
    this.#chosen = this.chosen?.id ?? (isAdding ? null : (this.targets[0]?.id ?? null));
  }

  /** Replaces all targets as `load` does, by a change that can be undone. */
  resume(targets, ids) {
    const before = this.#now;
    this.#take(targets, ids);
    const { targets: after, checked } = this;
    [this.targets, this.checked] = [before.targets, before.checked];
    this.#replace(after, after[0]?.id ?? null);
    this.checked = checked;
  }

  #take(targets, ids) {
    this.targets = targets.map(({ checked, ...target }) => ({ hidden: [], ...defined(target), locks: inOrder(target.locks), name: isPlain(target) ? "" : target.name }));
    this.checked = new Map(targets.map(({ id, checked }) => [id, checked ?? []]));
    for (let twice = this.#namedTwice(); twice !== undefined; twice = this.#namedTwice()) {
      twice.name = "";
    }
    this.ids = Math.max(this.ids, ids, ...targets.map(({ id }) => id));
  }

  /** Locks a target on `box` in a frame, replacing the target's lock there. If `target` is null, adds a new target. */
  lock(number, box, target = this.chosen) {
    const { locks, hidden, ...rest } = target ?? this.#made();
    const others = locks.filter((lock) => lock.number !== number);
    const isOnLine = box !== null && locks.findLast((lock) => lock.number <= number)?.byHand;
    const [, until] = (box && rangeOf(hidden, number)) ?? [];
    const locked = { ...rest, locks: inOrder([...others, lockOf(number, box, isOnLine)]), hidden: until === undefined ? hidden : minus(hidden, number, until) };
    target === null ? this.#replace([...this.targets, locked], locked.id) : this.#renew(locked, locked.id);
  }

  /** Sets whether the target goes from its box in a frame to the next on a line. */
  setByHand(target, number, isByHand) {
    this.#renew({ ...target, locks: inOrder(target.locks.map((lock) => (lock.number === number ? lockOf(number, lock.box, isByHand) : lock))) });
  }

  setHidden(target, hidden) {
    this.#renew({ ...target, hidden });
  }

  /** Notes that the user has looked at a target in these frames. This is no change that is undone. */
  check({ id }, from, to) {
    this.checked.set(id, plus(this.checked.get(id) ?? [], from, to));
  }

  /** Forgets what the user has looked at, also in what can be undone: other boxes are to come. */
  forget() {
    [this, ...this.#past, ...this.#future, ...this.#steps.map(({ before }) => before)].forEach(({ checked }) => checked.clear());
  }

  /** Marks a target as absent, starting at frame `number` and until its next box. */
  lose(target, number) {
    this.lock(number, null, target);
  }

  /** Removes a target's lock in a frame; if it was the only lock, removes the target. */
  unlock(target, number) {
    const locks = inOrder(target.locks.filter((lock) => lock.number !== number));
    locks.length === 0 ? this.remove(target) : this.#renew({ ...target, locks });
  }

  add(targets) {
    const before = this.targets;
    for (const { name, locks, hidden = [] } of targets) {
      const made = this.#made();
      // Each name is checked against those that are added before it.
      this.targets = [...this.targets, { ...made, name: this.#freeName(name), locks: inOrder(locks), hidden }];
    }
    const after = this.targets;
    this.targets = before;
    this.#replace(after, after.at(-1)?.id ?? null);
  }

  remove({ id }) {
    const left = this.targets.filter((one) => one.id !== id);
    this.#replace(left, this.#chosen === id ? (left.at(-1)?.id ?? null) : this.#chosen);
  }

  /** Renames a target. Returns an error message if another target has the name, else null. */
  rename({ id }, text) {
    const name = plainName(text);
    if (this.targets.some((one) => one.id !== id && nameOf(one) === nameOf({ id, name }))) {
      return `Another target is called ${nameOf({ id, name })}: give this one another name.`;
    }
    this.#renew({ ...this.targets.find((one) => one.id === id), name });
    return null;
  }

  /** Notes that the user has changed the length in the picture, which was `length` before, so that it can be undone. */
  measured(length) {
    [this.#past, this.#future] = [[...this.#past, { ...this.#now, length }].slice(-MAX_UNDONE), []];
  }

  /**
   * Undoes the last change. If that is one of the length in the picture, which is `length` now, returns the length that it
   * was; else undefined.
   */
  undo(length) {
    const step = this.#past.at(-1);
    return step && this.#goTo(step, this.#past.slice(0, -1), [...this.#future, this.#opposite(step, length)]);
  }

  /** Does again what was undone last. Takes and returns a length as `undo` does. */
  redo(length) {
    const step = this.#future.at(-1);
    return step && this.#goTo(step, [...this.#past, this.#opposite(step, length)], this.#future.slice(0, -1));
  }

  /** Reverts the refused change that led to the list `targets`, unless the targets have changed again since. */
  takeBack(targets) {
    const step = this.#steps.findLast(({ after }) => after === targets);
    if (step === undefined) {
      return;
    }
    // If a later change is refused as well, it must revert to the state before this change.
    this.#steps.filter(({ before }) => before.targets === targets).forEach((later) => (later.before = step.before));
    if (this.targets === targets) {
      this.#recheck(step.before);
      ({ targets: this.targets, past: this.#past, future: this.#future, chosen: this.#chosen } = step.before);
    }
  }

  get #now() {
    return { targets: this.targets, chosen: this.#chosen, checked: new Map(this.checked) };
  }

  #opposite(step, length) {
    return step.length === undefined ? this.#now : { ...this.#now, length };
  }

  #goTo(step, past, future) {
    step.length === undefined ? this.#change(step, past, future) : ([this.#past, this.#future] = [past, future]);
    return step.length;
  }

  // Sets the targets, the chosen one and the history, and stores the former state for `takeBack`.
  #change({ targets, chosen, checked }, past, future) {
    const before = { ...this.#now, past: this.#past, future: this.#future };
    this.#recheck({ targets, checked });
    [this.targets, this.#chosen, this.#past, this.#future] = [targets, chosen, past.slice(-MAX_UNDONE), future];
    this.#steps = [...this.#steps, { after: targets, before }].slice(-MAX_UNDER_WAY);
  }

  #made() {
    do {
      this.ids += 1;
    } while (this.targets.some((one) => nameOf(one) === `target${this.ids}`));
    return { id: this.ids, name: "", locks: [], hidden: [] };
  }

  // The frames in which a target may have other boxes than before must be looked at again, except those in `checked`,
  // which the user has looked at when it had these boxes.
  #recheck({ targets, checked }) {
    for (const { id, locks } of targets) {
      const before = this.targets.find((one) => one.id === id)?.locks ?? locks;
      const [from, to] = differing(before, locks);
      if (from !== undefined) {
        const again = minus(minus(checked?.get(id) ?? [], 0, from - 1), to + 1, Infinity);
        this.checked.set(id, again.reduce((all, range) => plus(all, ...range), minus(this.checked.get(id) ?? [], from, to)));
      }
    }
  }

  // Returns the name, or an empty text if an existing target has this name.
  #freeName(name) {
    const plain = plainName(name);
    return this.targets.every((target) => nameOf(target) !== plain) ? plain : "";
  }

  #namedTwice() {
    return this.targets.find((one) => one.name !== "" && this.targets.some((other) => other !== one && nameOf(other) === nameOf(one)));
  }

  #renew(target, chosen = this.#chosen) {
    this.#replace(this.targets.map((one) => (one.id === target.id ? target : one)), chosen);
  }

  #replace(targets, chosen = this.#chosen) {
    this.#change({ targets, chosen }, [...this.#past, this.#now], []);
  }
}

// True if a target has the name that host-sim and this page give to one without a name.
const isPlain = ({ id, name }) => ["target", `target${id}`].includes(name);

const lockOf = (number, box, byHand) => (byHand ? { number, box, byHand } : { number, box });

const defined = (object) => Object.fromEntries(Object.entries(object).filter(([, value]) => value !== undefined));

// Sorts locks by frame, and drops each mark "gone" that follows another one or precedes the first box, and each line
// that leads to no box.
function inOrder(locks) {
  const sorted = [...locks].sort((one, other) => one.number - other.number);
  const kept = sorted.filter(({ box }, at) => box !== null || (at > 0 && sorted[at - 1].box !== null));
  return kept.map((lock, at) => (lock.byHand && !(lock.box && kept[at + 1]?.box) ? lockOf(lock.number, lock.box) : lock));
}

// Returns the first and the last frame between which boxes can differ; an empty list if none does.
function differing(old, locks) {
  const isSame = (one, other) => one !== undefined && other !== undefined && one.number === other.number && one.byHand === other.byHand && JSON.stringify(one.box) === JSON.stringify(other.box);
  const same = locks.findIndex((lock, at) => !isSame(lock, old[at]));
  const first = same < 0 ? locks.length : same;
  if (first === locks.length && first === old.length) {
    return [];
  }
  let behind = 0;
  while (behind < Math.min(old.length, locks.length) - first && isSame(old.at(-1 - behind), locks.at(-1 - behind))) {
    behind += 1;
  }
  const last = behind === 0 ? Infinity : locks.at(-behind).number - 1;
  // A line that ends at the first lock that differs begins at the lock before it.
  const isLine = [old, locks].some((all) => all[first - 1]?.byHand);
  return [isLine ? locks[first - 1].number + 1 : Math.min(...[old, locks].flatMap((all) => all[first]?.number ?? [])), last];
}
