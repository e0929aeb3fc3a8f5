//! The tracker beyond the paper, for C: `smr_robust_*`, beside the paper's and with the same manners.

mod capacity;
mod tracker;
mod types;

pub use capacity::{ROBUST_STORAGE_ALIGN, ROBUST_STORAGE_SIZE};
pub use tracker::{
    smr_robust_early_template, smr_robust_init, smr_robust_lock, smr_robust_lock_window, smr_robust_tracker,
    smr_robust_tracker_size, smr_robust_update, smr_robust_window,
};
pub use types::{smr_fine_rect, smr_robust_answer, smr_robust_config, smr_robust_config_default, smr_robust_state};
