// Parts of the page of `host-sim view` that need no browser: edits of targets, answers of many frames, command lines.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Answers } from "../page/answers.js";
import { gripOf } from "../page/drag.js";
import { Connection } from "../page/connection.js";
import { Edits, lineIn, lockIn, nameOf, plainName, targetOf, toldOf } from "../page/edits.js";
import { ENDED, Messages } from "../page/messages.js";
import { doubtOf, slipOf } from "../page/question.js";
import { Images } from "../page/image-cache.js";
import { lengthOf, minus, plus, rangeOf } from "../page/ranges.js";
import { random } from "./library.mjs";

const BOX = { x: 1, y: 2, width: 30, height: 40 };
const MOVED = { ...BOX, x: 5 };
const numbers = ({ targets }) => targets.map(({ locks }) => locks.map(({ number }) => number));

test("a box is a new target, a later one a correction, and each step is undone and done again", () => {
  const edits = new Edits();
  edits.lock(10, BOX);
  edits.lock(40, BOX);
  edits.lock(5, BOX);
  assert.deepEqual(numbers(edits), [[5, 10, 40]]);
  edits.lock(10, MOVED);
  assert.deepEqual([numbers(edits), lockIn(edits.chosen, 10).box], [[[5, 10, 40]], MOVED]);
  edits.undo();
  assert.deepEqual(lockIn(edits.chosen, 10).box, BOX);
  for (let count = 0; count < 3; count++) {
    edits.undo();
  }
  assert.deepEqual([edits.targets, edits.chosen, edits.canUndo], [[], null, false]);
  edits.undo();
  edits.redo();
  edits.redo();
  assert.deepEqual(numbers(edits), [[10, 40]]);
  edits.lock(7, BOX);
  assert.equal(edits.canRedo, false, "after a new change there is nothing to do again");
});

test("a change of the length in the picture is a step of its own: undo gives the length back, and takes no box away", () => {
  const edits = new Edits();
  const [short, long] = [{ pixels_per_metre: 10 }, { pixels_per_metre: 20 }];
  edits.lock(10, BOX);
  edits.measured(null);
  edits.lock(40, BOX);
  edits.measured(short);
  assert.deepEqual([edits.undo(long), numbers(edits)], [short, [[10, 40]]]);
  assert.deepEqual([edits.undo(short), numbers(edits)], [undefined, [[10]]]);
  assert.deepEqual([edits.undo(short), numbers(edits)], [null, [[10]]]);
  assert.deepEqual([edits.redo(null), edits.redo(short), edits.redo(short), numbers(edits), edits.canRedo], [short, undefined, long, [[10, 40]], false]);
  assert.deepEqual([edits.undo(long), edits.undo(short), edits.undo(short), edits.undo(null), edits.canUndo], [short, undefined, null, undefined, false]);
  edits.redo(null);
  edits.measured(null);
  assert.equal(edits.canRedo, false, "after a new length there is nothing to do again");
});

test("the last box of a target takes the target with it, and its number is not used again", () => {
  const edits = new Edits();
  edits.lock(1, BOX);
  edits.choose(null);
  edits.lock(1, BOX);
  assert.deepEqual([edits.targets.map(nameOf), nameOf(edits.chosen)], [["target1", "target2"], "target2"]);
  edits.unlock(edits.chosen, 1);
  assert.deepEqual([edits.targets.length, nameOf(edits.chosen)], [1, "target1"]);
  edits.choose(null);
  edits.lock(3, BOX);
  assert.equal(edits.chosen.id, 3);
});

const LATER = { ...BOX, x: 11, width: 50 };

test("boxes between two by hand lie on a line, which a box on it bends, and which ends where there is no next box", () => {
  const edits = new Edits();
  edits.lock(10, BOX);
  edits.lock(20, LATER);
  const lines = () => edits.chosen.locks.filter(({ byHand }) => byHand).map(({ number }) => number);
  edits.setByHand(edits.chosen, 10, true);
  assert.deepEqual([lines(), [10, 15, 20, 9, 21].map((number) => lineIn(edits.chosen, number)?.x)], [[10], [1, 6, undefined, undefined, undefined]]);
  assert.deepEqual(lineIn(edits.chosen, 13), { x: 4, y: 2, width: 36, height: 40 });
  edits.lock(14, MOVED);
  assert.deepEqual([lines(), lineIn(edits.chosen, 12).x, lineIn(edits.chosen, 17).x], [[10, 14], 3, 8]);
  edits.unlock(edits.chosen, 20);
  assert.deepEqual(lines(), [10], "no box follows the one in frame 14");
  edits.lose(edits.chosen, 12);
  assert.deepEqual(lines(), [], "no line leads to where the target is gone");
  edits.undo();
  edits.undo();
  assert.deepEqual(lines(), [10, 14]);
  assert.deepEqual(targetOf(toldOf(edits.chosen, [[1, 3]])), { ...targetOf(toldOf(edits.chosen)), checked: [[1, 3]] });
  assert.deepEqual(targetOf(toldOf(edits.chosen)).locks, edits.chosen.locks);
});

test("what was looked at comes back with its boxes, and goes with the method", () => {
  const edits = new Edits();
  const seen = () => edits.checked.get(1);
  edits.lock(1, BOX);
  edits.check(edits.chosen, 1, 40);
  edits.lock(20, MOVED);
  assert.deepEqual(seen(), [[1, 19]]);
  edits.check(edits.chosen, 25, 50);
  edits.undo();
  assert.deepEqual(seen(), [[1, 40]], "with the boxes that were there before");
  edits.redo();
  assert.deepEqual(seen(), [[1, 19], [25, 50]]);
  edits.undo();
  edits.check(edits.chosen, 60, 70);
  edits.setHidden(edits.chosen, [[5, 9]]);
  edits.undo();
  assert.deepEqual(seen(), [[1, 40], [60, 70]], "what is hidden changes no box");
  edits.lock(30, MOVED);
  edits.takeBack(edits.targets);
  assert.deepEqual([seen(), edits.chosen.locks.length], [[[1, 40], [60, 70]], 1], "a change that is refused");
  edits.lock(30, MOVED);
  edits.forget();
  edits.undo();
  assert.deepEqual(seen() ?? [], []);
});

test("a box ends the range in which the target was hidden", () => {
  const edits = new Edits();
  edits.lock(1, BOX);
  edits.setHidden(edits.chosen, [[5, 9], [20, 30]]);
  edits.lock(22, BOX);
  assert.deepEqual(edits.chosen.hidden, [[5, 9], [20, 21]]);
  edits.undo();
  assert.deepEqual(edits.chosen.hidden, [[5, 9], [20, 30]]);
});

// Describes what gives a target's box in a frame: the line, or the tracker's last lock.
const sourceOf = (target, number) => JSON.stringify(lineIn(target, number) ?? target.locks.findLast((lock) => lock.number <= number)?.box);

test("whatever is changed: frames that may have another box are no longer checked, all others are, and all again if it is undone", () => {
  for (let seed = 1; seed <= 300; seed++) {
    const [edits, numbers] = [new Edits(), random(seed)];
    const box = () => ({ x: numbers.below(99), y: numbers.below(99), width: 1 + numbers.below(50), height: 1 + numbers.below(50) });
    edits.lock(10, box());
    for (let step = 0; step < 30 && edits.chosen !== null; step++) {
      const before = edits.chosen;
      edits.check(before, 1, 20);
      const [number, act] = [1 + numbers.below(20), numbers.below(7)];
      [
        () => edits.lock(number, box()), () => number > before.locks[0].number && edits.lose(before, number), () => edits.unlock(before, number), () => edits.setByHand(before, numbers.of(before.locks).number, true),
        () => edits.undo(), () => edits.redo(), () => edits.setHidden(before, [[number, number]]),
      ][act]();
      const isSeen = act === 4 || act === 5; // undone or done again
      const after = edits.targets.find(({ id }) => id === before.id);
      for (let frame = 1; after !== undefined && !isSeen && frame <= 20; frame++) {
        if (sourceOf(before, frame) !== sourceOf(after, frame)) {
          assert.equal(rangeOf(edits.checked.get(before.id), frame), undefined, `seed ${seed}, step ${step}, frame ${frame}`);
        }
      }
      const isChanged = after !== undefined && after.locks !== before.locks;
      assert.ok((isChanged && !isSeen) || lengthOf(edits.checked.get(before.id)) === 20);
    }
  }
});

test("ranges of frames are added and taken away", () => {
  for (let seed = 1; seed <= 100; seed++) {
    const numbers = random(seed);
    let [ranges, model] = [[], new Set()];
    for (let step = 0; step < 40; step++) {
      const from = 1 + numbers.below(30);
      const to = from + numbers.below(6);
      const isAdded = numbers.below(2) === 1;
      ranges = (isAdded ? plus : minus)(ranges, from, to);
      for (let number = from; number <= to; number++) {
        isAdded ? model.add(number) : model.delete(number);
      }
      const has = Array.from({ length: 40 }, (_, number) => rangeOf(ranges, number) !== undefined);
      assert.deepEqual(has, has.map((_, number) => model.has(number)));
      assert.ok(ranges.every(([begin, end], at) => begin <= end && (at === 0 || ranges[at - 1][1] + 1 < begin)), JSON.stringify(ranges));
      assert.equal(lengthOf(ranges), model.size);
    }
  }
});

test("a box drawn after a redo, a rename and an undo is of a target of its own", () => {
  const edits = new Edits();
  edits.lock(1, BOX);
  edits.undo();
  assert.equal(edits.chosen, null, "the next box is a new target, as before");
  edits.redo();
  assert.equal(edits.rename(edits.chosen, "ship"), null);
  edits.choose(null);
  edits.lock(1, MOVED);
  assert.deepEqual(edits.targets.map(({ id, name }) => [id, name]), [[1, "ship"], [2, ""]]);
  edits.undo();
  assert.equal(edits.chosen, null);
  edits.lock(1, MOVED);
  assert.deepEqual(edits.targets.map(({ id }) => id), [1, 3], "the id of a target that was undone is not given again");
});

const shape = (targets) => targets.map((target) => [target.id, nameOf(target), target.locks]);

/** Does `count` random changes to `edits`, and to a plain model of targets; compares them after each. */
function change(edits, numbers, count) {
  const owners = new Map(); // a description of the target that each id was given to
  let model = { past: [], now: [], future: [] };
  const to = (now) => (model = { past: [...model.past, model.now], now, future: [] });
  const box = () => ({ x: numbers.below(99), y: numbers.below(99), width: 1 + numbers.below(50), height: 1 + numbers.below(50) });
  const placed = (locks, number, box) => [...locks.filter((lock) => lock.number !== number), { number, box }].sort((one, other) => one.number - other.number);
  // Takes the ids and names of new targets from `edits`: they must be new, the rest must be as in the model.
  const born = (made) => {
    const fresh = edits.targets.slice(-made.length);
    fresh.forEach(({ id }, at) => {
      assert.ok(!owners.has(id), `id ${id} is given twice`);
      owners.set(id, made[at]);
    });
    to([...model.now, ...fresh.map((target, at) => ({ id: target.id, name: nameOf(target), locks: made[at] }))]);
  };
  const acts = {
    draw() {
      const [number, drawn] = [1 + numbers.below(20), box()];
      edits.choose(null);
      edits.lock(number, drawn);
      born([[{ number, box: drawn }]]);
    },
    correct() {
      const [number, drawn, target] = [1 + numbers.below(20), box(), numbers.of(edits.targets)];
      edits.lock(number, drawn, target);
      to(model.now.map((one) => (one.id === target.id ? { ...one, locks: placed(one.locks, number, drawn) } : one)));
    },
    rename() {
      const [target, name] = [numbers.of(edits.targets), numbers.of(["ship", "car", "target2", "target9"])];
      if (edits.rename(target, name) === null) {
        to(model.now.map((one) => (one.id === target.id ? { ...one, name } : one)));
      }
    },
    remove() {
      const target = numbers.of(edits.targets);
      edits.remove(target);
      to(model.now.filter(({ id }) => id !== target.id));
    },
    add() {
      const read = ["ship", "a b", "a_b", "target3"].map((name) => ({ name, locks: [{ number: 1 + numbers.below(20), box: box() }] }));
      edits.add(read);
      born(read.map(({ locks }) => locks));
    },
    undo() {
      edits.undo();
      if (model.past.length > 0) {
        model = { past: model.past.slice(0, -1), now: model.past.at(-1), future: [...model.future, model.now] };
      }
    },
    redo() {
      edits.redo();
      if (model.future.length > 0) {
        model = { past: [...model.past, model.now], now: model.future.at(-1), future: model.future.slice(0, -1) };
      }
    },
  };
  const check = (what) => {
    assert.deepEqual(shape(edits.targets), model.now.map(({ id, name, locks }) => [id, name, locks]), what);
    const names = edits.targets.map(nameOf);
    assert.equal(new Set(names).size, names.length, `${what}: ${names}`);
    assert.deepEqual([edits.canUndo, edits.canRedo], [model.past.length > 0, model.future.length > 0], what);
  };
  const needed = ["correct", "rename", "remove"];
  for (let step = 0; step < count; step++) {
    const act = numbers.of(["draw", "correct", "rename", "remove", "add", "undo", "undo", "redo", "redo"]);
    if (!needed.includes(act) || edits.targets.length > 0) {
      acts[act]();
      check(`step ${step}, ${act}`);
    }
  }
}

test("whatever is drawn, undone, done again, renamed, read or removed: ids are given once, and each target keeps its boxes and name", () => {
  for (let seed = 1; seed <= 200; seed++) {
    const edits = new Edits();
    change(edits, random(seed), 60);
    const last = shape(edits.targets);
    let steps = 0;
    for (; edits.canUndo; steps++) {
      edits.undo();
    }
    assert.deepEqual(edits.targets, [], `seed ${seed}`);
    for (; steps > 0; steps--) {
      edits.redo();
    }
    assert.deepEqual(shape(edits.targets), last, `seed ${seed}`);
  }
});

test("a box that may be of something else is asked about, one that is pulled or over a lost target is not", () => {
  const of = (box, more = {}) => doubtOf(box, { name: "car", former: { x: 100, y: 100, width: 40, height: 20 }, isPulled: false, isLost: false, ...more });
  const at = (x, y, width = 40, height = 20) => ({ x, y, width, height });
  assert.deepEqual([at(100, 100), at(110, 102), at(95, 95, 60, 30)].map((box) => of(box)), [null, null, null]);
  const apart = "This box hardly overlaps that of car.";
  assert.deepEqual([at(300, 10), at(141, 100), at(130, 112), at(300, 10, 4, 4)].map((box) => of(box)), [apart, apart, apart, apart]);
  assert.equal(of(at(110, 105, 15, 10)), "This box has 15x10 pixels, and that of car 40x20.");
  assert.equal(of(at(50, 50, 200, 100)), "This box has 200x100 pixels, and that of car 40x20.");
  assert.deepEqual([of(at(300, 10), { isPulled: true }), of(at(300, 10, 90, 90), { isLost: true })], [null, null]);
  assert.match(of(at(110, 105, 15, 10), { isPulled: true }), /15x10 pixels/);
  assert.match(of(at(300, 10, 15, 10), { isLost: true }), /15x10 pixels/);
  assert.equal(of(at(100, 100), { former: null }), "car is gone in this frame.");
  assert.deepEqual([slipOf(at(1, 1, 8, 8)), slipOf(at(1, 1, 40, 7))], [null, "This box has 40x7 pixels: a target of less than 8x8 is hard to follow."]);
});

test("a sentence is shown until its cause ends, and that of the end is never hidden", () => {
  const messages = new Messages();
  messages.say("no such frame", "act");
  messages.say("frame 9 is damaged", "tracking");
  assert.equal(messages.text, "frame 9 is damaged");
  messages.say("", "tracking");
  assert.equal(messages.text, "no such frame");
  messages.say("host-sim has ended.", ENDED);
  assert.equal(messages.text, "host-sim has ended. no such frame");
  messages.say("", "act");
  assert.equal(messages.text, "host-sim has ended.");
});

test("names are what a shell takes, and none is given twice", () => {
  assert.deepEqual(["red car's", "--x", " Bär ", "./"].map(plainName), ["red_car_s", "x", "Bär", "_"]);
  const edits = new Edits();
  edits.lock(1, BOX);
  assert.equal(edits.rename(edits.chosen, "target2"), null);
  edits.choose(null);
  edits.lock(1, BOX);
  assert.equal(nameOf(edits.chosen), "target3", "target2 is taken");
  assert.match(edits.rename(edits.chosen, "target2"), /Another target is called target2/);
  assert.deepEqual(edits.targets.map(nameOf), ["target2", "target3"]);
});

test("a change that is refused is taken back, unless there is a later one", () => {
  const edits = new Edits();
  edits.lock(9, BOX);
  edits.lock(1, BOX);
  const refused = edits.targets;
  edits.lock(2, BOX);
  edits.takeBack(refused);
  assert.deepEqual(numbers(edits), [[1, 2, 9]]);
  edits.takeBack(edits.targets);
  assert.deepEqual([numbers(edits), edits.canRedo], [[[9]], false], "both were refused");
});

test("an undo and a redo that are refused change nothing", () => {
  const edits = new Edits();
  const now = () => [edits.targets.map(nameOf), numbers(edits), edits.chosen?.id, edits.canUndo, edits.canRedo];
  const refused = (change) => {
    const before = now();
    change();
    assert.notDeepEqual(now(), before);
    edits.takeBack(edits.targets);
    assert.deepEqual(now(), before);
  };
  edits.lock(5, BOX);
  edits.choose(null);
  edits.lock(6, BOX);
  refused(() => edits.add([{ name: "car", locks: [{ number: 1, box: BOX }] }]));
  refused(() => edits.lock(9, BOX));
  edits.remove(edits.targets[0]);
  refused(() => edits.undo());
  refused(() => edits.rename(edits.chosen, "car"));
  edits.undo();
  refused(() => edits.redo());
  refused(() => edits.undo());
  edits.redo();
  assert.deepEqual(now(), [["target2"], [[6]], 2, true, false]);
});

test("targets of another page are taken as they are", () => {
  const edits = new Edits();
  edits.load([{ id: 4, name: "car", locks: [{ number: 1, box: BOX }] }, { id: 7, name: "target7", locks: [{ number: 2, box: BOX }] }]);
  assert.deepEqual([edits.canUndo, edits.chosen.id, edits.targets.map(({ name }) => name)], [false, 4, ["car", ""]]);
  edits.choose(null);
  edits.load([{ id: 4, name: "car", locks: [{ number: 1, box: BOX }] }, { id: 9, name: "man", locks: [{ number: 1, box: BOX }] }]);
  assert.equal(edits.chosen, null, "who adds a target goes on with that");
  edits.lock(1, BOX);
  assert.equal(edits.chosen.id, 10);
  edits.load([{ id: 4, name: "car", locks: [{ number: 1, box: BOX }] }], 20);
  assert.equal(edits.chosen.id, 4);
  edits.choose(null);
  edits.lock(1, BOX);
  assert.equal(edits.chosen.id, 21, "targets that were removed before the session had the ids up to 20");
  edits.load([{ id: 1, name: "target2", locks: [] }, { id: 2, name: "target", locks: [] }, { id: 3, name: "target1", locks: [] }]);
  assert.deepEqual(edits.targets.map(nameOf), ["target1", "target2", "target3"], "no name stands twice");
});

const row = (id, number, state, confidence = 0.5) => [id, number, state, 1.25, 2, 30, 40, confidence, null, 0.25, 1, 12];

test("answers are found by frame, replaced, cleared and forgotten", () => {
  const answers = new Answers();
  answers.take([row(1, 2000, "lost"), row(1, 5, "tracking", null), row(2, 9, "leaving")]);
  assert.deepEqual([answers.state(1, 5), answers.state(1, 2000), answers.state(1, 6), answers.state(3, 5)], ["tracking", "lost", undefined, undefined]);
  assert.deepEqual(answers.at(1, 5), {
    number: 5, state: "tracking", box: { x: 1.25, y: 2, width: 30, height: 40 }, ratio: 65535 / 4, scale: 65536,
  });
  const before = answers.version(1);
  answers.take([row(1, 5, "uncertain")]);
  assert.equal(answers.state(1, 5), "uncertain");
  assert.ok(answers.version(1) > before);
  answers.clear([[1, 6, 3000], [2, 1, 8], [9, 1, 2]]);
  assert.deepEqual([answers.at(1, 2000), answers.state(1, 5), answers.state(2, 9)], [undefined, "uncertain", "leaving"]);
  answers.take([row(1, 2000, "lost")]);
  answers.forget(1990);
  assert.deepEqual([[...answers.states(1)], answers.state(1, 5)], [[{ number: 2000, state: "lost" }], undefined]);
  answers.take([row(2, 2001, "tracking")]);
  answers.keep([2]);
  assert.deepEqual([[...answers.states(1)], [...answers.states(2)].length], [[], 1]);
});

test("an hour of answers is kept, and its part is given to the curves", () => {
  const answers = new Answers();
  const all = 60 * 60 * 60;
  answers.take(Array.from({ length: all }, (_, at) => row(1, at + 1, at === 99 ? "lost" : "tracking")));
  assert.equal([...answers.states(1)].length, all);
  const { last } = answers.around(1, 99, 102);
  assert.deepEqual([last("number"), last("state"), last("ratio")[0]], [[99, 100, 101, 102], [0, 3, 0, 0], 65535 / 4]);
  assert.ok(last("runnerUpRatio").every(Number.isNaN));
  answers.take([[...row(1, 5, "tracking"), 0.5, 0.25]]);
  assert.deepEqual([answers.at(1, 4).runnerUpRatio, answers.at(1, 5).runnerUpRatio], [undefined, 65535 / 2]);
  assert.deepEqual([answers.at(1, 4).identity, answers.at(1, 5).identity], [undefined, 65535 / 4]);
  assert.deepEqual(answers.around(2, 1, 3).last("number"), []);
});

test("a box is held by its edges, its corners and its inside, and a small one has an inside, too", () => {
  const at = (x, y, box = { x: 10, y: 10, width: 40, height: 40 }) => gripOf(box, { x, y }, 5);
  assert.deepEqual([at(7, 30), at(52, 48), at(30, 30), at(30, 12)], [[-1, 0], [1, 1], [0, 0], [0, -1]]);
  assert.deepEqual([at(4, 30), at(14, 14, { x: 10, y: 10, width: 8, height: 8 })], [null, [0, 0]]);
});

test("pictures come two at a time, in the order in which they are wanted, and no more are kept than there is room for", async () => {
  const [asked, answer, closed, missed] = [[], new Map(), [], []];
  const load = (number) => {
    asked.push(number);
    return new Promise((resolve, reject) => answer.set(number, { resolve, reject }));
  };
  const image = (number) => ({ width: 4096, height: 2048, close: () => closed.push(number) }); // 32 MB
  const images = new Images(load, () => {}, (number, error) => missed.push([number, error.message]));
  const come = async (number) => {
    answer.get(number).resolve(image(number));
    await new Promise(setImmediate);
  };
  images.want([1, 2, 3, 4]);
  assert.deepEqual(asked, [1, 2]);
  images.want([9, 4, 1]);
  await come(2);
  assert.deepEqual([asked, images.get(2).width], [[1, 2, 9], 4096]);
  await come(1);
  answer.get(9).reject(new Error("gone"));
  await new Promise(setImmediate);
  assert.deepEqual([asked, missed], [[1, 2, 9, 4], [[9, "gone"]]]);
  await come(4);
  assert.deepEqual(closed, []);
  images.want([5, 1]);
  await come(5);
  assert.deepEqual([closed, images.get(2), images.get(1).width], [[2], undefined, 4096], "what is wanted stays");
});

test("a page asks for answers where there are many, and tells others' targets from its own", async () => {
  const asked = [];
  const told = [{ id: 1, name: "a", locks: [] }];
  const news = [
    { position: 9, rows: [], changed: [[1, 1, 100], [2, 1, 50]], targets: told, revision: 3 },
    { position: 9, rows: [], changed: [] },
    { position: 12, rows: [[1, 7]], changed: [[1, 7, 7]], targets: told, revision: 12 },
  ];
  globalThis.fetch = async (address, { body } = {}) => {
    asked.push(body === undefined ? address : `${address} ${body}`);
    const [, target, from, to] = /answers\?target=(\d+)&from=(\d+)&to=(\d+)/.exec(address)?.map(Number) ?? [];
    if (news.length === 0 && address.startsWith("news")) {
      await new Promise(() => {}); // no more news
    }
    const answers = () => ({ rows: [[target, from]], to: Math.min(to, from + 19) });
    return Response.json(target ? answers() : address === "targets" ? { revision: 3 } : news.shift());
  };
  const connection = new Connection();
  const heard = [];
  const sent = connection.targets([]);
  await new Promise((resolve) => {
    connection.listen(({ rows, targets }) => heard.push([rows, targets?.length]) === 3 && resolve(), () => {}, () => 30);
  });
  await sent;
  assert.deepEqual(heard, [[[[1, 30]], undefined], [[[2, 30]], undefined], [[[1, 7], [1, 1]], 1]]);
  assert.deepEqual(asked.slice(0, 4), ["news?since=0", "targets []", "answers?target=1&from=30&to=100", "news?since=9&wait=0"]);
});
