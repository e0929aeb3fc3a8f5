//! The instruction sets of Arm's microcontrollers, and the scores that both share.

#[cfg(smr_dsp)]
pub(crate) mod dsp;
#[cfg(smr_helium)]
pub(crate) mod helium;
pub(crate) mod points;
pub(crate) mod scores;
