//! Kernels for Arm's microcontrollers: the DSP extension, Helium, and the score kernels that both share.

#[cfg(smr_dsp)]
pub(crate) mod dsp;
#[cfg(smr_helium)]
pub(crate) mod helium;
pub(crate) mod points;
pub(crate) mod scores;
