//! The score loops of x86-64, AArch64 and WebAssembly, written once over a vector trait.
//!
//! The file of an instruction set defines [`Vector`], [`Neighbours`] and [`LookUp`]; `scores!` compiles its loops.
//!
//! The score of a patch f and a template g ([`sum_at_least`]):
//!
//! ```text
//! for each row of f and g
//!     for each whole vector of the row, then for the end of the row
//!         d = |f - g|
//!         total_low  += low_bytes[d]       both are 0 from the threshold on
//!         total_high += high_bytes[d]      at the end of a row only the lanes of its pixels are added
//!     every 8 rows: return None if the score so far + 65535 * (pixels in the rows left) < floor
//! score = total_low + 256 * total_high
//! return score if it is at least floor, else None
//! ```
//!
//! [`distance`] adds d without a table. The search excludes most offsets by loops that are cheaper than the score. They
//! count pixels: a score of at least `floor` needs at least `floor / 65535` pixels with d below the threshold.
//!
//! | loop | excludes | instructions for a vector |
//! |---|---|---|
//! | [`inside_at_least`] | a 4x4 group of offsets, by pixel ranges that are widened by the threshold | 4 |
//! | [`candidates`] | each of four neighbouring offsets | 4, of them 1 to prepare the template |
//!
//! Why the loops are written like this:
//!
//! 1. **Low and high bytes apart.** Entries have 16 bits, but a lookup gives one byte for each lane. Both byte planes
//!    have their own totals, which are joined once, at the end. No lane of a total overflows ([`Vector::Total`]).
//! 2. **No comparison with the threshold.** The entries from the threshold on are 0, so the lookup does it.
//! 3. **Two sets of totals in the score**, for even and odd rows, so that additions need not wait for the row before.
//! 4. **A check every 8 rows** (`ROWS_A_LOOK`). It adds the lanes of the totals, which is too slow for each row. The
//!    score skips the check while the remaining rows alone could reach the floor.
//! 5. **Counts in bytes.** A comparison gives 255, which is -1, in each lane where it holds, so one subtraction counts.
//!    A lane holds at most 255, so `Count::flush` empties the lanes: after 8 rows of up to two vectors and an end,
//!    else after each row and after 128 vectors.
//! 6. **A range in one comparison.** low <= g <= high takes one subtraction and one comparison (`widen`, `around`).
//! 7. **The width as a constant.** Rows of up to two vectors get loops in which the number of vectors (`WHOLE`) and
//!    whether an end follows (`END`) are constants (`by_width!`). If code must be small, only rows below one vector do.
//! 8. **No byte beyond a row is read.** The end of a row is loaded as the last vector that fits; lanes that overlap the
//!    vector before are masked. Rows narrower than a vector are copied ([`last`]) or loaded in parts (x86-64).
//! 9. **The last vector of ranges overlaps the one before** ([`spread`], [`ranges_of_rows`]), with the same values.
//! 10. **No closures.** A closure is a function of its own, without the `#[target_feature]` that it needs.

mod compiled;
mod counts;
mod lookup;
mod ranges;
mod row_loops;
mod sums;
mod vector;

pub(crate) use compiled::{compiled, scores};
pub(crate) use counts::{candidates, inside_at_least};
pub(crate) use lookup::{LookUp, Lookup};
#[cfg(target_arch = "x86_64")]
pub(crate) use ranges::half;
pub(crate) use ranges::{ranges_of_rows, spread, widen_all};
pub(crate) use row_loops::{ANY, by_width};
pub(crate) use sums::{distance, sum_at_least};
pub(crate) use vector::{Neighbours, Vector, intrinsics, last, last_lanes};
