//! The searches in windows of one size, summed up: the time of each way to search, and how the ways compare.

use super::case;
use super::sad::Sad;
use super::searches::{Searches, Timed, Way};
use host_sim::percentiles::Spread;
use serde::{Serialize, Serializer};
use smr_core::paper::Radius;
use smr_core::similarity::Backend;
use std::time::Duration;

/// All searches in windows of one size.
#[derive(Serialize)]
pub struct Window {
    #[serde(serialize_with = "as_text")]
    pub window: Radius,
    pub offsets: u32,
    pub cases: usize,
    /// Cases without room for the window.
    pub skipped: usize,
    pub ways: Vec<Row>,
    pub ratios: Vec<Ratio>,
}

/// One way to search.
#[derive(Serialize)]
pub struct Row {
    #[serde(serialize_with = "shown")]
    pub way: Way,
    pub cases: usize,
    pub nanoseconds: Spread<u64>,
    /// Time divided by all offsets and pixels, also those that were not compared; the median. `None` from the robust tracker,
    /// whose window is its own.
    pub nanoseconds_per_offset_pixel: Option<f64>,
    /// The share of an exhaustive search's comparisons that were made; the median. `None` where they are not counted.
    pub work_left: Option<f64>,
    /// Work of an update in the units of `Update::step`; the median. `None` where it is not counted.
    pub work: Option<u64>,
}

/// How many times as long one way takes as another: the median of the cases' ratios.
#[derive(Clone, Serialize)]
pub struct Ratio {
    #[serde(serialize_with = "shown")]
    pub of: Way,
    #[serde(serialize_with = "shown")]
    pub to: Way,
    pub cases: usize,
    pub median: f64,
}

impl Window {
    pub(super) fn new(searches: &Searches) -> Self {
        Self {
            window: searches.radius,
            offsets: case::offsets(searches.radius),
            cases: searches.comparisons.len(),
            skipped: searches.skipped,
            ways: searches.ways.iter().filter_map(|timed| Row::new(timed, &searches.comparisons)).collect(),
            ratios: pairs().into_iter().filter_map(|(of, to)| Ratio::new(searches, of, to)).collect(),
        }
    }

    /// How many times as long `of` takes as `to`.
    pub fn ratio(&self, of: Way, to: Way) -> Option<f64> {
        self.ratios.iter().find(|ratio| (ratio.of, ratio.to) == (of, to)).map(|ratio| ratio.median)
    }
}

impl Row {
    /// `None` for a way that was not timed.
    fn new(timed: &Timed, comparisons: &[u64]) -> Option<Self> {
        let times: Vec<(Duration, u64)> =
            timed.times.iter().zip(comparisons).filter_map(|(time, &all)| Some(((*time)?, all))).collect();
        if times.is_empty() {
            return None;
        }
        let nanoseconds: Vec<u64> = times.iter().map(|(time, _)| nanoseconds(*time)).collect();
        let in_window = !matches!(timed.way, Way::Robust(_));
        let each: Vec<f64> = times.iter().map(|(time, all)| time.as_secs_f64() * 1e9 / *all as f64).collect();
        let left: Vec<f64> =
            timed.work.iter().zip(comparisons).filter_map(|(work, &all)| Some((*work)? as f64 / all as f64)).collect();
        let work: Vec<u64> = timed.work.iter().copied().flatten().collect();
        Some(Self {
            way: timed.way,
            cases: times.len(),
            nanoseconds: Spread::of(&nanoseconds),
            nanoseconds_per_offset_pixel: in_window.then(|| Spread::of(&each).median),
            work_left: (in_window && !left.is_empty()).then(|| Spread::of(&left).median),
            work: (!work.is_empty()).then(|| Spread::of(&work).median),
        })
    }
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

impl Ratio {
    /// `None` if no case was timed in both ways.
    fn new(searches: &Searches, of: Way, to: Way) -> Option<Self> {
        let ratios = searches.ratios(of, to);
        (!ratios.is_empty()).then(|| Self { of, to, cases: ratios.len(), median: Spread::of(&ratios).median })
    }
}

/// What is compared with what.
fn pairs() -> Vec<(Way, Way)> {
    let yardsticks: Vec<Way> = Sad::available().map(Way::Sad).collect();
    let mut pairs = Vec::new();
    for backend in Backend::available() {
        let [pruned, exhaustive] = [true, false].map(|pruning| Way::Update { backend, pruning });
        pairs.push((pruned, exhaustive));
        pairs.push((Way::Robust(backend), pruned));
        pairs.extend(yardsticks.iter().flat_map(|&yardstick| [(pruned, yardstick), (exhaustive, yardstick)]));
    }
    pairs
}

/// A window as on the command line.
pub(super) fn as_text<S: Serializer>(radius: &Radius, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&format_args!("{}x{}", radius.x, radius.y))
}

fn shown<S: Serializer>(way: &Way, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(way)
}
