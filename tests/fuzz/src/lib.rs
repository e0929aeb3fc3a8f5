//! What is fuzzed. A target takes any bytes, and panics if something is wrong.
//!
//! - `calls`: sequences of calls of a tracker, beside a plain one that must answer the same.
//! - `saved`: changed bytes of a saved target.
//! - `readers`: the files, lines and words that host-sim reads.
//! - `scene`: the frames that both see.

mod calls;
mod paper;
mod readers;
mod robust;
mod saved;
mod scene;

use arbitrary::Unstructured;

/// What a target is: it takes any bytes, and panics at a finding.
pub type Run = fn(&[u8]);

/// All targets, by name: also that of the folder in `corpus`.
pub const TARGETS: &[(&str, Run)] = &[
    ("paper", |bytes| ran(calls::run::<paper::Small>(bytes))),
    ("robust", |bytes| ran(calls::run::<smr_core::Robust>(bytes))),
    ("saved-paper", |bytes| ran(saved::run::<paper::Small>(bytes))),
    ("saved-robust", |bytes| ran(saved::run::<smr_core::Robust>(bytes))),
    ("picture", readers::picture),
    ("pnm", readers::pnm),
    ("png", readers::png),
    ("jpeg", readers::jpeg),
    ("y4m", readers::y4m),
    ("raw", readers::raw),
    ("boxes", readers::boxes),
    ("words", readers::words),
    ("trax", readers::trax),
    ("settings", readers::settings),
    ("former", readers::former),
    ("vectors", readers::vectors),
];

/// The target of a name.
pub fn target(name: &str) -> Option<Run> {
    TARGETS.iter().find(|(known, _)| *known == name).map(|(_, target)| *target)
}

/// That the bytes ended early is no finding.
fn ran(_: arbitrary::Result<()>) {}

/// A tracker that is fuzzed.
trait Fuzzed: smr_core::Target {
    /// The most updates of one input: what is slow is called less often.
    const UPDATES: u32;
    /// Where the frame's width and height stand in a saved target.
    const SIZE_AT: usize;

    /// A configuration, valid or not.
    fn configuration(u: &mut Unstructured<'_>) -> arbitrary::Result<Self::Config>;

    /// One that a tracker takes.
    fn usual() -> Self::Config;

    /// The same, computed by the plain loops.
    fn plain(config: Self::Config) -> Self::Config;

    /// Targets to be saved, made once.
    fn locked() -> &'static [(scene::Scene, Vec<u8>)];

    /// Whether the plain loops run beside it for this input.
    fn beside(u: &mut Unstructured<'_>) -> arbitrary::Result<bool>;
}

/// Mostly a number in the range, sometimes any.
fn mostly(u: &mut Unstructured<'_>, range: std::ops::RangeInclusive<u16>) -> arbitrary::Result<u16> {
    if u.ratio(1, 16)? { u.arbitrary() } else { u.int_in_range(range) }
}
