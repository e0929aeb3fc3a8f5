// The two trackers that follow each target, by their names in host-sim.

export const METHODS = ["robust", "smr"];
export const TITLES = { robust: "Robust tracker", smr: "Paper's tracker (SMR, 2013)" };
/** Titles where there is little room. */
export const SHORT = { robust: "Robust", smr: "Paper" };

/** The settings at the start. The options are those of host-sim. */
export const SETTINGS = {
  on: { robust: true, smr: true },
  robust: { reach: 8, size: true, sweep: true, refiner: true },
  smr: { config: "camera" },
};

/** A new tracker of `method` with these settings. */
export function trackerOf(library, method, settings) {
  const { robust, smr } = settings;
  return method === "robust" ? library.robust(robust) : library.paper({ preset: smr.config });
}
