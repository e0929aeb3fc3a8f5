//! All numbers of the method, as its description has them.

#[derive(Clone, Debug)]
pub struct Numbers {
    /// The parts that can be left out: the scale, and the learned network that corrects the box and can make the decision worse.
    pub size: bool,
    pub refiner: bool,
    /// Grid: the most pixels of the template; the least step, in pixels of the frame.
    pub pixels: i64,
    pub least_step: f64,
    /// Sampling: how many pixels of a block are read on each axis.
    pub read_per_side: i64,
    /// Pixels of the grid on a side of a cell.
    pub cell: i64,
    /// The filter covers .0 / .1 of the box on each axis.
    pub cover: (f64, f64),
    /// The filter's size in cells: least and most on a side, and most in all.
    pub least_side: i64,
    pub most_side: i64,
    pub most_cells: i64,
    /// Features: the floor that is added to a norm, in gray levels; the gain of a gradient over its norm.
    pub norm_floor: f64,
    pub norm_gain: f64,
    /// Search radius, which is also the radius of learning, in cells.
    pub reach: i64,
    /// The label's standard deviation: .0 / .1 of the root of the target's area.
    pub label_width: (f64, f64),
    /// The weight of the squared filter weights in the error.
    pub regularisation: f64,
    /// Bounds: of a coded number, of a coded error, and of an error.
    pub most_coded: f64,
    pub most_gathered: f64,
    pub most_error: f64,
    /// The fraction of the best length that the step of an update has.
    pub step: f64,
    /// Steps of a lock. An update takes one.
    pub first_steps: usize,
    /// The most that a step of a lock takes of the direction before.
    pub most_conjugate: f64,
    /// Part that a response loses at the edge of the search, in units of 1/256.
    pub distance_penalty: f64,
    /// Motion: the fraction of the velocity that is added to the last place, and the weight of the last move in the velocity.
    pub velocity_fraction: f64,
    pub velocity_rate: f64,
    /// Scale search: the factor between scales, what the other scales' responses count in units of 1/256, and their reach in cells.
    pub scale_step: f64,
    pub scale_gain: f64,
    pub scale_reach: i64,
    /// The largest scale. The least is 1 over it.
    pub most_scale: f64,
    /// The weight of a new patch in the early template.
    pub early_rate: f64,
    /// Similarity: p = exp(-d / similarity_scale).
    pub similarity_scale: f64,
    /// The largest factor between the gain of the template's contrast and the expected gain, and the bounds of the expected gain.
    pub most_change: f64,
    pub gain_bounds: (f64, f64),
    /// The least contrast of a search window, in gray levels.
    pub least_window: f64,
    /// The rate at which the light follows the light of a frame.
    pub light_rate: f64,
    pub alpha_bounds: (f64, f64),
    /// A patch can show the target if its contrast is at least this fraction of the expected one and at least this many gray levels, and at most
    /// this fraction of its pixels is cut off at black or white.
    pub least_contrast: f64,
    pub least_deviation: f64,
    pub most_cut_off: f64,
    /// Verification: tiles on a side, and which of their sorted ratios counts (1 is the least).
    pub tiles_across: i64,
    pub counted_ratio: usize,
    /// Alignment: the farthest one on each axis, and the distance of the first nine, in pixels of the grid.
    pub margin: i64,
    pub coarse_step: i64,
    /// The agreement from which place and size are refined.
    pub refined_from: f64,
    /// The most that a Gauss-Newton step moves, in pixels of the grid, and grows, in units of 1/65536.
    pub most_move: f64,
    pub most_growth: f64,
    /// Each diagonal element of the normal equations grows by 1 / damping of itself.
    pub damping: f64,
    /// The elements are divided by a power of two until they are below this.
    pub most_sum: f64,
    /// Confidence: the weight of a frame in the mean evidence, in units of 1/256; how much the mean may be above the evidence; the bounds
    /// of the decisions.
    pub confidence_rate: f64,
    pub most_lead: f64,
    pub lost_below: f64,
    pub uncertain_below: f64,
    /// Opinion: the most trust; the weight of a frame's trust; that weight while a bad opinion rises; the bounds of the two decisions.
    pub most_trust: f64,
    pub opinion_rate: f64,
    pub opinion_rising_rate: f64,
    pub opinion_lost_below: f64,
    pub opinion_uncertain_below: f64,
    /// A target is given up after so many frames in a row below `opinion_uncertain_below`, and begins with `opinion_found` when it is found.
    pub opinion_patience: i64,
    pub opinion_found: f64,
    /// The evidence from which a frame is learned.
    pub learned_from: f64,
    /// Redetection: the windows in a frame, the least evidence, and how much more it must be than at the followed place.
    pub sweep: i64,
    pub found_from: f64,
    pub better_by: f64,
}

impl Numbers {
    /// The preset `refined`: all parts.
    pub fn refined() -> Self {
        Self {
            size: true,
            refiner: true,
            pixels: 1600,
            least_step: 0.5,
            read_per_side: 2,
            cell: 4,
            cover: (7.0, 5.0),
            least_side: 4,
            most_side: 32,
            most_cells: 200,
            norm_floor: 32.0,
            norm_gain: 635.0,
            reach: 8,
            label_width: (1.0, 10.0),
            regularisation: 5056.0,
            most_coded: 8191.0,
            most_gathered: 16_383.0,
            most_error: 65_535.0,
            step: 5.0 / 8.0,
            first_steps: 7,
            most_conjugate: 0.75,
            distance_penalty: 77.0,
            velocity_fraction: 0.5,
            velocity_rate: 0.5,
            scale_step: 66_847.0 / 65_536.0,
            scale_gain: 252.0,
            scale_reach: 1,
            most_scale: 5.0,
            early_rate: 1.0 / 1024.0,
            similarity_scale: 255.0,
            most_change: 2.0,
            gain_bounds: (1.0 / 256.0, 16.0),
            least_window: 0.25,
            light_rate: 0.125,
            alpha_bounds: (2.0, 100.0),
            least_contrast: 0.25,
            least_deviation: 1.0,
            most_cut_off: 0.5,
            tiles_across: 4,
            counted_ratio: 4,
            margin: 3,
            coarse_step: 2,
            refined_from: 55_000.0,
            most_move: 1.0,
            most_growth: 1310.0,
            damping: 64.0,
            most_sum: 4096.0,
            confidence_rate: 77.0,
            most_lead: 29_000.0,
            lost_below: 19_200.0,
            uncertain_below: 32_500.0,
            most_trust: 3.0,
            opinion_rate: 0.125,
            opinion_rising_rate: 0.0625,
            opinion_lost_below: 0.8,
            opinion_uncertain_below: 1.1875,
            opinion_patience: 30,
            opinion_found: 0.8125,
            learned_from: 37_500.0,
            sweep: 4,
            found_from: 52_000.0,
            better_by: 16_000.0,
        }
    }
}
