//! The loops of `scalar.rs`, faster: one file an instruction set, and the choice between them.
//!
//! | file | instruction set | used when | tested |
//! |---|---|---|---|
//! | `x86/avx2.rs` | AVX2 | found at run time (`std`) or compiled for | where the machine has it |
//! | `x86/sse2.rs` | SSE2, the least of x86-64 | every other x86-64 | on every x86-64 |
//! | `aarch64/neon.rs` | NEON | every AArch64 that is compiled for it | emulated by QEMU (`.ci/neon`), or natively |
//! | `arm/helium.rs` | Helium, the vectors of Armv8.1-M | compiled for it | `examples/kernels` on the emulated Cortex-M55 |
//! | `arm/dsp.rs` | DSP extension of Armv7E-M and Armv8-M | compiled for it, and not for Helium | `examples/kernels` on the emulated Cortex-M4 and M7 |
//! | (`scalar.rs`) | any | everywhere else | always |
//!
//! Words of four bytes by ordinary arithmetic do not pay where there is nothing better: on Armv6-M and RV32IMAC words cannot
//! be loaded from any address, and put together from bytes a distance takes 19 instead of 10 instructions a pixel on Armv6-M.
//!
//! `products/` has sums of products, by the same backends: what the robust tracker's filter is made of. `columns.rs`, `sectors.rs` (DSP)
//! and `arm/cells.rs` (Helium) are loops of its grid and features, `weights.rs` of its filter, by what the program is compiled for; answers on emulated parts and
//! the feature `verify` hold them against the plain loops.
//!
//! `generic.rs` has the loops that x86-64 and AArch64 share: there the file of an instruction set says only what a vector is and
//! how it looks a table up. The loops of `arm/` are by hand: they are `asm!`.
//!
//! `rows.rs` is what the kernels go through pictures by, `rolled.rs` keeps loops small; `verify.rs` has the plain loops beside them and
//! `verify_filter.rs` extreme values (feature `verify`).
//!
//! # Where weights would be added
//!
//! A weight for each pixel of the template, a small integer, would multiply what is looked up before it is added: in
//! `scalar::pixel`, which specifies it, in `generic::add_row` and in the loops of `arm/`. The
//! lookup and its tables stay as they are. Bounds then take the sum of the weights for the number of pixels.
//!
//! All `unsafe` of the crate is here. Every backend passes the same tests, which one macro stamps.

#![allow(unsafe_code)] // intrinsics; each block says why it is sound

#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
mod aarch64 {
    pub(super) mod neon;
}
#[cfg(any(smr_dsp, smr_helium))]
mod arm {
    #[cfg(smr_dsp)]
    pub(super) mod dsp {
        pub(in super::super) mod bilinear;
        pub(in super::super) mod gradients;
        pub(in super::super) mod products;
        pub(in super::super) mod scores;
    }
    #[cfg(smr_helium)]
    pub(super) mod helium {
        pub(in super::super) mod bilinear;
        pub(in super::super) mod gradients;
        pub(in super::super) mod products;
        pub(in super::super) mod scores;
        pub(in super::super) mod weights;
    }
    mod loss;
}
mod backend;
mod bilinear;
mod cells;
mod cut_table;
#[cfg(any(target_arch = "x86_64", all(target_arch = "aarch64", target_feature = "neon")))]
mod generic;
mod gradients;
mod layout;
mod plain {
    pub(super) mod bilinear;
    #[cfg(any(not(smr_helium), feature = "verify"))]
    pub(super) mod gradients;
    pub(super) mod products;
    pub(super) mod scores;
    pub(super) mod weights;
}
mod products;
#[cfg(any(target_arch = "x86_64", all(target_arch = "aarch64", target_feature = "neon"), smr_dsp, smr_helium))]
mod rows;
mod scorer;
mod scores;
mod unrolling;
#[cfg(any(test, feature = "verify"))]
mod verify {
    #[cfg(feature = "verify")]
    pub(super) mod filter;
    pub(super) mod scores;
}
mod weights;
#[cfg(target_arch = "x86_64")]
mod x86 {
    pub(super) mod avx2 {
        pub(in super::super) mod products;
        pub(in super::super) mod scores;
    }
    pub(super) mod sse2;
}

#[cfg(test)]
mod tests {
    mod guard;
    mod products;
    mod scores;
}

pub use backend::Backend;
pub(crate) use bilinear::Columns;
pub(crate) use cells::SIDE;
pub use cells::{CELL, CHANNELS};
pub use cut_table::CutTable;
pub(crate) use cut_table::{MAX_PIXELS, ONE};
pub(crate) use gradients::{gradients, scale};
pub(crate) use layout::{Layout, ROOM, Room};
pub(crate) use plain::bilinear::{LESS, Mixed};
pub(crate) use products::Products;
pub use scorer::Scorer;
pub(crate) use unrolling::rolled;
#[cfg(feature = "verify")]
pub use verify::filter::verify_filter;
pub(crate) use weights::{Move, Numbers, lessen_by};
