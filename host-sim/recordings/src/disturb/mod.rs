//! Changes of frames on their way to a tracker: faults of a camera, covers, absences, a slow camera.

pub mod away;
pub mod cover;
pub mod fault;
