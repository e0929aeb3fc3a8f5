//! The numbers of the method, all of them, each as its description has it.

/// What the tracker consists of.
#[derive(Clone, Copy, Debug)]
pub struct Parts {
    pub velocity: bool,
    pub distance_penalty: bool,
    pub size: bool,
    pub verification: bool,
    /// Needs verification, and so does the sweep.
    pub gated_learning: bool,
    pub sweep: bool,
}

#[derive(Clone, Debug)]
pub struct Numbers {
    pub parts: Parts,
    /// The grid: the template's most pixels, the least step, how many pixels are read on each side of a block, and pixels on a side of a
    /// cell.
    pub pixels: i64,
    pub finest: f64,
    pub read_of_a_side: i64,
    pub cell: i64,
    /// The filter covers .0 / .1 of the box; its least and most cells on a side, and its most cells.
    pub cover: (f64, f64),
    pub least_cells: i64,
    pub most_cells_on_a_side: i64,
    pub most_cells: i64,
    /// Features: what is added to a norm, in gray levels, and that which a gradient is multiplied with over its norm.
    pub norm_floor: f64,
    pub norm_gain: f64,
    /// How far the filter searches and learns, in cells.
    pub reach: i64,
    /// The label's standard deviation over the root of the target's area; entries of its table for each, and where it ends.
    pub bell: (f64, f64),
    pub bell_entries: f64,
    pub bell_end: f64,
    /// What squared weights count; the largest coded number, gathered error, and error.
    pub pull: f64,
    pub most_coded: f64,
    pub most_gathered: f64,
    pub most_error: f64,
    /// The part of the best length that a step has, and one of those from the first frame.
    pub step: f64,
    pub first_step: f64,
    /// Steps of learning from the first frame; all others take one.
    pub first_steps: usize,
    /// By how much less a response counts at the search's edge, in units of 1/256.
    pub distance_penalty: f64,
    /// The part of the velocity that is expected, and that of the last move in it.
    pub expected: f64,
    pub last_move: f64,
    /// From one scale to the next, what the other scales' responses count in units of 1/256, and how far they are searched.
    pub size_step: f64,
    pub size_part: f64,
    pub size_reach: i64,
    /// The largest scale; the least is 1 over it.
    pub most_scale: f64,
    /// The part of each patch that the early template learns.
    pub early_rate: f64,
    /// Agreement: p = exp(-d / scale); contrast of the light may change by the gain; bounds of alpha; parts on a side, and the
    /// ratio that counts from the least.
    pub scale: f64,
    pub most_gain: f64,
    pub alpha_bounds: (f64, f64),
    /// What can show the target at all: its contrast over the early template's is at least this; the part of its pixels that are cut off
    /// at black or white is not more than the most.
    pub least_contrast: f64,
    pub most_cut_off: f64,
    pub parts_across: i64,
    pub ratio_that_counts: usize,
    /// How far the template is compared beyond the filter's place and from one place to the next at first, in pixels of the grid; the
    /// agreement from which on place and size go by its differences; the most that these move, in pixels, and grow, in units of 1/65536.
    pub margin: i64,
    pub far: i64,
    pub certain_from: f64,
    pub most_move: f64,
    pub most_growth: f64,
    /// Sums of squared slopes grow by 1 over `more`, and are divided by a power of two until they are below the most.
    pub more: f64,
    pub most_sum: f64,
    /// Trust: how far the mean moves, in units of 1/256, how much it may be beyond the evidence, and what is believed by the confidence,
    /// two thirds of it.
    pub trust_rate: f64,
    pub beyond: f64,
    pub lost_below: f64,
    pub uncertain_below: f64,
    /// Evidence from which on a look is learned; from which on a lost target is found, and how much more than elsewhere.
    pub learned_from: f64,
    pub found_from: f64,
    pub better_by: f64,
}

impl Numbers {
    /// As measured, with all parts.
    pub fn robust() -> Self {
        Self {
            parts: Parts {
                velocity: true,
                distance_penalty: true,
                size: true,
                verification: true,
                gated_learning: true,
                sweep: true,
            },
            pixels: 1600,
            finest: 0.5,
            read_of_a_side: 2,
            cell: 4,
            cover: (7.0, 5.0),
            least_cells: 4,
            most_cells_on_a_side: 32,
            most_cells: 200,
            norm_floor: 32.0,
            norm_gain: 635.0,
            reach: 8,
            bell: (1.0, 10.0),
            bell_entries: 32.0,
            bell_end: 5.0,
            pull: 5056.0,
            most_coded: 8191.0,
            most_gathered: 16_383.0,
            most_error: 65_535.0,
            step: 5.0 / 8.0,
            first_step: 5.0 / 8.0,
            first_steps: 25,
            distance_penalty: 77.0,
            expected: 0.5,
            last_move: 0.5,
            size_step: 66_847.0 / 65_536.0,
            size_part: 252.0,
            size_reach: 1,
            most_scale: 5.0,
            early_rate: 1.0 / 1024.0,
            scale: 255.0,
            most_gain: 2.0,
            alpha_bounds: (8.0, 100.0),
            least_contrast: 0.25,
            most_cut_off: 0.5,
            parts_across: 4,
            ratio_that_counts: 4,
            margin: 3,
            far: 2,
            certain_from: 55_000.0,
            most_move: 1.0,
            most_growth: 1310.0,
            more: 64.0,
            most_sum: 4096.0,
            trust_rate: 77.0,
            beyond: 29_000.0,
            lost_below: 19_200.0,
            uncertain_below: 32_500.0,
            learned_from: 37_500.0,
            found_from: 52_000.0,
            better_by: 16_000.0,
        }
    }
}
