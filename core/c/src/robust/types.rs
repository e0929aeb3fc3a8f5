//! The plain data of the robust tracker that crosses the boundary, and what each is in `smr-core`.

use crate::pointer;
use crate::status::{smr_status, status_of};
use crate::types::smr_rect;
use smr_core::robust::{Answer, Config, FineRect, State};
use smr_core::similarity::Backend;

/// The parts of the robust tracker. Fill it with #smr_robust_config_default first, then change what is to be changed.
///
/// Each of the first six is 0 to leave the part out, else the part is there.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_robust_config {
    /// A target that moves is expected to go on. Without, it is expected where it was.
    pub velocity: u8,
    /// Places far from where the target is expected must answer more clearly.
    pub near: u8,
    /// The box follows the target's size.
    pub size: u8,
    /// An early template tells whether it is still the target. Without, the state is always #SMR_ROBUST_TRACKING.
    pub verification: u8,
    /// What does not agree with the early template is not learned; needs `verification`.
    pub caution: u8,
    /// A lost target is looked for all over the frame; needs `verification`.
    pub sweep: u8,
    /// 0: the fastest way that the processor has. Else: the plain loop, which loads single bytes; a frame in Device memory
    /// (external RAM before the MPU makes it Normal) needs it, as unaligned loads of words fault there. It changes no answer.
    pub plain_loop: u8,
}

/// What the robust tracker holds of its target after a frame.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum smr_robust_state {
    /// The early template agrees, part by part: this is the target.
    SMR_ROBUST_TRACKING = 0,
    /// It hardly agrees: the target is partly hidden or changes quickly, or something else is followed.
    SMR_ROBUST_UNCERTAIN = 1,
    /// It has not agreed for some frames: the target is not seen. The box is what is followed meanwhile. Nothing is learned
    /// from it, and the target is looked for elsewhere.
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
    /// How much speaks for it, 0 to 65535: a running mean of the early template's agreement, two thirds, and of the filter's
    /// response, one third. Below 15733 the target is lost, below 26666 it is uncertain.
    pub confidence: u16,
    /// How well the early template agrees in this frame, in units of 1/65535: the fourth least ratio of its 16 parts.
    pub ratio: u16,
    /// The filter's response at the place, in units of 1/16384: about 1 where the target looks as it did.
    pub response: i32,
    /// The target's size against that of the box that was locked on, in units of 1/65536.
    pub scale: u32,
    /// Products of the filter and comparisons of the template that it took.
    pub work: u32,
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
        Self {
            velocity: config.velocity.into(),
            near: config.near.into(),
            size: config.size.into(),
            verification: config.verification.into(),
            caution: config.caution.into(),
            sweep: config.sweep.into(),
            plain_loop: (config.backend == Some(Backend::Scalar)).into(),
        }
    }

    pub(super) fn config(&self) -> Config {
        let mut config = Config::robust();
        config.velocity = self.velocity != 0;
        config.near = self.near != 0;
        config.size = self.size != 0;
        config.verification = self.verification != 0;
        config.caution = self.caution != 0;
        config.sweep = self.sweep != 0;
        config.backend = (self.plain_loop != 0).then_some(Backend::Scalar);
        config
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
            confidence: answer.confidence,
            ratio: answer.ratio,
            response: answer.response,
            scale: answer.scale,
            work: answer.work,
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
        let back = smr_robust_config::all_parts().config();
        assert_eq!(printed(&back), printed(&Config::robust()));
        // Only the table is left to the library, and which backend but the plain loop.
        let fields = printed(&back).matches(": ").count();
        assert_eq!(fields, 7, "has Config a new part? Then smr_robust_config needs it too");
    }

    #[test]
    fn every_switch_leaves_out_its_own_part() {
        type Switch = fn(&mut smr_robust_config) -> &mut u8;
        let switches: [(&str, Switch); 6] = [
            ("velocity: false", |config| &mut config.velocity),
            ("near: false", |config| &mut config.near),
            ("size: false", |config| &mut config.size),
            ("verification: false", |config| &mut config.verification),
            ("caution: false", |config| &mut config.caution),
            ("sweep: false", |config| &mut config.sweep),
        ];
        for (wanted, switch) in switches {
            let mut config = smr_robust_config::all_parts();
            *switch(&mut config) = 0;
            let text = printed(&config.config());
            assert!(text.contains(wanted), "{wanted}: {text}");
            assert_eq!(text.matches("false").count(), 1, "{wanted}: {text}");
        }
    }

    #[test]
    fn the_plain_loop_is_chosen_by_its_switch() {
        let mut config = smr_robust_config::all_parts();
        assert_eq!(config.config().backend, None);
        config.plain_loop = 1;
        assert_eq!(config.config().backend, Some(Backend::Scalar));
    }
}
