//! The plain data of the robust tracker that crosses the boundary, and what each is in `smr-core`.

use crate::pointer;
use crate::status::{smr_status, status_of};
use crate::types::{smr_fraction, smr_peak, smr_rect};
use smr_core::robust::{Answer, Config, FineRect, State, ThresholdRule};

/// The parts of the robust tracker. Fill it with #smr_robust_config_default first, then change what is to be changed.
///
/// Each switch is 0 to leave the part out; the tracker then does what the paper's does in its place. Else the part is there.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_robust_config {
    /// Small targets are enlarged, up to twice; without, the grid is never finer than the frame.
    pub enlarging: u8,
    /// alpha follows the template's contrast; without, the paper's rule: k * (largest change of a pixel of the template).
    pub contrast: u8,
    /// k of the paper's rule; more than 0. Without meaning if `contrast` is not 0.
    pub k: smr_fraction,
    /// A running mean of the patches is compared beside the last one.
    pub slow_template: u8,
    /// The early template, in the light of the last patch, has a say in where the target is.
    pub anchor: u8,
    /// Positions are finer than a pixel of the grid.
    pub sub_pixel: u8,
    /// The box follows the target's size.
    pub cells: u8,
    /// An early template is asked, part by part, if it is still the target; without, the state is always #SMR_ROBUST_TRACKING.
    pub verification: u8,
    /// A lost or doubtful target is looked for all over the frame; needs `verification`.
    pub sweep: u8,
    /// Offsets that cannot matter are left out; it changes nothing but the time.
    pub pruning: u8,
}

/// What the robust tracker holds of its target after a frame.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum smr_robust_state {
    /// The early template agrees, part by part: this is the target.
    SMR_ROBUST_TRACKING = 0,
    /// It hardly agrees: the target is partly hidden or changes quickly, or something else is followed.
    SMR_ROBUST_UNCERTAIN = 1,
    /// It has not agreed for some frames: the target is not seen. The box is what is followed
    /// meanwhile; it is believed again only when the early template agrees clearly.
    SMR_ROBUST_LOST = 2,
}

/// A rectangle in units of 1/256 pixel of the full frame. It may reach outside the frame.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_fine_rect {
    /// Left edge, to the right of the frame's left edge; may be negative.
    pub x: i32,
    /// Top edge, below the frame's top edge; may be negative.
    pub y: i32,
    /// Width.
    pub width: u32,
    /// Height.
    pub height: u32,
}

/// The answer of #smr_robust_update.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_robust_answer {
    /// The target's box, in units of 1/256 pixel.
    pub fine: smr_fine_rect,
    /// The same in whole pixels, each edge rounded.
    pub bbox: smr_rect,
    /// Whether the box is to be believed.
    pub state: smr_robust_state,
    /// How well the early template agrees, in units of 1/65535: the fourth least ratio of its 16 parts. Without verification,
    /// how well the templates match.
    pub ratio: u16,
    /// The threshold that this frame was scored with, in gray levels (0..256): a pixel counted if it differed by less.
    pub alpha: u16,
    /// The target's size against that of the box that was locked on, in units of 1/65536.
    pub scale: u32,
    /// The best offset on the grid, from the window's first, (32, 32) being the last position; and the scores of the last
    /// patch, twice, of the slow template, and of the anchor, twice, in units of 1/65535 of a fully similar pixel.
    pub peak: smr_peak,
    /// Comparisons of bytes that it took, at most, and products of the sweep.
    pub comparisons: u32,
    /// 1 if the sweep found the target, in this frame; else 0.
    pub found_again: u8,
}

/// Fills a configuration with all parts.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_robust_config_default(config: *mut smr_robust_config) -> smr_status {
    // SAFETY: the caller gives memory for an smr_robust_config.
    let out = unsafe { pointer::Out::new(config) };
    status_of(out.map(|out| out.write(smr_robust_config::all_parts())))
}

impl smr_robust_config {
    fn all_parts() -> Self {
        let config = Config::robust();
        let (contrast, k) = match config.threshold {
            ThresholdRule::Contrast => (true, smr_core::Config::paper().k),
            ThresholdRule::LargestChange(k) => (false, k),
        };
        Self {
            enlarging: config.enlarging.into(),
            contrast: contrast.into(),
            k: k.into(),
            slow_template: config.slow_template.into(),
            anchor: config.anchor.into(),
            sub_pixel: config.sub_pixel.into(),
            cells: config.cells.into(),
            verification: config.verification.into(),
            sweep: config.sweep.into(),
            pruning: config.pruning.into(),
        }
    }

    pub(super) fn config(&self) -> Result<Config, smr_status> {
        let mut config = Config::robust();
        config.enlarging = self.enlarging != 0;
        config.threshold = self.threshold()?;
        config.slow_template = self.slow_template != 0;
        config.anchor = self.anchor != 0;
        config.sub_pixel = self.sub_pixel != 0;
        config.cells = self.cells != 0;
        config.verification = self.verification != 0;
        config.sweep = self.sweep != 0;
        config.pruning = self.pruning != 0;
        Ok(config)
    }

    fn threshold(&self) -> Result<ThresholdRule, smr_status> {
        if self.contrast != 0 {
            return Ok(ThresholdRule::Contrast);
        }
        if self.k.denominator == 0 {
            return Err(smr_status::SMR_ERROR_ZERO_DENOMINATOR);
        }
        if self.k.numerator == 0 {
            return Err(smr_status::SMR_ERROR_NOTHING_COUNTS);
        }
        Ok(ThresholdRule::LargestChange(self.k.into()))
    }
}

impl From<State> for smr_robust_state {
    fn from(state: State) -> Self {
        match state {
            State::Tracking => Self::SMR_ROBUST_TRACKING,
            State::Uncertain => Self::SMR_ROBUST_UNCERTAIN,
            State::Lost => Self::SMR_ROBUST_LOST,
        }
    }
}

impl From<FineRect> for smr_fine_rect {
    fn from(rect: FineRect) -> Self {
        Self { x: rect.x, y: rect.y, width: rect.width, height: rect.height }
    }
}

impl From<Answer> for smr_robust_answer {
    fn from(answer: Answer) -> Self {
        Self {
            fine: answer.fine.into(),
            bbox: answer.bbox.into(),
            state: answer.state.into(),
            ratio: answer.ratio,
            alpha: answer.alpha,
            scale: answer.scale,
            peak: answer.peak.into(),
            comparisons: answer.comparisons,
            found_again: answer.found_again.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;

    /// What `Config` prints, without its table.
    fn printed(config: &Config) -> std::string::String {
        let text = format!("{config:?}");
        text.split_once("] }").expect("the table stands first").1.into()
    }

    #[test]
    fn all_parts_come_back_as_they_were() {
        let back = smr_robust_config::all_parts().config().unwrap();
        assert_eq!(printed(&back), printed(&Config::robust()));
        // Only the table and the backend are left to the library.
        let fields = printed(&back).matches(": ").count();
        assert_eq!(fields, 10, "has Config a new part? Then smr_robust_config needs it too");
    }

    #[test]
    fn every_switch_leaves_out_its_own_part() {
        type Switch = fn(&mut smr_robust_config) -> &mut u8;
        let switches: [(&str, Switch); 9] = [
            ("enlarging: false", |config| &mut config.enlarging),
            ("threshold: LargestChange(Fraction { numerator: 1, denominator: 4 })", |config| &mut config.contrast),
            ("slow_template: false", |config| &mut config.slow_template),
            ("anchor: false", |config| &mut config.anchor),
            ("sub_pixel: false", |config| &mut config.sub_pixel),
            ("cells: false", |config| &mut config.cells),
            ("verification: false", |config| &mut config.verification),
            ("sweep: false", |config| &mut config.sweep),
            ("pruning: false", |config| &mut config.pruning),
        ];
        for (wanted, switch) in switches {
            let mut config = smr_robust_config::all_parts();
            *switch(&mut config) = 0;
            let text = printed(&config.config().unwrap());
            assert!(text.contains(wanted), "{wanted}: {text}");
            let others = text.matches("false").count() + text.matches("LargestChange").count();
            assert_eq!(others, 1, "{wanted}: {text}");
        }
    }
}
