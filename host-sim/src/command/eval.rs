//! `host-sim eval`: measures methods and other trackers' results against ground truth. A method starts once or several
//! times in each recording.

use super::progress::Expected;
use super::recording_options::RecordingOptions;
use super::tracker_options::TrackerOptions;
use super::{HostSim, Outcome, progress, tell, told, whole};
use anyhow::{Context, Error, Result, bail, ensure};
use clap::CommandFactory;
use smr_evaluation::choice::{self, Chip, Wanted};
use smr_evaluation::robustness::{self, Former, Starts};
use smr_evaluation::{Layout, Measured, MethodKind, Progress, TableName, Tables, Variant, covers, faults, paper_table};
use smr_files::output::complain;
use smr_files::signals;
use smr_recordings::fault::{Fault, Faults};
use smr_recordings::{SLOW, Sequence};
use std::io::Write;
use std::num::NonZeroU16;
use std::path::{Path, PathBuf};

const NAME: &str = "eval";

#[derive(Debug, clap::Args)]
pub struct Eval {
    /// Recordings with ground truth beside them, or folders of such recordings
    #[arg(value_name = "PATH", required_unless_present = "fault")]
    paths: Vec<PathBuf>,
    /// The methods to measure, separated by commas [default: that of --config, else paper]
    ///
    /// If all recordings are in the paper's table, and no option changes the start or the tracker, the default is every method: both
    /// readings of the paper, the robust tracker, the baselines, and the results of other trackers (--compare).
    #[arg(long, value_enum, value_delimiter = ',')]
    method: Vec<MethodKind>,
    /// Also score other trackers' results, trackers/*.txt beside a recording
    ///
    /// A result file has one line x1,y1,x2,y2 for each frame, with NaN for no answer. Frames after the end of a file have no answer; lines
    /// after the last frame are ignored.
    #[arg(long, conflicts_with_all = ["resize", "frames"])]
    compare: bool,
    /// Run from 5 starts: the given box, 2 pixels to the right, 2 down, and scaled by 0.95 and 1.05 about its centre
    ///
    /// A shifted or scaled box is rounded to whole pixels and cut at the frame's edge. A box is right if its IoU with the
    /// truth is above 0.25. The columns:
    ///
    ///   correct           visible frames with a right box, of all visible frames; mean over the starts
    ///   worst             the same from the worst start
    ///   correct@0.5       the same with an IoU above 0.5
    ///   F                 harmonic mean of precision and correct
    ///   mean IoU          over frames with an answer and a visible target
    ///   precision         right boxes, of all answers, also of those while the target is hidden
    ///   answered/hidden   answers while the target is hidden, of these frames
    ///   found/returns     returns of the target with a right box within 50 frames, of all returns
    ///   wrong/tracking    wrong frames called `tracking`, of all frames called `tracking`
    ///   tracking/wrong    wrong frames called `tracking`, of all wrong frames
    ///   unsaid/right      right boxes not called `tracking`, of all right boxes
    ///   work/frame        comparisons or products of the costliest update
    ///   us/frame          microseconds of an update
    ///
    /// Below the recordings host-sim prints the means over recordings with standard errors, the means of each folder and, for several
    /// methods, paired differences from the first. It keeps one recording in memory at a time, with at most 1 GiB of frames.
    #[arg(long, conflicts_with = "compare", verbatim_doc_comment)]
    robustness: bool,
    /// With --robustness: the starts of each recording. 1: the given box only; every:N: each N-th frame in which the target is visible
    /// [default: 5]
    ///
    /// With every:N a run starts from the true box, cut at the frame's edge, and ends with the recording. No run starts in the last frame.
    #[arg(long, value_name = "1|5|every:N", requires = "robustness")]
    starts: Option<Starts>,
    /// With --robustness: give the trackers only the first frame and each N-th after it, as a camera with a lower frame rate does
    ///
    /// Starts and returns are then counted in the frames that remain.
    #[arg(long, value_name = "N", value_parser = whole::<NonZeroU16>(1..=65535), requires = "robustness", conflicts_with = "fault")]
    every: Option<NonZeroU16>,
    /// With --robustness: print paired differences from earlier results. FILE is the --json output of the same command
    ///
    /// Each tracker is compared with the tracker of the same name in FILE, or else with the first one there. Without this option, host-sim
    /// compares each with the first method.
    #[arg(long, value_name = "FILE", requires = "robustness")]
    against: Option<PathBuf>,
    /// Measure the trackers under faults of the camera, changes of light, a covered lens or a target that goes away; separate several
    /// faults by commas; `all` and `light` are lists [default methods: paper,robust]
    ///
    /// Camera faults: dropped:N (of 2 N frames every second is missing), repeated:N (a frame is repeated N times), torn:N (in N frames the
    /// lower part is from the frame before), black:N and white:N (for N frames), columns:N (N columns are stuck), bits:N (N of 1000 pixels
    /// have a wrong bit), gain:N (pixels times N / 100), noise:N (standard deviation N), origin:N (the picture is shifted N pixels right
    /// and N / 2 down), gap:N (N frames are missing). Faults whose N is not a number of frames last 10 frames.
    ///
    /// Changes of light last 150 frames: light:N (N / 100 of the brightness, with noise of one gray level), dusk:N (the same, reached
    /// within 100 frames), night:N (as light:N, but from the lock on), fog:N (N / 100 of the contrast, around gray 110), gamma:N (gray
    /// levels to the power of N / 100), offset:N (N gray levels brighter).
    ///
    /// away:N: for N frames (40 by default) the target is gone. The frame is filled with the largest strip beside the target's boxes, and
    /// with mirror images of that strip. Then the picture comes back, shifted by at most a quarter of its sides, so that the target is in
    /// another place.
    ///
    /// Each fault is inserted at up to 8 places of a recording, each in a run of its own: the tracker locks on the true box 10 frames
    /// before the fault and is watched for 50 frames after it. Only runs whose box was right (IoU > 0.25) before the fault count. The
    /// tables list the states during the fault, the fractions of its frames with an answer and with a right box, the fraction of runs that
    /// were right again and after how many frames, the fraction that was right at the end, and the fraction of all frames from the fault on
    /// that were wrong in state `tracking`. `none` lists the same runs without a fault. Random numbers are the same in every run.
    ///
    /// `cover` cannot be combined. In the middle of a recording 300 frames are inserted: black, white, gray (128), noise, or a frozen frame
    /// of another scene (the first frame of another recording of the list, resized, or of the built-in `synthetic`). Then the recording
    /// continues. The recordings are the given ones and five generated ones: a dark, a bright, a textured, a smooth and a noisy target. For
    /// each tracker and cover the table lists: recordings; recordings with a right box in the frame before; how many of the 300 frames were
    /// in state `tracking`, in the median and in the worst recording; recordings with more than 2 such frames; recordings *lost* by frame
    /// 30; recordings right again within 10 frames, of those right before. host-sim names each recording that fails one of these.
    #[arg(long, value_name = "NAME:N|away|all|light|cover", value_delimiter = ',', conflicts_with_all = ["compare", "robustness", "init", "inclusive"])]
    fault: Vec<Faults>,
    /// Choose the tracker for this chip: one table, the choice with its reason, and its settings in Rust, C and Python
    ///
    /// The trackers are the paper's with two windows, and the robust one in both sizes, with and without the refiner, and with a smaller
    /// window (`reach`). Each starts 5 times in each recording, as with --robustness, and runs under each fault of --fault [default:
    /// dropped:5,black:3,gain:150,noise:20]. `right` is the fraction of visible frames with a right box (IoU > 0.25): the mean of `clean`
    /// and of the mean over the faults, of which the frames from the fault on count.
    ///
    /// The rule: of the trackers that fit the chip's RAM and reach the frames a second of --fps in 19 of 20 updates, the most accurate one is
    /// the best. The choice is the cheapest of those whose mean difference to the best, recording by recording, is at most its standard
    /// error.
    ///
    /// Cycles are estimates: the work of these runs, times the cycles of a unit of work on the chip's processor. This rate is measured on
    /// the recording `street` in the median and in the most expensive update, and the larger one counts: they differ by less than 8 % for
    /// the robust tracker, and by less than 80 % for the paper's. Memory waits and the camera are not counted. Cycles of RISC-V and Xtensa
    /// are the Cortex-M4's times a ratio of instructions. RAM is that of target, workspace and the most pixels that an update has read.
    #[arg(
        long,
        value_name = "NAME",
        conflicts_with_all = [
            "compare", "robustness", "starts", "every", "against", "init", "inclusive", "method", "config", "set", "backend", "step",
        ],
    )]
    chip: Option<Chip>,
    /// With --chip: the frames a second that the chip must reach [default: 30]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=65535), requires = "chip")]
    fps: Option<u16>,
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
    /// All objects of a table have the same keys, and each key has values of one type or null. A tracker's options are a text, itself JSON.
    #[arg(long)]
    json: bool,
    /// The form of the tables
    #[arg(long, value_enum, default_value_t, conflicts_with = "json")]
    format: Layout,
    /// With --format csv: the table to print [default: measured; with --chip: candidates]
    #[arg(long, value_enum, conflicts_with = "json")]
    part: Option<TableName>,
}

impl TableOptions {
    /// Errors: `--part` is given without CSV, or names a table that is not in `known`.
    fn check(&self, known: &[TableName]) -> Result<()> {
        let Some(part) = self.part else { return Ok(()) };
        ensure!(self.format == Layout::Csv, "--part chooses a table of --format csv: expected both");
        let names = || known.iter().map(|name| name.text()).collect::<Vec<_>>().join(", ");
        let text = part.text();
        ensure!(known.contains(&part), "--part {text}: expected one of {}, or another kind of measurement", names());
        Ok(())
    }

    /// Prints the tables; as CSV the first of `known`, unless `--part` names another one.
    fn print(&self, tables: &Tables, known: &[TableName]) -> Result<()> {
        let text = match self.format {
            Layout::Csv => {
                let part = self.part.or(known.first().copied()).context("there is no table")?;
                tables.csv(part).with_context(|| format!("there is no table {}", part.text()))?
            }
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
    Choice(Wanted, Vec<Fault>),
}

impl Protocol {
    const fn tables(&self) -> &'static [TableName] {
        match self {
            Self::Whole => &[TableName::Measured, TableName::Means, TableName::Printed],
            Self::Robustness(_) => &[TableName::Measured, TableName::Starts, TableName::Means, TableName::Paired],
            Self::Faults(_) => &[TableName::Measured],
            Self::Cover => &[TableName::Measured, TableName::Means],
            Self::Choice(..) => &[TableName::Candidates, TableName::Choice],
        }
    }
}

impl Eval {
    pub fn run(mut self) -> Result<Outcome> {
        let protocol = self.protocol()?;
        let known = protocol.tables();
        self.tables.check(known)?;
        let says_nothing = self.says_nothing();
        if self.method.is_empty() {
            let is_fault = matches!(protocol, Protocol::Faults(_) | Protocol::Cover);
            let method = self.tracker.method().unwrap_or(MethodKind::Paper);
            self.method = if is_fault { faults::METHODS.to_vec() } else { vec![method] };
        }
        let variants = self.tracker.variants(&self.method)?;
        for variant in &variants {
            // An invalid configuration is reported once here, not for each recording.
            variant.build()?;
        }
        let former = self.against.as_deref().map(Former::read).transpose()?;
        let found = self.recording.find(&self.paths)?;

        let bar = progress::bar(NAME, Some(0));
        let generated = if matches!(protocol, Protocol::Cover) { SLOW } else { 0 };
        let expected = Expected::of(&bar, found.len() + generated);
        signals::stop_first();
        let progress = |progress| match progress {
            Progress::Expected { frames, recordings } => expected.add(frames, recordings),
            Progress::Done => bar.inc(),
        };
        let open = |path: &Path| self.recording.open(path);
        let Measured { tables, failures, notes, is_empty } = match protocol {
            Protocol::Choice(wanted, faults) => choice::measure(&found, open, &wanted, &faults, &progress),
            Protocol::Cover => covers::measure(&found, open, &variants, &progress),
            Protocol::Faults(faults) => faults::measure(&found, open, &variants, &faults, &progress),
            Protocol::Robustness(starts) => {
                let open = |path: &Path| {
                    let Some(step) = self.every.map(NonZeroU16::get) else { return open(path) };
                    let thinned = open(path)?.every(step);
                    let length = thinned.truth.as_ref().map_or(2, Vec::len);
                    ensure!(
                        length > 1,
                        "{}: --every {step} leaves only the first frame: expected a smaller step",
                        thinned.name
                    );
                    Ok(thinned)
                };
                robustness::measure(&found, open, &variants, starts, former.as_ref(), &progress)
            }
            Protocol::Whole => {
                let is_papers = says_nothing && found.iter().all(|path| is_published(path));
                let variants = if is_papers { Variant::all() } else { variants };
                let open = |path: &Path| self.open_part(path);
                smr_evaluation::measure(&found, open, &variants, self.compare || is_papers, &progress)
            }
        };
        bar.clear();
        if signals::is_stopped() {
            complain("stopped: the results are those of the recordings that were done");
        }
        let failed = count_failures(failures, is_empty)?;
        notes.iter().for_each(|note| complain(&format!("note: {note}")));
        self.tables.print(&tables?, known)?;
        if let Some(signal) = signals::stopped_by() {
            return Ok(Outcome::Stopped(signal));
        }
        ensure!(failed == 0, "{failed} of the measurements failed: see the errors above");
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
                Faults::Cover if self.chip.is_some() => {
                    bail!("--fault cover does not go with --chip: expected other faults, or away")
                }
                Faults::Cover if self.fault.len() == 1 => return Ok(Protocol::Cover),
                Faults::Cover => bail!("--fault cover is measured alone: expected no other fault"),
            }
        }
        if self.chip.is_some() && all.is_empty() {
            let usual = |name: &str| name.parse().with_context(|| name.to_owned());
            all = choice::FAULTS.split(',').map(usual).collect::<Result<_>>()?;
        }
        if all.is_empty() {
            return Ok(Protocol::Whole);
        }
        ensure!(
            !self.paths.is_empty(),
            "<PATH>... is missing: expected host-sim eval --fault <NAME:N|away|all|light|cover> <PATH>... (`host-sim eval --help` has examples)"
        );
        let first = |(at, fault): (usize, &Fault)| (!all[..at].contains(fault)).then_some(*fault);
        let faults = all.iter().enumerate().filter_map(first).collect();
        Ok(match self.chip {
            Some(chip) => Protocol::Choice(Wanted { chip, fps: self.fps.unwrap_or(choice::FPS) }, faults),
            None => Protocol::Faults(faults),
        })
    }

    /// True if no option selects a method, a setting, the initial box or frames.
    fn says_nothing(&self) -> bool {
        self.method.is_empty() && self.tracker.says_nothing() && self.recording.says_nothing_of_start()
    }

    /// Opens a recording. Adds a given range of frames to its name, so that it does not match the published results,
    /// which are for all frames.
    fn open_part(&self, path: &Path) -> Result<Sequence> {
        let mut sequence = self.recording.open(path)?;
        if let Some(frames) = self.recording.frames() {
            sequence.name = format!("{} {frames}", sequence.name);
        }
        Ok(sequence)
    }
}

/// Prints each failure in a line of standard error, and returns their number. Errors: The only measurement failed.
fn count_failures(mut failures: Vec<Error>, is_all: bool) -> Result<usize> {
    if is_all && failures.len() == 1 {
        return Err(failures.remove(0));
    }
    let command = HostSim::command().find_subcommand(NAME).cloned().unwrap_or_default();
    for error in &failures {
        signals::yield_to_signal();
        complain(&format!("error: {}", told(error, &command)));
    }
    Ok(failures.len())
}

fn is_published(path: &Path) -> bool {
    path.file_name().and_then(|name| name.to_str()).is_some_and(paper_table::is_known)
}
