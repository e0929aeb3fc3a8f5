//! The correlation filter: weights (`correlation`), responses (`response`, `scale`), `learning` (label: `gaussian`).

mod correlation;
mod gaussian;
pub(super) mod learning;
pub(super) mod response;
pub(super) mod scale;

pub(super) use correlation::{Coded, FeatureWindow, Filter};
pub(super) use learning::{Learning, Sums, Training};
pub(super) use response::{CODED, Responses, layout};
pub(super) use scale::{Borrowed, ScaleSearch, Tools, other_scales};
