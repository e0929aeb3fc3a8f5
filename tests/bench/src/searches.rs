//! Times the same searches with every backend and the plain SAD search, in one run.

use super::case::{self, Case, Size, Triple};
use super::sad::Sad;
use crate::clock::{Budget, Patience, shortest, timed};
use anyhow::{Result, ensure};
use smr_core::paper::Radius;
use smr_core::similarity::Backend;
use smr_core::{Answer, Target, Tracker};
use smr_evaluation::CoreKind;
use std::fmt;
use std::time::Duration;

/// A way to search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// An update of the paper's tracker; without pruning it scores every offset in full.
    Update { backend: Backend, pruning: bool },
    /// An update of the robust tracker, which has a window of its own.
    Robust(Backend),
    /// A search of the least sum of absolute differences.
    Sad(Sad),
}

/// Its name in tables and in JSON.
impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Update { backend, pruning: true } => write!(f, "{backend:?}, pruned"),
            Self::Update { backend, pruning: false } => write!(f, "{backend:?}, exhaustive"),
            Self::Robust(backend) => write!(f, "robust, {backend:?}"),
            Self::Sad(Sad::Plain) => f.write_str("SAD, plain loop"),
            Self::Sad(Sad::Psadbw) => f.write_str("SAD, AVX2 psadbw"),
        }
    }
}

impl Way {
    /// What this machine can run of `methods` and beside them; the fastest backends first.
    pub fn all(methods: &[CoreKind]) -> Vec<Self> {
        let of_method = |method: &CoreKind| match method {
            CoreKind::Smr => {
                let updates = |backend| [true, false].map(|pruning| Self::Update { backend, pruning });
                Backend::available().flat_map(updates).collect::<Vec<_>>()
            }
            CoreKind::Robust => Backend::available().map(Self::Robust).collect(),
        };
        let sads = Sad::available().map(Self::Sad);
        methods.iter().flat_map(of_method).chain(sads).collect()
    }
}

/// All searches in windows of one size.
pub struct Searches {
    pub radius: Radius,
    pub size: Size,
    /// Offsets times pixels of the template, for each case.
    pub comparisons: Vec<u64>,
    /// Cases that had no room for the window.
    pub skipped: usize,
    pub ways: Vec<Timed>,
    /// Cases in which two ways gave different answers.
    pub differences: Vec<String>,
}

/// One way to search: its time in each case; `None` where it was not timed.
pub struct Timed {
    pub way: Way,
    pub times: Vec<Option<Duration>>,
    /// Comparisons of pixels that were made.
    pub work: Vec<Option<u64>>,
    budget: Budget,
}

impl Searches {
    /// Nothing timed yet. Each way may take `each` in all, for about `expected` cases.
    pub fn new(radius: Radius, size: Size, ways: &[Way], each: Duration, expected: u32) -> Self {
        let timed = |&way| Timed { way, times: vec![], work: vec![], budget: Budget::new(each, expected) };
        let ways = ways.iter().map(timed).collect();
        Self { radius, size, comparisons: vec![], skipped: 0, ways, differences: vec![] }
    }

    /// Times the search of `triple` in every way that runs here.
    /// Errors: The tracker fails, or a SAD search finds another place.
    pub fn add(&mut self, triple: &Triple, recording: &str, patience: Patience) -> Result<()> {
        let Some(case) = Case::new(triple, self.size, self.radius)? else {
            self.skipped += 1;
            return Ok(());
        };
        self.comparisons.push(case.comparisons());
        let (mut answers, mut sums) = (Vec::new(), Vec::new());
        for timed in &mut self.ways {
            let done = timed.budget.allows().then(|| timed.way.run(&case, patience)).transpose()?;
            timed.times.push(done.as_ref().map(|done| done.time));
            timed.work.push(done.as_ref().and_then(|done| done.work));
            let Some(done) = done else { continue };
            timed.budget.spend(done.spent);
            answers.extend(done.answer.map(|answer| (timed.way, answer)));
            sums.extend(done.sum);
        }
        ensure!(sums.windows(2).all(|sums| sums[0] == sums[1]), "the SAD searches do not find the same: {sums:?}");
        if let Some(difference) = difference(&answers) {
            self.differences.push(format!("{recording}, frame {}: {difference}", triple.number));
        }
        Ok(())
    }

    /// How many times as long `of` took as `to`, in every case that both were timed in.
    pub fn ratios(&self, of: Way, to: Way) -> Vec<f64> {
        let times = |way| self.ways.iter().find(|timed| timed.way == way).map_or(&[][..], |timed| &timed.times);
        let both = times(of).iter().zip(times(to)).filter_map(|(of, to)| Some(((*of)?, (*to)?)));
        both.map(|(of, to)| of.as_secs_f64() / to.as_secs_f64().max(1e-9)).collect()
    }
}

/// One way in one case.
pub(super) struct Done {
    pub time: Duration,
    /// With all that had to be prepared, and all repetitions.
    spent: Duration,
    work: Option<u64>,
    answer: Option<Answer>,
    /// Of a SAD search.
    sum: Option<u32>,
}

impl Way {
    fn run(self, case: &Case, patience: Patience) -> Result<Done> {
        let (done, spent) = timed(|| match self {
            Self::Update { backend, pruning } => {
                let mut done = update(case, &mut *case.tracker(backend, pruning)?, patience)?;
                // What was counted is at most what is done, and may be a little more than all there is.
                done.work = if pruning { done.work } else { Some(case.comparisons()) };
                Ok(done)
            }
            Self::Robust(backend) => update(case, &mut *case::robust(backend)?, patience),
            Self::Sad(sad) => least_sum(case, sad, patience),
        });
        Ok(Done { spent, ..done? })
    }
}

pub(super) fn update<T: Target>(case: &Case, tracker: &mut Tracker<T>, patience: Patience) -> Result<Done> {
    let mut answer = None;
    // The search changes the tracker: each time it starts from the same state.
    let time = shortest(patience, || {
        case.prepare(tracker)?;
        let frame = case.frame();
        let (result, time) = timed(|| tracker.update(&frame));
        answer = Some(result?);
        Ok(time)
    })?;
    Ok(Done { time, spent: Duration::ZERO, work: Some(tracker.work().into()), answer, sum: None })
}

fn least_sum(case: &Case, sad: Sad, patience: Patience) -> Result<Done> {
    let mut sum = None;
    let time = shortest(patience, || {
        let (found, time) = timed(|| sad.search(&case.crop, &case.template));
        sum = Some(found.2);
        Ok(time)
    })?;
    Ok(Done { time, spent: Duration::ZERO, work: Some(case.comparisons()), answer: None, sum })
}

/// The first answer that differs from that of the first way of the same tracker. A runner-up that one of them did not look for is
/// not compared.
fn difference(answers: &[(Way, Answer)]) -> Option<String> {
    let same = |answer: &Answer| Answer { runner_up_ratio: None, ..*answer };
    let is_robust = |way: Way| matches!(way, Way::Robust(_));
    answers.iter().find_map(|(way, answer)| {
        let (first, expected) = answers.iter().find(|(first, _)| is_robust(*first) == is_robust(*way))?;
        (same(answer) != same(expected)).then(|| format!("{way} answers {answer:?}, {first} {expected:?}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::triples;
    use smr_recordings::{OpenOptions, open, synthetic};

    #[test]
    fn every_way_is_timed_in_every_case_and_all_agree() {
        let ways = Way::all(&[CoreKind::Smr, CoreKind::Robust]);
        let radius = Radius { x: 4, y: 3 };
        let mut searches = Searches::new(radius, Size::Of(16, 16), &ways, Duration::from_secs(60), 3);
        let patience = Patience { repeats: 2, enough: Duration::from_secs(1) };
        let sequence = open(synthetic::NAME.as_ref(), &OpenOptions::default()).unwrap();
        triples(sequence, 60, |triple| searches.add(triple, "synthetic", patience)).unwrap();
        assert_eq!((searches.skipped, searches.comparisons.as_slice()), (0, &[63 * 256; 3][..]));
        assert_eq!(searches.differences, [""; 0]);
        let timed = |way| searches.ways.iter().find(|timed| timed.way == way).unwrap();
        let scalar = |pruning| Way::Update { backend: Backend::Scalar, pruning };
        assert_eq!(timed(scalar(false)).work, [Some(63 * 256); 3]);
        assert!(timed(scalar(true)).times.iter().all(Option::is_some));
        let robust = timed(Way::Robust(Backend::Scalar));
        assert!(robust.times.iter().all(Option::is_some) && robust.work.iter().all(|work| *work > Some(0)));
        assert_eq!(searches.ratios(scalar(true), scalar(true)), [1.0; 3]);
    }

    #[test]
    fn answers_that_differ_are_noticed() {
        let mut tracker = Tracker::<smr_evaluation::Paper>::new(smr_core::paper::Config::paper()).unwrap();
        let frame = synthetic::frame(0);
        tracker.lock(&frame.frame(), smr_core::Rect::new(36, 24, 24, 28)).unwrap();
        let answer = tracker.update(&frame.frame()).unwrap();
        let (one, other) = (Way::Robust(Backend::Scalar), Way::Robust(Backend::Avx2));
        assert_eq!(difference(&[(one, answer), (other, answer)]), None);
        let moved = Answer { confidence: answer.confidence ^ 1, ..answer };
        assert!(difference(&[(one, answer), (other, moved)]).unwrap().starts_with("robust, Avx2 answers"));
        let paper = Way::Update { backend: Backend::Scalar, pruning: true };
        assert_eq!(difference(&[(one, answer), (paper, moved)]), None, "another tracker");
    }
}
