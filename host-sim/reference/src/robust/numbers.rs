//! Parameters of the robust method, as in its description.

#[derive(Clone, Debug)]
pub struct Numbers {
    /// Optional parts: scale estimation; the network that corrects the box and can report *uncertain* or *lost*.
    pub size: bool,
    pub refiner: bool,
    /// Template: maximum number of pixels; minimum spacing of its samples, in frame pixels.
    pub pixels: i64,
    pub least_step: f64,
    /// Downsampling averages blocks of frame pixels: number of pixels read along each axis of a block.
    pub read_per_side: i64,
    /// Side of a cell, in template pixels.
    pub cell: i64,
    /// Side of the filter divided by the side of the box, as a fraction `.0 / .1`.
    pub filter_over_box: (f64, f64),
    /// Size of the filter in cells: minimum per side, maximum per side, maximum in total.
    pub least_side: i64,
    pub most_side: i64,
    pub most_cells: i64,
    /// Gradient features: constant added to the norm, in gray levels, and gain after the normalisation.
    pub norm_floor: f64,
    pub norm_gain: f64,
    /// Radius of search and of learning, in cells.
    pub reach: i64,
    /// Standard deviation of the label divided by the square root of the target's area, as a fraction `.0 / .1`.
    pub label_width: (f64, f64),
    /// Ridge penalty: factor of the squared filter weights in the error.
    pub regularisation: f64,
    /// Largest absolute values: of weights and gradients as scaled integers; of errors as scaled integers; of errors
    /// before scaling, in units of 1/16384.
    pub most_scaled: f64,
    pub most_scaled_error: f64,
    pub most_error: f64,
    /// Step length of an update, as a fraction of the step length of the exact line search.
    pub update_step: f64,
    /// Gradient steps at the lock. An update takes one.
    pub first_steps: usize,
    /// Largest factor by which the previous direction enters a conjugate-gradient step.
    pub most_conjugate: f64,
    /// Fraction of a response that is subtracted at the edge of the search, in units of 1/256.
    pub distance_penalty: f64,
    /// Motion: fraction of the velocity in the prediction, and weight of the last move in the velocity.
    pub velocity_fraction: f64,
    pub velocity_rate: f64,
    /// Scale search: factor between scales; weight of a response at a changed scale, in 1/256; search radius in cells.
    pub scale_step: f64,
    pub scale_gain: f64,
    pub scale_reach: i64,
    /// Calm targets: search radius in cells; frames since a lock or a find; largest recent offset in cells, and its decay.
    pub calm_reach: i64,
    pub calm_after: i64,
    pub calm_off: f64,
    pub calm_decay: f64,
    /// Largest scale; the smallest is its reciprocal.
    pub most_scale: f64,
    /// Weight of a new patch in the early template, a running mean.
    pub early_rate: f64,
    /// Similarity of a pixel: p = exp(-d / similarity_scale), with the difference d in gray levels.
    pub similarity_scale: f64,
    /// Gain of the template's contrast: largest factor between gain and expected gain; bounds of the expected gain (the
    /// lower one also limits the gain).
    pub most_change: f64,
    pub gain_bounds: (f64, f64),
    /// Lower bound of a search window's contrast, in gray levels.
    pub least_window: f64,
    /// Weight of a frame in the running mean of the lighting (the template's gain / the search window's contrast).
    pub light_rate: f64,
    pub alpha_bounds: (f64, f64),
    /// Patches that can show the target: minimum contrast as a fraction of the expected contrast; minimum contrast in
    /// gray levels; maximum fraction of clipped pixels (0 or 255) beyond the template's fraction.
    pub least_contrast: f64,
    pub least_deviation: f64,
    pub most_cut_off: f64,
    /// Verification: tiles per axis, and the rank of the tile whose similarity counts (1 is the least similar).
    pub tiles_across: i64,
    pub counted_tile_rank: usize,
    /// Alignment: largest offset on each axis, and spacing of the first nine offsets, in template pixels.
    pub margin: i64,
    pub coarse_step: i64,
    /// Minimum agreement (a patch's similarity to the early template) for refining position and size.
    pub refined_from: f64,
    /// Largest magnitudes in a Gauss-Newton step: move in template pixels, and growth in units of 1/65536.
    pub most_move: f64,
    pub most_growth: f64,
    /// Each diagonal element of the normal equations is multiplied by 1 + 1 / damping.
    pub damping: f64,
    /// Upper bound of the normal equations' elements after their division by a power of two.
    pub most_sum: f64,
    /// Confidence: weight of a frame in the mean evidence, in units of 1/256; largest lead of the mean over the frame's
    /// evidence, in units of 1/65536; confidences (0 to 65535) below which the target is lost or uncertain.
    pub confidence_rate: f64,
    pub most_lead: f64,
    pub lost_below: f64,
    pub uncertain_below: f64,
    /// Opinion: running mean of the network's trust in the box. Largest trust; weight of a frame in the mean; weight of
    /// a frame that raises a bad opinion; opinions below which the target is lost or uncertain.
    pub most_trust: f64,
    pub opinion_rate: f64,
    pub opinion_rising_rate: f64,
    pub opinion_lost_below: f64,
    pub opinion_uncertain_below: f64,
    /// Number of consecutive frames with a bad opinion after which the target is given up; opinion after a redetection.
    pub opinion_patience: i64,
    pub opinion_found: f64,
    /// Identity: running mean of the logits for showing the target. Largest magnitude of a logit; logit of a frame in
    /// which alignment made the box exact; weight of a frame in the mean; identity after a redetection; identity below
    /// which the target is uncertain, also the logit below which a frame loses evidence.
    pub most_logit: f64,
    pub exact_logit: f64,
    pub identity_rate: f64,
    pub identity_found: f64,
    pub same_from: f64,
    /// Evidence that a frame loses for each unit of its logit below `same_from`, and at most, in units of 1/65536.
    pub veto: f64,
    pub most_veto: f64,
    /// Minimum evidence (template agreement plus filter response) for learning from a frame, in units of 1/65536.
    pub learned_from: f64,
    /// Redetection of a lost target: windows per frame; minimum evidence, and its minimum lead over the evidence at the
    /// tracked position, both in units of 1/65536.
    pub sweep: i64,
    pub found_from: f64,
    pub better_by: f64,
    /// Minimum evidence and lead of a find that the network must recognise, and its minimum logit.
    pub recognised_from: f64,
    pub recognised_better_by: f64,
    pub recognised_logit: f64,
}

impl Numbers {
    pub fn refined() -> Self {
        Self {
            size: true,
            refiner: true,
            pixels: 1600,
            least_step: 0.5,
            read_per_side: 2,
            cell: 4,
            filter_over_box: (7.0, 5.0),
            least_side: 4,
            most_side: 32,
            most_cells: 200,
            norm_floor: 32.0,
            norm_gain: 635.0,
            reach: 8,
            label_width: (1.0, 10.0),
            regularisation: 5056.0,
            most_scaled: 8191.0,
            most_scaled_error: 16_383.0,
            most_error: 65_535.0,
            update_step: 5.0 / 8.0,
            first_steps: 7,
            most_conjugate: 0.75,
            distance_penalty: 77.0,
            velocity_fraction: 0.5,
            velocity_rate: 0.5,
            scale_step: 66_847.0 / 65_536.0,
            scale_gain: 252.0,
            scale_reach: 0,
            calm_reach: 6,
            calm_after: 3,
            calm_off: 2.0,
            calm_decay: 1.0 / 8.0,
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
            counted_tile_rank: 4,
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
            most_logit: 6.0,
            exact_logit: 4.0,
            identity_rate: 0.25,
            identity_found: -0.5,
            same_from: 1.0,
            veto: 20.0 * 1024.0,
            most_veto: 26_214.0,
            learned_from: 37_500.0,
            sweep: 4,
            found_from: 52_000.0,
            better_by: 16_000.0,
            recognised_from: 45_000.0,
            recognised_better_by: 9_000.0,
            recognised_logit: 1.5,
        }
    }

    /// These parameters in the small size of the tracker.
    pub fn small(self) -> Self {
        Self { pixels: 1296, most_cells: 162, reach: 7, ..self }
    }

    /// Sets the parameter that `--set` names to a value. False: there is no such parameter.
    pub fn set(&mut self, name: &str, value: u16) -> bool {
        let number = f64::from(value);
        match name {
            "size" => self.size = value != 0,
            "sweep" => self.sweep = value.into(),
            "refiner" => self.refiner = value != 0,
            "reach" => self.reach = value.into(),
            "patience" => self.confidence_rate = 256.0 - number,
            "lost_below" => self.lost_below = number,
            "uncertain_below" => self.uncertain_below = number,
            "learning_rate" => self.update_step = number / 256.0,
            "early_rate" => self.early_rate = number / 1024.0,
            _ => return false,
        }
        true
    }
}
