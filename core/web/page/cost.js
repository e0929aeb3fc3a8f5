// Estimates the instructions of a tracker's update on a microcontroller: the update's work (comparisons or products)
// times the measured instructions per unit of work.
//
// Measured on the recording `synthetic` with `smr-qemu ELF synthetic --machine mps2-an386` (Cortex-M4) and
// `--machine mps3-an547` (Cortex-M55), with and without `--method robust`. `paper` is the median frame, in which
// bounds exclude most offsets; `paperWithRunnerUp` is the maximum, in which all scores are computed. QEMU counts
// instructions, not cycles.

const INSTRUCTIONS_PER_UNIT = {
  robust: { m4: 4_713_680 / 4_325_579, m55: 1_431_719 / 4_325_579 },
  paper: { m4: 180_880 / 57_019, m55: 90_906 / 57_019 },
  paperWithRunnerUp: { m4: 5_636_440 / 931_000, m55: 2_944_969 / 931_000 },
};

export function instructions(method, { work = NaN, runnerUpRatio = null }) {
  const { m4, m55 } = INSTRUCTIONS_PER_UNIT[method === "paper" && runnerUpRatio !== null ? "paperWithRunnerUp" : method];
  return { m4: m4 * work, m55: m55 * work };
}

/** Formats a count of instructions with two significant digits, because the estimate is no better. */
export function about(count) {
  if (Number.isNaN(count)) {
    return "–";
  }
  return count < 1e6 ? `about ${Number((count / 1e3).toPrecision(2))} k` : `about ${Number((count / 1e6).toPrecision(2))} M`;
}
