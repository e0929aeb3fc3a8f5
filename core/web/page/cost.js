// Estimates the instructions of an update on a microcontroller: its counted work times the measured instructions of a
// unit of work.
//
// Measured on the recording `synthetic` with `smr-qemu ELF synthetic --machine mps2-an386` (Cortex-M4) and
// `--machine mps3-an547` (Cortex-M55), with `--method robust` and without: instructions of an update over its work. Of
// SMR the median is of a frame in which bounds exclude most offsets; the maximum is of one in which the runner-up is
// searched, too, which takes all scores. QEMU counts instructions, not cycles.

const INSTRUCTIONS_PER_UNIT = {
  robust: { m4: 4_713_680 / 4_325_579, m55: 1_431_719 / 4_325_579 },
  smr: { m4: 180_880 / 57_019, m55: 90_906 / 57_019 },
  smrWithRunnerUp: { m4: 5_636_440 / 931_000, m55: 2_944_969 / 931_000 },
};

/** The instructions of an answer of `method`: { m4, m55 }. */
export function instructions(method, { work = NaN, runnerUpRatio = null }) {
  const { m4, m55 } = INSTRUCTIONS_PER_UNIT[method === "smr" && runnerUpRatio !== null ? "smrWithRunnerUp" : method];
  return { m4: m4 * work, m55: m55 * work };
}

/** A number of instructions in words. Two digits, because no more are known. */
export function about(count) {
  if (Number.isNaN(count)) {
    return "–";
  }
  return count < 1e6 ? `about ${Number((count / 1e3).toPrecision(2))} k` : `about ${Number((count / 1e6).toPrecision(2))} M`;
}
