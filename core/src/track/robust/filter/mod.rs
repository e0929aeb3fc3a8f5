//! The correlation filter: its weights (`correlation`), its responses (`response`, `scale`), and its learning
//! (`learning`) with the Gaussians of the label and the mask (`gaussian`).

mod correlation;
mod gaussian;
pub(super) mod learning;
pub(super) mod response;
pub(super) mod scale;

pub(super) use correlation::{Coded, FeatureWindow, Filter};
pub(super) use learning::{Learning, Sums, Training};
pub(super) use response::{CODED, Responses, layout};
pub(super) use scale::{Borrowed, ScaleSearch, Tools, other_scales};
