// The built-in recording `street` as a source of frames, which the worker renders.

export class BuiltIn {
  name = "street";
  key = "street";
  words = "street";
  live = false;
  width = 320;
  height = 240;
  last = 300;
  targets = [{ id: 1, name: "", hidden: [], locks: [{ number: 1, box: { x: 268, y: 101, width: 39, height: 14 } }] }];
  #follower;

  constructor(follower) {
    this.#follower = follower;
  }

  async open() {}

  news() {
    return { frames: this.last };
  }

  async frame() {
    return { isBuiltIn: true };
  }

  async image(number) {
    return (await this.#follower.ask("draw", { number })).image;
  }

  close() {}
}
