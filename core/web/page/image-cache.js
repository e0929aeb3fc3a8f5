// A loader and cache of the images of frames: loads requested ones, a few at a time, and keeps the last ones.

const MAX_UNDER_WAY = 2;
const MAX_BYTES = 96 << 20;

export class Images {
  #load;
  #came;
  #failed;
  #kept = new Map(); // by number, the one that came first at first
  #bytes = 0;
  #wanted = [];
  #underWay = new Set();

  /** `load(number)` fetches a bitmap or an image; then `came(number)` or `failed(number, error)` is called. */
  constructor(load, came, failed) {
    [this.#load, this.#came, this.#failed] = [load, came, failed];
  }

  /** Loads these frames in this order, and cancels earlier requests that have not started. */
  want(numbers) {
    this.#wanted = numbers;
    this.#next();
  }

  get(number) {
    return this.#kept.get(number);
  }

  end() {
    this.#wanted = null;
    this.#kept.forEach((image) => image.close?.());
    this.#kept.clear();
  }

  #next() {
    while (this.#wanted !== null && this.#underWay.size < MAX_UNDER_WAY) {
      const number = this.#wanted.find((one) => !this.#kept.has(one) && !this.#underWay.has(one));
      if (number === undefined) {
        return;
      }
      this.#fetch(number);
    }
  }

  async #fetch(number) {
    this.#underWay.add(number);
    try {
      const image = await this.#load(number);
      if (this.#wanted === null) {
        image.close?.();
        return;
      }
      this.#keep(number, image);
      this.#came(number);
    } catch (error) {
      this.#wanted = this.#wanted?.filter((one) => one !== number) ?? null;
      this.#failed(number, error);
    } finally {
      this.#underWay.delete(number);
      this.#next();
    }
  }

  #keep(number, image) {
    this.#kept.set(number, image);
    this.#bytes += bytesOf(image);
    for (const [other, old] of this.#kept) {
      if (this.#bytes <= MAX_BYTES) {
        return;
      }
      if (other !== number && !this.#wanted.includes(other)) {
        this.#kept.delete(other);
        old.close?.();
        this.#bytes -= bytesOf(old);
      }
    }
  }
}

const bytesOf = ({ width, height }) => 4 * width * height;
