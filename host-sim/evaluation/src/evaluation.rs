//! Scores the trackers run here and result files of other trackers on whole recordings; shows the paper's figures too.

use super::matrix::truth_of;
use super::means::{means, standard_errors};
use super::score::Figure;
use super::table::{Head, Table, TableName, Tables, blank, cells};
use super::{
    Follower, Measured, Origin, Progress, ResultFile, Run, Score, Variant, paper_table, result_file, result_files,
};
use anyhow::{Context, Error, Result, anyhow, ensure};
use rayon::prelude::*;
use serde_json::Value;
use smr_files::signals;
use smr_recordings::{Frame, Sequence, misfit};
use std::path::{Path, PathBuf};

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contestant {
    pub name: String,
    /// The tracker that was run here; `None` for the result file of another tracker.
    pub origin: Option<Origin>,
}

impl Contestant {
    pub fn of(variant: &Variant) -> Self {
        Self { name: variant.name.clone(), origin: Some(variant.origin()) }
    }

    pub const fn file(name: String) -> Self {
        Self { name, origin: None }
    }
}

pub struct Evaluation {
    pub sequence: String,
    pub visible: usize,
    pub scores: Vec<(Contestant, Score)>,
    /// Errors because of which a tracker or a result file has no score.
    pub failures: Vec<Error>,
    pub notes: Vec<String>,
}

/// Evaluates recordings in parallel, each on one thread; if `compares`, also scores result files beside a recording.
pub fn measure(
    paths: &[PathBuf],
    open: impl Fn(&Path) -> Result<Sequence> + Sync,
    variants: &[Variant],
    compares: bool,
    progress: &(dyn Fn(Progress) + Sync),
) -> Measured {
    let one = |path: &PathBuf| {
        let sequence = open(path)?;
        let frames = sequence.truth.as_ref().map_or(0, |truth| truth.len() as u64);
        progress(Progress::Expected { frames, recordings: 1 });
        let files = if compares { result_files(path)? } else { Vec::new() };
        evaluate(sequence, variants, &files, || progress(Progress::Done))
    };
    let all: Vec<_> = paths.par_iter().filter_map(|path| (!signals::is_stopped()).then(|| one(path))).collect();
    let (mut evaluations, mut failures) = (Vec::new(), Vec::new());
    for evaluation in all {
        match evaluation {
            Ok(mut evaluation) => {
                failures.append(&mut evaluation.failures);
                evaluations.push(evaluation);
            }
            Err(error) => failures.push(error),
        }
    }
    failures.retain(|_| !signals::is_stopped());
    evaluations.retain(|evaluation| !evaluation.scores.is_empty());
    Measured {
        tables: Ok(Evaluation::tables(&evaluations)),
        failures,
        notes: evaluations.iter().flat_map(|evaluation| evaluation.notes.clone()).collect(),
        is_empty: evaluations.is_empty(),
    }
}

/// Runs `variants` over the sequence, and scores the result files of other trackers in `files`.
///
/// Each frame is decoded once; `progress` is called when all methods have seen it. Errors: No ground truth, one of
/// another length, no start box, or an unreadable frame. A contestant's error goes to [`Evaluation::failures`].
pub fn evaluate(
    sequence: Sequence,
    variants: &[Variant],
    files: &[PathBuf],
    progress: impl Fn(),
) -> Result<Evaluation> {
    let start = sequence.start();
    let Sequence { name, frames, truth, .. } = sequence;
    let truth = truth_of(&name, truth)?;
    let start = start?;
    let follower = |variant: &Variant| Ok(Follower::new(variant.build()?, vec![(1, Some(variant.start(start)))]));
    let followers: Result<Vec<_>> = variants.iter().map(follower).collect();
    let mut count = 0;
    let runs = follow(frames.inspect(|_| count += 1), followers?, progress)?;
    let boxes = truth.len();
    misfit(count, boxes).map_or(Ok(()), |misfit| Err(anyhow!("{name}: {misfit}")))?;

    let visible = truth.iter().flatten().count();
    let mut evaluation =
        Evaluation { sequence: name.clone(), visible, scores: vec![], failures: vec![], notes: vec![] };
    for (variant, run) in variants.iter().zip(runs) {
        let score = run.and_then(|run| Score::of(&run.reports, &truth));
        let score = score.with_context(|| format!("{name}: {}", variant.name));
        evaluation.add(Contestant::of(variant), score);
    }
    for path in files {
        let score = ResultFile::read(path, None, boxes).and_then(|file| {
            evaluation.notes.extend(file.note.clone());
            file.score(&truth)
        });
        evaluation.add(Contestant::file(result_file::name(path)), score);
    }
    Ok(evaluation)
}

impl Evaluation {
    fn add(&mut self, contestant: Contestant, score: Result<Score>) {
        match score {
            Ok(score) => self.scores.push((contestant, score)),
            Err(error) => self.failures.push(error),
        }
    }

    /// Returns four tables: scores; their means over recordings; counts of correct frames, printed in the paper; counts
    /// of correct frames, printed and measured. In each table, result files come last.
    pub fn tables(all: &[Self]) -> Tables {
        let origin = Head::all(Origin::COLUMNS);
        let figures = Score::FIGURES.iter().map(|of| Head::new(of.key, of.title, of.digits)).collect();
        let names = Head::list(&[("tracker", "tracker"), ("sequence", "sequence")]);
        let mut measured = Table::new(TableName::Measured, 2, [names, figures, origin.clone()].concat());
        // Text and Markdown show the means as remarks below the measured rows, not as a table.
        let names = Head::list(&[("tracker", ""), ("recordings", "")]);
        let with_errors = Head::with_errors(with_mean().map(|figure| figure.key));
        let mut means_of_all = Table::new(TableName::Means, 0, [names, with_errors, origin].concat());
        let heads = Head::list(&[("tracker", ""), ("sequence", ""), ("correct", "")]);
        let mut printed = Table::new(TableName::Printed, 0, heads);
        let mut heads = Head::list(&[("", "correct frames"), ("", "source")]);
        heads.extend(all.iter().map(|one| Head::new("", &format!("{} /{}", one.sequence, one.visible), 0)));
        let mut correct = Table::new(None, 2, heads);

        let is_known = all.iter().any(|one| paper_table::is_known(&one.sequence));
        for row in paper_table::TABLE.iter().filter(|_| is_known) {
            let figures = all.iter().map(|one| (one.sequence.as_str(), row.correct(&one.sequence)));
            for (sequence, figure) in figures.clone().filter(|(_, figure)| figure.is_some()) {
                printed.row(vec![row.tracker.into(), sequence.into(), figure.into()]);
            }
            let names = [row.tracker, paper_table::SOURCE].map(Value::from).into_iter();
            correct.row(names.chain(figures.map(|(_, figure)| figure.into())).collect());
        }
        for contestant in contestants(all) {
            let origin = cells(Origin::COLUMNS, contestant.origin.as_ref());
            let names = |what: &str| vec![contestant.name.as_str().into(), what.into()];
            let figures = |score: &Score| Score::FIGURES.iter().map(|figure| figure.value(score)).collect();
            let of = |one: &Self| one.scores.iter().find(|(who, _)| *who == contestant).map(|&(_, score)| score);
            let scores: Vec<Option<Score>> = all.iter().map(of).collect();
            for (one, score) in all.iter().zip(&scores).filter_map(|(one, score)| Some((one, score.as_ref()?))) {
                measured.row([names(&one.sequence), figures(score), origin.clone()].concat());
            }
            let counts = scores.iter().map(|score| score.map(|score| score.correct).into()).collect();
            correct.row([names("measured"), counts].concat());

            let scores: Vec<Score> = scores.into_iter().flatten().collect();
            if scores.len() < 2 {
                continue;
            }
            // All recordings have equal weight; one in which the target is never visible enters no mean.
            let known = scores.iter().filter(|score| score.visible > 0);
            let known: Vec<Vec<f64>> =
                known.map(|score| with_mean().map(|figure| (figure.of)(score).unwrap_or(0.0)).collect()).collect();
            let (mean, error) = (means(&known), standard_errors(&known).unwrap_or_default());
            measured.remark([names("total"), figures(&Score::total(&scores))].concat());
            for (what, values) in [(format!("mean of {}", known.len()), &mean), ("  standard error".into(), &error)] {
                let mut values = values.iter().copied();
                let cell = |figure: &Figure| if figure.has_mean { values.next().into() } else { blank() };
                measured.remark([names(&what), Score::FIGURES.iter().map(cell).collect()].concat());
            }
            let both = (0..with_mean().count()).flat_map(|at| [&mean, &error].map(|of| of.get(at).copied().into()));
            let names = vec![contestant.name.as_str().into(), known.len().into()];
            means_of_all.row([names, both.collect(), origin].concat());
        }
        Tables { tables: vec![measured, means_of_all, printed, correct], ..Tables::default() }
    }
}

fn with_mean() -> impl Iterator<Item = &'static Figure> {
    Score::FIGURES.iter().filter(|figure| figure.has_mean)
}

fn contestants(evaluations: &[Evaluation]) -> Vec<Contestant> {
    let mut all: Vec<Contestant> = Vec::new();
    for (contestant, _) in evaluations.iter().flat_map(|e| &e.scores) {
        if !all.contains(contestant) {
            all.push(contestant.clone());
        }
    }
    // Trackers that this program ran compare as equal and keep their order, because the sort is stable.
    all.sort_by(|a, b| match (&a.origin, &b.origin) {
        (None, None) => natord::compare(&a.name, &b.name),
        (a, b) => a.is_none().cmp(&b.is_none()),
    });
    all
}

/// Runs the followers over the frames. After an error a follower gets no more frames.
fn follow(
    frames: impl Iterator<Item = Result<Frame>>,
    followers: Vec<Follower>,
    progress: impl Fn(),
) -> Result<Vec<Result<Run>>> {
    let mut runs: Vec<_> = followers.into_iter().map(|follower| (follower, Ok(Run::default()))).collect();
    for (place, frame) in frames.enumerate() {
        let frame = frame?;
        ensure!(!signals::is_stopped(), "it was stopped");
        for (follower, run) in &mut runs {
            if let Ok(record) = run
                && let Err(error) = record.add(follower, place, &frame.gray)
            {
                *run = Err(error);
            }
        }
        progress();
    }
    Ok(runs.into_iter().map(|(_, run)| run).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::sequence;
    use crate::{Layout, MethodKind};
    use anyhow::bail;
    use serde_json::Map;
    use smr_core::paper::Config;
    use smr_recordings::{BoundingBox, GrayFrame};
    use std::cell::Cell;
    use std::fs;

    const METHODS: [MethodKind; 2] = [MethodKind::Sad, MethodKind::Paper];

    fn variants() -> [Variant; 2] {
        METHODS.map(|kind| Variant::new(kind, &Config::paper().into()))
    }

    fn evaluated(sequence: Sequence, files: &[PathBuf]) -> Result<Evaluation> {
        let frames = Cell::new(0);
        let evaluation = evaluate(sequence, &variants(), files, || frames.set(frames.get() + 1));
        assert!(evaluation.is_err() || frames.get() == 4);
        evaluation
    }

    #[test]
    fn all_methods_see_all_frames() {
        let evaluation = evaluated(sequence(), &[]).unwrap();
        assert_eq!((evaluation.visible, evaluation.failures.len()), (4, 0));
        let correct = |(who, score): &(Contestant, Score)| (who.clone(), score.correct, score.correct_50);
        let methods = variants().map(|variant| (Contestant::of(&variant), 4, 4));
        assert_eq!(evaluation.scores.iter().map(correct).collect::<Vec<_>>(), methods);
    }

    #[test]
    fn what_is_missing_is_named() {
        let error = |sequence| format!("{:#}", evaluated(sequence, &[]).err().unwrap());
        assert!(error(Sequence { truth: None, ..sequence() }).contains("moving: no ground truth"));
        let short = sequence().truth.map(|truth| truth[..3].to_vec());
        let lengths = "moving: there are 4 frames, but the ground truth has 3 boxes for them: say which";
        assert!(error(Sequence { truth: short, ..sequence() }).starts_with(lengths));
        assert!(error(Sequence { init: None, ..sequence() }).contains("no initial box"));
        let tiny = BoundingBox { x: 1.0, y: 1.0, width: 0.3, height: 5.0 };
        assert!(error(Sequence { init: Some(tiny), ..sequence() }).contains("no pixels: 1,1,0.3,5"));
        let frames = sequence().frames.take(2).chain(std::iter::once_with(|| bail!("frame 3 is bad")));
        assert_eq!(error(Sequence { frames: Box::new(frames), ..sequence() }), "frame 3 is bad");
    }

    #[test]
    fn one_contestant_fails_alone() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("bad.txt");
        fs::write(&file, "1,2,three,4\n").unwrap();
        let evaluation = evaluated(sequence(), &[file]).unwrap();
        assert_eq!(evaluation.scores.len(), METHODS.len());
        assert_eq!(evaluation.failures.len(), 1);
        assert!(format!("{:#}", evaluation.failures[0]).contains("bad.txt: line 1"));

        let mut frames: Vec<_> = sequence().frames.collect();
        frames[2].as_mut().unwrap().gray = GrayFrame { width: 24, height: 19, pixels: vec![0; 24 * 19] };
        let evaluation = evaluated(Sequence { frames: Box::new(frames.into_iter()), ..sequence() }, &[]).unwrap();
        let failures: Vec<String> = evaluation.failures.iter().map(|error| format!("{error:#}")).collect();
        let reason = smr_core::UpdateError::FrameSizeChanged;
        assert_eq!(failures, ["sad", "paper"].map(|name| format!("moving: {name}: frame 3: {reason}")));
    }

    #[test]
    fn result_files_of_others() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(result_files(folder.path()).unwrap(), Vec::<PathBuf>::new());
        let trackers = folder.path().join("trackers");
        fs::create_dir(&trackers).unwrap();
        let (early, late) = (trackers.join("t2.txt"), trackers.join("t10.txt"));
        fs::write(&early, "4,6,9,10\nNaN,NaN,NaN,NaN\n8,6,13,10\n").unwrap();
        fs::write(&late, "4,6,9,10\n6,6,11,10\n8,6,13,10\n0,0,5,4\n0,0,5,4\n").unwrap();
        fs::write(trackers.join("notes.md"), "no result").unwrap();

        let files = result_files(folder.path()).unwrap();
        assert_eq!(files, [early, late]);
        assert_eq!(result_files(&folder.path().join("frames.y4m")).unwrap(), files);
        let evaluation = evaluate(sequence(), &[], &files, || ()).unwrap();
        let figures = |(who, score): &(Contestant, Score)| (who.name.clone(), score.answered, score.correct);
        let expected = [("t2".to_owned(), 2, 2), ("t10".to_owned(), 4, 3)];
        assert_eq!(evaluation.scores.iter().map(figures).collect::<Vec<_>>(), expected);
        assert_eq!(evaluation.notes.len(), 2);
        assert!(evaluation.notes[1].starts_with("5 boxes for 4 frames"));
    }

    fn evaluation(sequence: &str, scores: &[(Contestant, usize)]) -> Evaluation {
        let score = |correct: usize| {
            let mut boxes = vec![None; 4];
            boxes[..correct].fill(Some("1,2,3,4".parse().unwrap()));
            Score::with_confidence(&boxes, &[None; 4], &[Some("1,2,3,4".parse().unwrap()); 4]).unwrap()
        };
        let scores = scores.iter().map(|(who, correct)| (who.clone(), score(*correct))).collect();
        Evaluation { sequence: sequence.to_owned(), visible: 4, scores, failures: vec![], notes: vec![] }
    }

    fn method(name: &str) -> Contestant {
        Contestant { name: name.to_owned(), origin: Some(Origin::new(MethodKind::Paper, Map::new())) }
    }

    #[test]
    fn every_score_in_full_and_the_table_of_the_paper() {
        let expected = "\
tracker  sequence          frames  visible  answered  correct  correct@0.5  precision  recall      F  mean IoU  first failure  OTB AUC  OTB P20  VOT F  threshold
paper    mine                   4        4         4        4            4      1.000   1.000  1.000     1.000              -    0.952    1.000  1.000          -
paper    06_car                 4        4         2        2            2      1.000   0.500  0.667     0.500              3    0.476    0.500  0.667          -
paper    total                  8        8         6        6            6      1.000   0.750  0.857     0.750              -        -        -      -          -
paper    mean of 2                                                              1.000   0.750  0.833     0.750                   0.714    0.750  0.833
paper      standard error                                                       0.000   0.250  0.167     0.250                   0.238    0.250  0.167
sad      mine                   4        4         1        1            1      1.000   0.250  0.400     0.250              2    0.238    0.250  0.400          -
sad      06_car                 4        4         0        0            0      0.000   0.000  0.000     0.000              1    0.000    0.000  0.000          -
sad      total                  8        8         1        1            1      1.000   0.125  0.222     0.125              -        -        -      -          -
sad      mean of 2                                                              0.500   0.125  0.200     0.125                   0.119    0.125  0.200
sad        standard error                                                       0.500   0.125  0.200     0.125                   0.119    0.125  0.200
paper    06_car                 4        4         1        1            1      1.000   0.250  0.400     0.250              2    0.238    0.250  0.400          -
t2       06_car                 4        4         2        2            2      1.000   0.500  0.667     0.500              3    0.476    0.500  0.667          -
t10      mine                   4        4         3        3            3      1.000   0.750  0.857     0.750              4    0.714    0.750  0.857          -

correct frames                             source    mine /4  06_car /4
Lim 2004 (incremental subspace)            printed         -        163
Collins 2005 (online feature selection)    printed         -          -
Avidan 2007 (ensemble tracking)            printed         -         10
Babenko 2009 (MIL)                         printed         -         45
Kalal 2010 (forward-backward, MedianFlow)  printed         -        510
SMR, the paper                             printed         -        510
paper                                      measured        4          2
sad                                        measured        1          0
paper                                      measured        -          1
t2                                         measured        -          2
t10                                        measured        3          -
";
        let (paper, sad) = (method("paper"), method("sad"));
        let file = |name: &str| Contestant::file(name.to_owned());
        let both = [
            evaluation("mine", &[(paper.clone(), 4), (sad.clone(), 1), (file("t10"), 3)]),
            evaluation("06_car", &[(paper, 2), (sad, 0), (file("t2"), 2), (file("paper"), 1)]),
        ];
        assert_eq!(Evaluation::tables(&both).text(Layout::Text), expected);
        let other = Evaluation::tables(&[evaluation("mine", &[(method("paper"), 4)])]).text(Layout::Text);
        assert!(
            other.ends_with("\n\ncorrect frames  source    mine /4\npaper           measured        4\n"),
            "{other}"
        );
        assert_eq!(Evaluation::tables(&[]).text(Layout::Text), "");
    }

    #[test]
    fn a_target_that_is_never_visible_enters_no_mean() {
        let unseen = |name: &str| {
            let score = Score::with_confidence(&[Some("1,2,3,4".parse().unwrap())], &[None], &[None]).unwrap();
            Evaluation { scores: vec![(method("paper"), score)], visible: 0, ..evaluation(name, &[]) }
        };
        let seen = |name: &str, correct| evaluation(name, &[(method("paper"), correct)]);
        let means = |all: &[Evaluation]| serde_json::to_value(Evaluation::tables(all)).unwrap()["means"].clone();
        let (alone, both) = (means(&[seen("a", 4), seen("b", 2)]), means(&[seen("a", 4), seen("b", 2), unseen("c")]));
        assert_eq!((&alone, &both[0]["recall"]), (&both, &0.75.into()));
        let one = &means(&[unseen("c"), seen("a", 4)])[0];
        assert_eq!((&one["recall"], &one["recordings"]), (&1.0.into(), &1.into()));
        assert!(one["recall_standard_error"].is_null() && means(&[unseen("c"), unseen("d")])[0]["recall"].is_null());
        let text = Evaluation::tables(&[unseen("c")]).text(Layout::Text);
        let row = text.lines().nth(1).unwrap();
        assert!(row.ends_with("1        0            0          -       -  -         -              -        -        -      -          -"), "{row}");
    }
}
