// The two trackers by their names in host-sim, and their options.

export const METHODS = ["robust", "paper"];
export const TITLES = { robust: "Robust tracker", paper: "Paper tracker (SMR, 2013)" };
export const SHORT = { robust: "Robust", paper: "Paper" };

/** Default settings. */
export const SETTINGS = {
  robust: { reach: 8, size: true, sweep: 4, refiner: true },
  paper: { config: "camera" },
};

/** Creates a tracker with options of `host-sim track`: { set: ["reach=6", "size=off", ...] }, or for paper { config }. */
export function trackerOf(library, { method, options: { set = [], config = "paper" } }) {
  if (method === "paper") {
    return library.paper({ preset: config });
  }
  const given = set.map((one) => one.split("=")).map(([name, value]) => [name, ["on", "off"].includes(value) ? value === "on" : Number(value)]);
  return library.robust({ ...SETTINGS.robust, ...Object.fromEntries(given) });
}
