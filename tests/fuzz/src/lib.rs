//! The fuzz targets. Each takes any bytes and panics if it finds a fault.
//!
//! - `calls`: sequences of calls of a tracker, compared with the same calls of a plain tracker.
//! - `huge`: targets and frames of any size.
//! - `saved`: changed bytes of a saved target.
//! - `flight`: changed entries of a flight record.
//! - `readers`: the files, lines and words that host-sim reads.
//! - `scene`: the frames of `calls` and `saved`. `extent`: the size of inputs.

mod calls;
mod extent;
mod flight;
mod huge;
mod paper;
mod readers;
mod robust;
mod saved;
mod scene;

use arbitrary::Unstructured;
use smr_core::similarity::Backend;

pub type Run = fn(&[u8]);

/// Evaluates `$result` with `$sized` as the robust tracker of the size that the last byte of `$bytes` chooses.
macro_rules! of_size {
    ($bytes:ident, $sized:ident => $result:expr) => {{
        let (is_small, $bytes) = $bytes.split_last().map_or((false, $bytes), |(last, rest)| (last % 2 == 1, rest));
        if is_small {
            type $sized = smr_core::Robust<smr_core::robust::Small>;
            $result
        } else {
            type $sized = smr_core::Robust;
            $result
        }
    }};
}

/// All fuzz targets, each with its name, which is also its folder in `corpus`.
pub const TARGETS: &[(&str, Run)] = &[
    ("paper", |bytes| ran(calls::run::<paper::Small>(bytes, &extent::WIDE))),
    ("robust", |bytes| ran(of_size!(bytes, Chosen => calls::run::<Chosen>(bytes, &extent::WIDE)))),
    ("paper-short", |bytes| ran(calls::run::<paper::Small>(bytes, &extent::SHORT))),
    ("robust-short", |bytes| ran(of_size!(bytes, Chosen => calls::run::<Chosen>(bytes, &extent::SHORT)))),
    ("robust-huge", |bytes| ran(of_size!(bytes, Chosen => huge::run::<Chosen>(bytes)))),
    ("saved-paper", |bytes| ran(saved::run::<paper::Small>(bytes))),
    ("saved-robust", |bytes| ran(of_size!(bytes, Chosen => saved::run::<Chosen>(bytes)))),
    ("flight", |bytes| ran(flight::run(bytes))),
    ("picture", readers::picture),
    ("pnm", readers::pnm),
    ("png", readers::png),
    ("jpeg", readers::jpeg),
    ("y4m", readers::y4m),
    ("raw", readers::raw),
    ("boxes", readers::boxes),
    ("words", readers::words),
    ("former", readers::former),
];

pub fn target(name: &str) -> Option<Run> {
    TARGETS.iter().find(|(known, _)| *known == name).map(|(_, target)| *target)
}

fn ran(_: arbitrary::Result<()>) {}

trait Fuzzed: smr_core::Target<Config: 'static> {
    /// Index into [`extent::Extent::updates`]: a slow tracker gets fewer updates.
    const PACE: usize;
    /// Offset of the frame's width and height in a saved target.
    const SIZE_AT: usize;

    fn configuration(u: &mut Unstructured<'_>, extent: &extent::Extent) -> arbitrary::Result<Self::Config>;

    /// Returns the configuration with this backend; `None` selects the fastest.
    fn by(config: Self::Config, backend: Option<Backend>) -> Self::Config;

    fn usual() -> Self::Config;

    fn plain(config: Self::Config) -> Self::Config;

    /// Returns targets saved with the usual configuration, each with its scene; all are made once.
    fn locked() -> &'static [(scene::Scene, Vec<u8>)];

    /// Returns saved targets to start from if `lock` is slow; made once.
    fn starts() -> &'static [Start<Self::Config>];

    /// Returns true if this input is also run with the plain kernels.
    fn beside(u: &mut Unstructured<'_>) -> arbitrary::Result<bool>;
}

struct Start<C> {
    config: C,
    scene: scene::Scene,
    saved: Vec<u8>,
}

/// Returns mostly a number in `range`, sometimes any.
fn mostly(u: &mut Unstructured<'_>, range: std::ops::RangeInclusive<u16>) -> arbitrary::Result<u16> {
    if u.ratio(1, 16)? { u.arbitrary() } else { u.int_in_range(range) }
}
