// Box colors of targets, by id; they repeat after the last. host-sim's build reads them from this file for its videos.

const TARGETS = ["#ff6ec7", "#4aa8ff", "#ffb02e", "#3ddc84", "#c58bff", "#ff5a4f", "#35d6e6", "#d6e35a"];

export const colorOf = (id) => TARGETS[(id - 1) % TARGETS.length];
