//! Evaluation: runs trackers over recordings, and scores their answers against ground truth.
//!
//! Trackers are those of smr-core and baselines ([`MethodKind`]); a [`Variant`] is one with settings. A [`Follower`]
//! follows a target frame by frame; a [`Run`] records its answers. [`Evaluation`] scores by the protocols of the paper,
//! OTB and VOT. [`robustness`], [`faults`] and [`covers`] share a driver. Results are [`Tables`].

mod baseline;
pub mod choice;
pub mod covers;
mod evaluation;
pub mod faults;
mod matrix;
mod means;
mod method;
mod otb;
pub mod paper_table;
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
pub use method::{CoreKind, Evidence, Method, MethodAnswer, MethodKind, name_of};
pub use otb::{Curves, FARTHEST, NEAR, Otb, STEPS, centre_errors};
pub use refused::Refused;
pub use result_file::{ResultFile, result_files};
pub use run::{Follower, Run, lock};
pub use score::{CORRECT, Score, overlaps};
pub use table::{Layout, TableName, Tables};
pub use variant::{Configs, Origin, RobustSize, Variant};
pub use vot::Vot;

/// Maximum number of pixels of a template, for example 256x256: a larger one could overflow the 32 bits of a score.
pub const MAX_PIXELS: usize = 65536;

/// Maximum number of offsets of a search window per axis, enough to search all of a frame of about 4000x4000 pixels.
pub const MAX_OFFSETS: usize = 4096;

pub type Paper = smr_core::Paper<MAX_PIXELS, MAX_OFFSETS>;

#[cfg(test)]
pub(crate) mod tests {
    use smr_recordings::{BoundingBox, GrayFrame, Sequence};

    /// Four frames of a textured target that moves by two pixels per frame on a uniform background.
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
