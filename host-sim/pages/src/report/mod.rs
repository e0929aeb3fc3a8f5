//! Compares tracking methods on recordings, as one HTML page or as the paper's figures.

mod difference;
pub mod figures;
mod film;
mod observation;
mod page;
mod page_data;
mod player_frames;
mod scores;
mod trackers;

pub use film::{FilmedRecording, Refusal, Watch, watch};
pub use page::{About, page};
