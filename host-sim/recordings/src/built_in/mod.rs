//! Built-in recordings: the drawn scenes as sequences with ground truth.

pub(crate) mod border;
pub(crate) mod noise;
pub(crate) mod periodic;
pub mod street;
pub mod synthetic;
pub(crate) mod tiles;
