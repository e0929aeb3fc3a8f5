//! `host-sim eval`: measures methods, and other trackers' results, against ground truth, from one start or several.

use super::progress::Expected;
use super::recording_options::RecordingOptions;
use super::tracker_options::TrackerOptions;
use super::{HostSim, Outcome, progress, tell, told};
use anyhow::{Context, Error, Result, bail, ensure};
use clap::CommandFactory;
use smr_evaluation::robustness::{self, Former, Starts};
use smr_evaluation::{Layout, Measured, MethodKind, Progress, TableName, Tables, Variant, covers, faults, published};
use smr_recordings::fault::{Fault, Faults};
use smr_recordings::output::complain;
use smr_recordings::{Sequence, cleanup, slow};
use std::io::Write;
use std::path::{Path, PathBuf};

const NAME: &str = "eval";

#[derive(Debug, clap::Args)]
pub struct Eval {
    /// Recordings with ground truth beside them, or folders of such recordings
    #[arg(value_name = "PATH", required_unless_present = "fault")]
    paths: Vec<PathBuf>,
    /// The methods to measure; several are separated by commas [default: smr]
    ///
    /// If all recordings are those of the paper's table, and no option changes the start or the tracker, the default is everything:
    /// both readings of the paper, the robust tracker, the baselines, and the results of other trackers (--compare).
    #[arg(long, value_enum, value_delimiter = ',')]
    method: Vec<MethodKind>,
    /// Also score other trackers' results, trackers/*.txt beside a recording
    ///
    /// One line x1,y1,x2,y2 for each frame, NaN for no answer. A file that ends early has no answer from there on; lines after the
    /// last frame are ignored.
    #[arg(long, conflicts_with_all = ["resize", "frames"])]
    compare: bool,
    /// Run from 5 starts: the given box, 2 pixels to the right, 2 down, and scaled by 0.95 and 1.05 about its centre
    ///
    /// A changed box is rounded to whole pixels, and what lies outside the frame is cut off. The columns are:
    /// correct: correct frames over visible ones, mean over the starts; worst: the same from the worst start; correct@0.5: the same
    /// where IoU must be above 0.5; F: the harmonic mean of precision and correct; mean IoU: where there is an answer and the
    /// target is visible; precision: correct answers over all answers, also those while the target is hidden; answered/hidden:
    /// answers while the target is hidden; found/returns: how often the target came back, and how often a correct answer followed
    /// within 50 frames; wrong/tracking and tracking/wrong: frames that were called `tracking` although the target was hidden or IoU
    /// at most 0.25, over all that were called so, and over all wrong frames; unsaid/right: frames that were not called `tracking`
    /// although the box was right; work/frame: comparisons or products of an update, at most; us/frame: its time.
    ///
    /// Then come means over recordings with their standard errors, means over each folder, and of several methods the paired
    /// differences to the first. A recording is held in memory, with at most 1 GiB of frames.
    #[arg(long, conflicts_with = "compare")]
    robustness: bool,
    /// With --robustness: 1 starts from the given box alone, every:N at every N-th frame in which the target is visible [default: 5]
    ///
    /// With every:N each run goes from the box of the ground truth, cut to the frame, to the end of the recording. The last frame is no start.
    #[arg(long, value_name = "1|5|every:N", requires = "robustness")]
    starts: Option<Starts>,
    /// With --robustness: print paired differences to what was measured before: a file that the same command wrote with --json
    ///
    /// Each tracker is compared with the one of its name in the file, or else with the first in the file. Without this option, each
    /// is compared with the first method.
    #[arg(long, value_name = "FILE", requires = "robustness")]
    against: Option<PathBuf>,
    /// Put faults of the camera, or changes of light, into the recordings, or cover the lens, and measure what the trackers do; several faults
    /// are separated by commas, `all` and `light` are lists [default methods: smr,robust]
    ///
    /// NAME:N is one of dropped:N (every second of 2 N frames never comes), repeated:N (the frame before comes N times more), torn:N (the
    /// lower part of N frames is that of the frame before), black:N, white:N (N frames), columns:N (N columns are stuck), bits:N (a bit is
    /// wrong in N of 1000 pixels), gain:N (pixels times N hundredths), noise:N (standard deviation N), origin:N (the picture is N pixels too
    /// far to the right and N / 2 too low), gap:N (no frame comes for N). Those that are not of N frames last 10.
    ///
    /// Changes of light last 150 frames: light:N (N hundredths as bright, with noise of one gray level), dusk:N (the same, reached within
    /// 100 frames), night:N (the same as light:N, but already at the lock), fog:N (N hundredths of the contrast, around gray 110), gamma:N (a
    /// power of N hundredths), offset:N (N gray levels brighter).
    ///
    /// away:N: for N frames (`away`: 40) the camera shows what is beside the target, the largest strip of the frame that is clear of its boxes, and
    /// mirror images of that strip. Then the picture comes shifted by a quarter of its sides at most, so that the target is back elsewhere.
    ///
    /// Each fault is put in at up to 8 places of a recording, each a run of its own: locked on the ground truth 10 frames before it, watched
    /// for 50 frames after it. Of the runs whose box was right (IoU > 0.25) before the fault: the states during it, in how many of its frames
    /// there was an answer and the box was right, how many were right again and after how many frames, how many were right at the end, and in
    /// how many of all frames from the fault on *tracking* was said and wrong. `none` are the same runs without a fault. What is random is the same each time.
    ///
    /// `cover` stands alone. From the middle of a recording on come 300 frames that are black, white, gray (128), noise, or a frozen frame of
    /// another scene: the first frame of another recording of the list, resized (of the built-in `synthetic` if there is no other). Then the
    /// recording goes on where it was interrupted. The recordings are those that are given, and five that are generated: a dark, a bright, a
    /// textured, a smooth and a noisy target. Of each tracker and cover: recordings; those in which the box was right in the frame before; how many
    /// of the 300 frames it called *tracking* in the median and in the worst recording, and in how many recordings more than 2; in how many it was
    /// *lost* by frame 30; in how many of those that were right before it was right again within 10 frames. What misses one of these is named.
    #[arg(long, value_name = "NAME:N|away|all|light|cover", value_delimiter = ',', conflicts_with_all = ["compare", "robustness", "init", "inclusive"])]
    fault: Vec<Faults>,
    #[command(flatten)]
    tables: TableOptions,
    #[command(flatten)]
    recording: RecordingOptions,
    #[command(flatten)]
    tracker: TrackerOptions,
}

/// The form of the tables: words, JSON or CSV.
#[derive(Debug, clap::Args)]
struct TableOptions {
    /// Print JSON instead of tables: an object with the tables of --part, each an array of flat objects
    ///
    /// All objects of a table have the same keys, and a key has values of one type; what is not known is null. The options of a tracker are a
    /// text, itself JSON.
    #[arg(long)]
    json: bool,
    /// The form of the tables
    #[arg(long, value_enum, default_value_t, conflicts_with = "json")]
    format: Layout,
    /// With --format csv: which table of --json [default: measured]
    #[arg(long, value_enum, conflicts_with = "json")]
    part: Option<TableName>,
}

impl TableOptions {
    /// Errors: `--part` is given without CSV, or names a table that is not in `known`.
    fn check(&self, known: &[TableName]) -> Result<()> {
        let Some(part) = self.part else { return Ok(()) };
        ensure!(self.format == Layout::Csv, "--part chooses a table of --format csv: expected both");
        let names = || known.iter().map(|name| name.text()).collect::<Vec<_>>().join(", ");
        ensure!(known.contains(&part), "--part {}: expected one of {}", part.text(), names());
        Ok(())
    }

    fn print(&self, tables: &Tables) -> Result<()> {
        let text = match self.format {
            Layout::Csv => tables.csv(self.part.unwrap_or(TableName::Measured)).context("there is no such table")?,
            layout => tables.text(layout),
        };
        tell(self.json, tables, |_, out| out.write_all(text.as_bytes()))
    }
}

enum Protocol {
    Whole,
    Robustness(Starts),
    Faults(Vec<Fault>),
    Cover,
}

impl Protocol {
    const fn tables(&self) -> &'static [TableName] {
        match self {
            Self::Whole => &[TableName::Measured, TableName::Means, TableName::Printed],
            Self::Robustness(_) => &[TableName::Measured, TableName::Starts, TableName::Means, TableName::Paired],
            Self::Faults(_) => &[TableName::Measured],
            Self::Cover => &[TableName::Measured, TableName::Means],
        }
    }
}

impl Eval {
    pub fn run(mut self) -> Result<Outcome> {
        let protocol = self.protocol()?;
        self.tables.check(protocol.tables())?;
        let says_nothing = self.says_nothing();
        if self.method.is_empty() {
            let is_fault = matches!(protocol, Protocol::Faults(_) | Protocol::Cover);
            self.method = if is_fault { faults::METHODS.to_vec() } else { vec![MethodKind::Smr] };
        }
        let variants = self.tracker.variants(&self.method)?;
        for variant in &variants {
            // An invalid configuration is reported once here, not for each recording.
            variant.build()?;
        }
        let former = self.against.as_deref().map(Former::read).transpose()?;
        let found = self.recording.find(&self.paths)?;

        let bar = progress::bar(NAME, Some(0));
        let generated = if matches!(protocol, Protocol::Cover) { slow::COUNT } else { 0 };
        let expected = Expected::of(&bar, found.len() + generated);
        cleanup::stop_first();
        let progress = |progress| match progress {
            Progress::Expected { frames, recordings } => expected.add(frames, recordings),
            Progress::Done => bar.inc(),
        };
        let open = |path: &Path| self.recording.open(path);
        let Measured { tables, failures, notes, is_empty } = match protocol {
            Protocol::Cover => covers::measure(&found, open, &variants, &progress),
            Protocol::Faults(faults) => faults::measure(&found, open, &variants, &faults, &progress),
            Protocol::Robustness(starts) => {
                robustness::measure(&found, open, &variants, starts, former.as_ref(), &progress)
            }
            Protocol::Whole => {
                // Recordings of the paper get its whole table: all methods, and other trackers' results.
                let is_papers = says_nothing && found.iter().all(|path| is_published(path));
                let variants = if is_papers { Variant::all() } else { variants };
                let open = |path: &Path| self.open_part(path);
                smr_evaluation::measure(&found, open, &variants, self.compare || is_papers, &progress)
            }
        };
        bar.clear();
        if cleanup::is_stopped() {
            complain("stopped: the results are those of the recordings that were done");
        }
        let failed = count_failures(failures, is_empty)?;
        notes.iter().for_each(|note| complain(&format!("note: {note}")));
        self.tables.print(&tables?)?;
        if let Some(signal) = cleanup::stopped_by() {
            return Ok(Outcome::Stopped(signal));
        }
        ensure!(
            failed == 0,
            "{failed} of what was asked for could not be measured (see above); results are of the rest"
        );
        Ok(Outcome::Holds)
    }

    /// Errors: The values of two options exclude each other, which clap cannot check.
    fn protocol(&self) -> Result<Protocol> {
        if self.robustness {
            let starts = self.starts.unwrap_or(Starts::Near);
            ensure!(
                !matches!(starts, Starts::Every(_)) || !self.recording.changes_start(),
                "--starts every:N does not go with --init and --inclusive: expected one of them"
            );
            return Ok(Protocol::Robustness(starts));
        }
        let mut all: Vec<Fault> = Vec::new();
        for faults in &self.fault {
            match faults {
                Faults::List(list) => all.extend(list),
                Faults::Cover if self.fault.len() == 1 => return Ok(Protocol::Cover),
                Faults::Cover => bail!("--fault cover is measured alone: expected no other fault"),
            }
        }
        if all.is_empty() {
            return Ok(Protocol::Whole);
        }
        ensure!(
            !self.paths.is_empty(),
            "<PATH>... is missing: expected host-sim eval --fault <NAME:N|away|all|light|cover> <PATH>... (`host-sim eval --help` has examples)"
        );
        let first = |(at, fault): (usize, &Fault)| (!all[..at].contains(fault)).then_some(*fault);
        Ok(Protocol::Faults(all.iter().enumerate().filter_map(first).collect()))
    }

    /// True if no option selects a method, a setting, the initial box or frames.
    fn says_nothing(&self) -> bool {
        self.method.is_empty() && self.tracker.says_nothing() && self.recording.says_nothing_of_start()
    }

    /// Opens a recording. With `--frames` its name has the range, because published figures are of all frames.
    fn open_part(&self, path: &Path) -> Result<Sequence> {
        let mut sequence = self.recording.open(path)?;
        if let Some(frames) = self.recording.frames() {
            sequence.name = format!("{} {frames}", sequence.name);
        }
        Ok(sequence)
    }
}

/// Prints the failures, one line on standard error for each, and returns their number.
/// Errors: The only measurement failed.
fn count_failures(mut failures: Vec<Error>, is_all: bool) -> Result<usize> {
    if is_all && failures.len() == 1 {
        return Err(failures.remove(0));
    }
    let command = HostSim::command().find_subcommand(NAME).cloned().unwrap_or_default();
    for error in &failures {
        cleanup::yield_to_signal();
        complain(&format!("error: {}", told(error, &command)));
    }
    Ok(failures.len())
}

fn is_published(path: &Path) -> bool {
    path.file_name().and_then(|name| name.to_str()).is_some_and(published::is_known)
}
