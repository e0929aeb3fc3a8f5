//! The instruction sets of Arm's microcontrollers, and the bounds that both share.

mod bounds;
#[cfg(smr_dsp)]
pub(crate) mod dsp;
#[cfg(smr_helium)]
pub(crate) mod helium;
pub(crate) mod points;
