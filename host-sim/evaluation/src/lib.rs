//! Evaluation: trackers run over recordings, and their answers scored against ground truth.
//!
//! Trackers are those of smr-core and the baselines beside them ([`MethodKind`]); a [`Variant`] is one with its settings. A [`Follower`] follows
//! a target frame by frame; a [`Run`] is the record of that, and all figures are made from it. [`Evaluation`] scores by the protocols of the
//! paper, OTB and VOT, also the answers of other trackers. [`robustness`] (from several starts), [`faults`] and [`covers`] use the same driver.
//! Results are [`Tables`] for programs and people.

mod baseline;
pub mod covers;
mod evaluation;
pub mod faults;
mod matrix;
mod means;
mod method;
mod otb;
pub mod published;
mod refused;
mod result_file;
pub mod robustness;
mod run;
mod score;
mod table;
mod variant;
mod vot;

pub use evaluation::{Contestant, Evaluation, evaluate, measure};
pub use matrix::{Measured, Progress};
pub use method::{CoreKind, Evidence, Method, MethodKind, Report, name_of};
pub use otb::{Curves, FARTHEST, NEAR, Otb, STEPS, centre_errors};
pub use refused::Refused;
pub use result_file::{ResultFile, result_files};
pub use run::{Follower, Run, lock};
pub use score::{CORRECT, Score, Trajectory, overlaps};
pub use table::{Layout, TableName, Tables};
pub use variant::{Configs, Origin, Variant};
pub use vot::Vot;

/// The most pixels of a template: as many as the 32 bits of a score can sum, for example 256x256.
pub const MOST_PIXELS: usize = 65536;

/// The most offsets of a window on an axis: the whole of a frame of up to about 4000x4000 pixels.
pub const MOST_OFFSETS: usize = 4096;

/// The paper's tracker with its largest capacities.
pub type Paper = smr_core::Paper<MOST_PIXELS, MOST_OFFSETS>;

#[cfg(test)]
pub(crate) mod tests {
    use smr_recordings::{BoundingBox, GrayFrame, Sequence};

    /// Four frames of a target that moves by two pixels a frame, and nothing beside them.
    pub fn sequence() -> Sequence {
        let frame = |left: i32| {
            let texture = |x: i32, y: i32| u8::try_from(100 + (x * 31 + y * 17) % 97).unwrap();
            let inside = |x: i32, y: i32| (left..left + 5).contains(&x) && (6..10).contains(&y);
            GrayFrame::drawn(24, 20, |x, y| if inside(x, y) { texture(x - left, y) } else { 10 })
        };
        let at = |x: f64| BoundingBox { x, y: 6.0, width: 5.0, height: 4.0 };
        let truth = [4.0, 6.0, 8.0, 10.0].map(|x| Some(at(x))).to_vec();
        Sequence::made("moving", [4, 6, 8, 10].map(frame).into_iter(), truth)
    }
}
