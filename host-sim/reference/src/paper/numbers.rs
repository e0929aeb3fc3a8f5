//! Parameters of the paper tracker, as in the paper and its authors' program.

use super::UNITS;

#[derive(Clone, Debug)]
pub struct Numbers {
    /// Similarity of a pixel: p = exp(-d / scale), with the difference d in gray levels.
    pub scale: f64,
    /// The paper's factor k as a fraction `.0 / .1`: alpha = k * (largest change of a template pixel).
    pub k: (f64, f64),
    /// Threshold alpha before the first update, in gray levels.
    pub first_alpha: f64,
    /// Width of the zero padding on each side of the frame, in pixels.
    pub padding: i64,
    /// Search radius in x and y, in pixels.
    pub window: (i64, i64),
    /// Growth of the search radius for each frame in which the target is lost, in pixels.
    pub growth: i64,
    /// Largest search radius in x and y, in pixels; with `None` only the padded frame bounds it.
    pub window_limit: Option<(i64, i64)>,
    /// Exclusion radius around the peak: the runner-up is more than this many pixels away in x or in y.
    pub neighbourhood: i64,
    /// Minimum distances in pixels from the box to the frame's left, top, right and bottom edge for a template update.
    pub zone: (i64, i64, i64, i64),
    /// Lower bound of alpha after an update, in gray levels.
    pub least_alpha: f64,
    pub gate: GateNumbers,
    /// True if the runner-up is searched for in every frame, even if no decision depends on it.
    pub runner_up_always: bool,
}

/// Thresholds for accepting a peak. A ratio of peak to runner-up is a fraction `.0 / .1`, because products of whole
/// numbers are exact in f64, but 1.02 is not.
#[derive(Clone, Debug)]
pub struct GateNumbers {
    /// Ratio of peak to runner-up, a fraction `.0 / .1`, required while the target is tracked inside the frame.
    pub tracking: (f64, f64),
    /// Ratio of peak to runner-up, a fraction `.0 / .1`, required if the box at the peak crosses the frame's edge.
    pub border: (f64, f64),
    /// Ratio of peak to runner-up, a fraction `.0 / .1`, required inside the frame after the box at a peak crossed the
    /// frame's edge, until the target has been lost and found again.
    pub been_at_border: (f64, f64),
    /// Ratio of peak to runner-up, a fraction `.0 / .1`, required for finding a lost target again.
    pub lost: (f64, f64),
    /// Lead of the peak's score over the runner-up's that suffices at any ratio; the unit is one pixel of similarity 1.
    pub lead: f64,
    /// Minimum mean similarity of the patch's pixels, in 1/65535; 0 also disables `least_contrast` and `most_cut_off`.
    pub least_ratio: f64,
    /// `least_contrast`: minimum contrast of a patch, as a fraction of the template's contrast. `most_cut_off`: maximum
    /// excess of its clipped pixels (0 or 255) over the template's, as a fraction of all pixels.
    pub least_contrast: f64,
    pub most_cut_off: f64,
}

impl Numbers {
    pub fn paper() -> Self {
        Self {
            scale: 255.0,
            k: (1.0, 4.0),
            first_alpha: 0.05 * 255.0,
            padding: 20,
            window: (60, 50),
            growth: 1,
            window_limit: None,
            neighbourhood: 8,
            zone: (20, 20, 2, 2), // x + w < W - 1 is x + w <= W - 2
            least_alpha: 0.0,
            gate: GateNumbers {
                tracking: (1.0, 1.0),
                border: (102.0, 100.0),
                been_at_border: (120.0, 100.0),
                lost: (125.0, 100.0),
                lead: 100.0,
                least_ratio: 0.0,
                least_contrast: 0.25,
                most_cut_off: 0.5,
            },
            runner_up_always: false,
        }
    }

    /// Same settings as `paper::Config::camera()` of smr-core.
    pub fn camera() -> Self {
        let mut numbers = Self::paper();
        numbers.window_limit = Some((80, 70));
        numbers.zone = (0, 0, 0, 0);
        numbers.gate.tracking = (0.0, 1.0);
        numbers.gate.least_ratio = (UNITS / 20.0).floor();
        numbers.least_alpha = 10.0;
        numbers
    }
    /// Sets the parameter that `--set` names, to the numbers that follow the name. False: there is no such parameter.
    pub fn set(&mut self, name: &str, values: &[u16]) -> bool {
        let number = |place: usize| f64::from(values[place]);
        let fraction = || (number(0), number(1));
        let pixels = |place: usize| i64::from(values[place]);
        match name {
            "scale" => self.scale = number(0),
            "k" => self.k = fraction(),
            "gate_tracking" => self.gate.tracking = fraction(),
            "gate_leaving" => self.gate.border = fraction(),
            "gate_returning" => self.gate.been_at_border = fraction(),
            "gate_lost" => self.gate.lost = fraction(),
            "gate_lead" => self.gate.lead = number(0),
            "least_ratio" => self.gate.least_ratio = number(0),
            "first_threshold" => self.first_alpha = number(0),
            "least_threshold" => self.least_alpha = number(0),
            "padding" => self.padding = pixels(0),
            "window" => self.window = (pixels(0), pixels(1)),
            "growth" => self.growth = pixels(0),
            "window_limit" => self.window_limit = Some((pixels(0), pixels(1))),
            "neighbourhood" => self.neighbourhood = pixels(0),
            "runner_up_always" => self.runner_up_always = values[0] != 0,
            "update_zone" => self.zone = (pixels(0), pixels(1), pixels(2), pixels(3)),
            _ => return false,
        }
        true
    }
}
