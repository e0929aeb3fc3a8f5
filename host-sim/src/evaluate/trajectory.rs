//! The boxes of a target over a recording, as all scores take them: the ground truth, and what a tracker answered.

use crate::sequence::BoundingBox;

/// One entry for each frame. `None` where the target is not visible (ground truth) or the tracker gave no answer.
pub type Trajectory = [Option<BoundingBox>];
