// Layout of C structs on 32 bits: the fields in order, each at the next multiple of its alignment. A type has a size
// and an alignment, and reads and writes values at an address of a DataView. Writing validates the value; `name` is its
// name in an error message.

import { object, whole } from "./errors.js";

const integer = (kind, size, least, most) => ({
  size,
  alignment: size,
  read: (view, at) => view[`get${kind}`](at, true),
  write: (view, at, value, name) => view[`set${kind}`](at, whole(value, least, most, name), true),
});

export const u8 = integer("Uint8", 1, 0, 255);
export const u16 = integer("Uint16", 2, 0, 65535);
export const u32 = integer("Uint32", 4, 0, 2 ** 32 - 1);
// Excludes -2^31, whose negative is not an i32.
export const i32 = integer("Int32", 4, 1 - 2 ** 31, 2 ** 31 - 1);

export const flag = {
  ...u8,
  read: (view, at) => view.getUint8(at) !== 0,
  write: (view, at, value, name) => view.setUint8(at, whole(typeof value === "boolean" ? Number(value) : value, 0, 1, name)),
};

export const array = (type, count) => ({
  ...type,
  size: count * type.size,
  read: (view, at) => Array.from({ length: count }, (_, i) => type.read(view, at + i * type.size)),
  write(view, at, values, name) {
    if (!Array.isArray(values) || values.length !== count) {
      throw new TypeError(`${name} must be an array of ${count} numbers`);
    }
    values.forEach((value, i) => type.write(view, at + i * type.size, value, name));
  },
});

/** A struct with these fields (types by name). `places` has the byte offset of each. */
export function struct(fields) {
  const [places, next] = [{}, (at, alignment) => Math.ceil(at / alignment) * alignment];
  let [size, alignment] = [0, 1];
  for (const [name, type] of Object.entries(fields)) {
    places[name] = next(size, type.alignment);
    size = places[name] + type.size;
    alignment = Math.max(alignment, type.alignment);
  }
  const names = Object.keys(fields);
  return {
    fields,
    places,
    size: next(size, alignment),
    alignment,
    read: (view, at) => Object.fromEntries(names.map((name) => [name, fields[name].read(view, at + places[name])])),
    write(view, at, values, of) {
      object(values, of, `an object with ${names.slice(0, -1).join(", ")} and ${names.at(-1)}`);
      names.forEach((name) => fields[name].write(view, at + places[name], values[name], `${of}'s ${name}`));
    },
  };
}
