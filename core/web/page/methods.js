// The two trackers by their names in host-sim, and their options.

export const METHODS = ["robust", "smr"];
export const TITLES = { robust: "Robust tracker", smr: "Paper's tracker (SMR, 2013)" };
export const SHORT = { robust: "Robust", smr: "Paper" };

/** Default settings. */
export const SETTINGS = {
  robust: { reach: 8, size: true, sweep: 4, refiner: true },
  smr: { config: "camera" },
};

/** Creates a tracker with options of `host-sim track`: { set: ["reach=6", "size=off", ...] }, or for smr { config }. */
export function trackerOf(library, { method, options: { set = [], config = "paper" } }) {
  if (method === "smr") {
    return library.paper({ preset: config });
  }
  const given = set.map((one) => one.split("=")).map(([name, value]) => [name, ["on", "off"].includes(value) ? value === "on" : Number(value)]);
  return library.robust({ ...SETTINGS.robust, ...Object.fromEntries(given) });
}
