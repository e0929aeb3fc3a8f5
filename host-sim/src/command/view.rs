//! `host-sim view`: serves a page in the browser, on which boxes are drawn, tracked and corrected.

use super::names::apart;
use super::paths::{Places, several};
use super::session::{typed, variant_of};
use super::tracker_options::{Pair, TrackerOptions};
use super::{Outcome, say, shell, whole};
use anyhow::{Context, Error, Result, bail, ensure};
use clap::ValueEnum;
use serde_json::{Map, Value};
use smr_core::robust::{self, Small, Workspace};
use smr_core::{Rect, Robust, Settings, Shape};
use smr_evaluation::{Configs, MethodKind, RobustSize, Variant, lock};
use smr_files::messages::choice_name;
use smr_files::output::complain;
use smr_pages::export::boxes::{About, Answer, Format, Printer};
use smr_pages::export::{FILM_ENDINGS, PixelsPerMetre};
use smr_pages::viewer::{
    Camera, Followed, Growing, Job, Length, Lock, Look, Made, Requests, Server, Session, Several, Source, Target,
    Viewer, Work, check_inside, plain, session_beside, session_owner,
};
use smr_recordings::annotations::{self, Labelled};
use smr_recordings::{FFMPEG_PATIENCE, Levels, Live, OpenOptions, Start, is_live, is_seekable, name_of};
use std::ffi::OsString;
use std::io::Write;
use std::num::NonZeroU16;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

#[derive(Debug, clap::Args)]
pub struct View {
    /// The recordings, or folders of recordings; or one camera (/dev/video0), address (rtsp://...), or `-` (Y4M from standard input)
    ///
    /// Several recordings have a page each, with links to the others above its heading. A recording is opened when its page is, and has its
    /// own session. The names of the targets in the others are offered. `track` then follows all in one call.
    #[arg(value_name = "SEQ", required = true)]
    sources: Vec<PathBuf>,
    /// The tracker that follows the targets [default: that of --config, else robust]
    #[arg(long, value_enum)]
    method: Option<MethodKind>,
    /// Read the initial boxes from FILE: CSV with column names, as `track` writes it, CVAT XML 1.1, or JSON of Label Studio
    ///
    /// CSV: a box without a confidence is a lock; other boxes are answers, which the tracker computes again. If the file has states, a
    /// target is gone in each frame without a line. CVAT for video: each key frame is a lock, and `outside` means gone. CVAT for images:
    /// each shape is a lock of the target that its label names. A shape is read as its bounding box; shapes with source="auto" are answers.
    /// Label Studio: of several videos, that with the name of SEQ is read; if it has numbered another count of frames (by 24 a second, unless
    /// its configuration says otherwise), each box belongs to the frame at its time. JSON-MIN is not read.
    #[arg(long, value_name = "FILE", conflicts_with = "init")]
    boxes: Option<PathBuf>,
    /// The file that keeps the targets, the method and its options [default: SEQ.smr.json, beside the recording]
    ///
    /// A video alone in its folder has one session, also if SEQ is the folder. `view` creates it at the first change, saves it after each one, and resumes from it. --init and --boxes replace its targets;
    /// --method and tracker options replace its method, and --pixels-per-metre its length; the first change then keeps the old file as FILE~, or FILE~2 if there is a FILE~. A
    /// file that is no session, or that another program has changed meanwhile, stays as it is: `view` then saves to a new file, and says
    /// where. A camera, standard input and a built-in recording have a session only with this option.
    #[arg(long, value_name = "FILE")]
    session: Option<PathBuf>,
    /// Print the address, and do not open a browser
    #[arg(long)]
    no_open: bool,
    /// Print the address as a JSON object
    #[arg(long)]
    json: bool,
    /// The initial boxes, and the frames from which a target is gone (gone@FRAME), as in `track` [default: the box beside the recording]
    #[arg(long, value_name = "[NAME=]X,Y,W,H[@FRAME]", allow_hyphen_values = true)]
    init: Vec<Start>,
    /// The frame size of a raw dump
    #[arg(long, value_name = "WxH")]
    size: Option<Pair>,
    /// Map these values of 16-bit pictures to black and white, for example 7600..8366
    #[arg(long, value_name = "A..B")]
    levels: Option<Levels>,
    /// Stop with an error if ffmpeg reads or writes nothing for this many seconds [default: 60]
    #[arg(long, value_name = "SECONDS", value_parser = whole::<NonZeroU16>(1..=65535))]
    ffmpeg_timeout: Option<NonZeroU16>,
    /// N pixels are a metre, as in `track` [default: of the length that was drawn in the picture]
    #[arg(long, value_name = "N")]
    pixels_per_metre: Option<PixelsPerMetre>,
    #[command(flatten)]
    tracker: TrackerOptions,
}

struct Opened {
    name: String,
    source: Arc<dyn Source>,
    /// File names of the pictures; empty if the recording is not a folder of pictures.
    images: Vec<String>,
    length: Option<usize>,
    /// Count of the frames, which takes longer to find for a video than its first frame: only for a file of boxes.
    counted: Option<usize>,
    beside: Option<Rect>,
}

impl View {
    pub fn run(self) -> Result<Outcome> {
        Places::of(&self.sources).writes("--session", self.session.as_ref(), None).check()?;
        // An invalid option ends the program, not only one of several pages.
        self.variant()?;
        let server = Server::bind()?;
        let (is_json, opens) = (self.json, !self.no_open);
        match several(&self.sources, false)? {
            None => {
                let viewer = self.viewer(&self.sources[0])?;
                show(&server.address(), is_json, opens.then_some(&viewer.made))?;
                viewer.serve(server)?;
            }
            Some(found) => {
                self.check_for_several()?;
                let made = Made::new()?;
                show(&server.address(), is_json, opens.then_some(&made))?;
                let names = apart(found.iter().map(|path| name_of(path)).collect());
                Several::new(found.into_iter().zip(names), move |path| self.viewer(path)).serve(server)?;
            }
        }
        Ok(Outcome::Holds)
    }

    /// Method and options of the command line, `robust` without any.
    fn variant(&self) -> Result<Variant> {
        let method = self.method.or_else(|| self.tracker.method());
        self.tracker.variant(method.unwrap_or(MethodKind::Robust))
    }

    /// Errors: An option is of one recording.
    fn check_for_several(&self) -> Result<()> {
        let of_one = [
            ("--init", !self.init.is_empty()),
            ("--boxes", self.boxes.is_some()),
            ("--session", self.session.is_some()),
        ];
        let given = of_one.into_iter().find(|(_, is_given)| *is_given);
        given.map_or(Ok(()), |(option, _)| bail!("{option} is of one recording: expected one SEQ with it"))
    }

    fn viewer(&self, path: &Path) -> Result<Viewer> {
        let given = self.variant()?;
        let Opened { name, source, images, length, counted, beside } = self.open(path)?;
        let first = source.gray_from(1)?.next().with_context(|| format!("{name} has no frames"))??.gray;
        let size = (first.width, first.height);
        let labelled = Labelled { name: &name, size, frames: counted };
        let targets = self.targets(beside, length, &labelled).with_context(|| name.clone())?;
        let is_live = source.live().is_some();
        let session_file = self.session.clone().or_else(|| session_beside(path));
        let place = session_file.as_deref().and_then(Path::parent).unwrap_or(Path::new("")).to_owned();
        let owner = session_owner(path).filter(|_| self.session.is_none() && !is_live);
        let kept_as = owner.map_or_else(|| name.clone(), |owner| name_of(&owner));
        let (session, work) = Session::open(session_file, &kept_as)?;
        // Name of the file that the targets come from, for error messages.
        let given_by = self.boxes.as_ref().map(|file| file.display().to_string());
        let from = given_by.or_else(|| session.name().filter(|_| work.is_some())).unwrap_or_else(|| name.clone());
        let is_read = self.boxes.is_some() || work.is_some();
        let (variant, targets) = match work {
            Some(work) => self.resumed(work, &session, (given, targets), (&kept_as, is_live))?,
            None => (given, targets),
        };
        if let Some(pixels_per_metre) = self.other_length(session.length().as_ref()) {
            session.set_length(Some(Length { pixels_per_metre, line: None }));
        }
        if !self.init.is_empty() && !is_live {
            // All frames have one size, so the first one shows whether a box will be refused.
            for target in targets.iter().flat_map(|target| &target.locks).filter_map(Lock::rect) {
                lock(variant.build()?.as_mut(), &first.frame(), target).with_context(|| name.clone())?;
            }
        }
        if is_read {
            check_inside(targets.iter().flat_map(Target::named_locks), size).with_context(|| from.clone())?;
        }
        let followed = Arc::new(Followed::new(variant, targets, source.as_ref()).with_context(|| from)?);
        let words = self.words(path);
        Ok(Viewer {
            name,
            size,
            words: shell::line(words.iter().map(OsString::as_os_str)),
            films: if !is_live && has_ffmpeg() { FILM_ENDINGS.to_vec() } else { Vec::new() },
            place,
            source,
            followed,
            made: Arc::new(Made::new()?),
            requests: Box::new(Desk { words, images }),
            session,
            made_by: self.made_by(),
        })
    }

    fn open(&self, path: &Path) -> Result<Opened> {
        let patience = self.ffmpeg_timeout.map(|seconds| Duration::from_secs(seconds.get().into()));
        let is_stdin = path == Path::new("-");
        if is_stdin || is_live(path) {
            let live = if is_stdin { Live::stdin()? } else { Live::open(path, patience.unwrap_or(FFMPEG_PATIENCE))? };
            let name = live.name.clone();
            let (source, images) = (Arc::new(Camera::new(live)), Vec::new());
            return Ok(Opened { name, source, images, length: None, counted: None, beside: None });
        }
        ensure!(
            is_seekable(path) || !path.exists(),
            "{}: it can be read only once: expected a file, a folder or a camera",
            path.display()
        );
        let size = self.size.map(|Pair(width, height)| (width, height));
        let options = OpenOptions { size, levels: self.levels, ffmpeg_patience: patience, ..OpenOptions::default() };
        let (source, sequence) = Growing::open(path, options)?;
        let lengths = sequence.truth.as_ref().map(Vec::len).zip(sequence.length);
        let misfit = lengths.filter(|(boxes, frames)| boxes != frames).map(|(boxes, frames)| {
            format!("there are {frames} frames, but the ground truth has {boxes} boxes: draw the box where it belongs")
        });
        for note in sequence.notes.iter().chain(&misfit) {
            complain(&format!("note: {}: {note}", sequence.name));
        }
        let beside = sequence.init.is_some().then(|| sequence.start()).transpose()?;
        let (images, length) = (sequence.source.image_names(), sequence.length);
        let count = || sequence.source.length(patience.unwrap_or(FFMPEG_PATIENCE));
        let counted = length.or_else(|| self.boxes.as_ref().and_then(|_| count()));
        Ok(Opened { name: sequence.name, source: Arc::new(source), images, length, counted, beside })
    }

    /// Targets of the command line, or else the one from files beside the recording.
    fn targets(&self, beside: Option<Rect>, length: Option<usize>, of: &Labelled<'_>) -> Result<Vec<Target>> {
        let (mut given, option) = match &self.boxes {
            Some(file) => (annotations::read(file, of).with_context(|| file.display().to_string())?, "--boxes"),
            None => (smr_recordings::Target::all(&self.init, 1)?, "--init"),
        };
        smr_recordings::Target::check_frames(&given, 1, length, option)?;
        if given.is_empty() {
            let beside = beside.map(|rect| vec![(1, Some(rect.into()))]);
            given.extend(beside.map(|starts| smr_recordings::Target::new(None, starts)));
        }
        Target::numbered(given)
    }

    /// Resumes the method and targets of a session, except those that the command line gives. If other boxes are to come
    /// than those that the user has looked at, nobody has looked at them.
    fn resumed(
        &self,
        mut work: Work,
        session: &Session,
        (variant, targets): (Variant, Vec<Target>),
        (recording, is_live): (&str, bool),
    ) -> Result<(Variant, Vec<Target>)> {
        let name = session.name().unwrap_or_default();
        // A camera numbers its frames anew, so the boxes of an earlier session belong to other frames.
        let has_targets = !self.init.is_empty() || self.boxes.is_some() || is_live;
        let has_method = self.method.is_some() || !self.tracker.says_nothing();
        let mut note = format!("note: resumes the session {name} of {}", work.recording);
        let replaces_length = work.length.is_some() && self.other_length(work.length.as_ref()).is_some();
        if has_targets || has_method || replaces_length {
            session.leave_aside();
            note += "; options given here replace it";
        }
        if let Some(aside) = session.aside() {
            note += &format!("; the first change keeps the old file as {aside}");
        }
        let kept = variant_of(&work.method, &work.options).with_context(|| name.clone());
        let is_same = work.recording == recording && work.made_by == self.made_by();
        let is_same = is_same && kept.as_ref().is_ok_and(|kept| !has_method || kept.origin() == variant.origin());
        if !has_targets && !is_same && work.forget_checked() {
            note += "; its boxes may differ from those that you have looked at: look at them again";
        }
        complain(&note);
        Ok((if has_method { variant } else { kept? }, if has_targets { targets } else { work.targets }))
    }

    /// Returns the number of `--pixels-per-metre`, unless it is that of the session.
    fn other_length(&self, kept: Option<&Length>) -> Option<PixelsPerMetre> {
        self.pixels_per_metre.filter(|given| kept.is_none_or(|length| length.pixels_per_metre != *given))
    }

    /// Program and options of the source, on which the answers depend beside the method.
    fn made_by(&self) -> String {
        let size = self.size.map_or(String::new(), |size| format!(" --size {size}"));
        let levels = self.levels.map_or(String::new(), |levels| format!(" --levels {levels}"));
        format!("host-sim {}{size}{levels}", env!("CARGO_PKG_VERSION"))
    }

    fn words(&self, path: &Path) -> Vec<OsString> {
        let size = self.size.map(|size| ["--size".into(), size.to_string().into()]);
        let levels = self.levels.map(|levels| ["--levels".into(), levels.to_string().into()]);
        let timeout = self.ffmpeg_timeout.map(|seconds| ["--ffmpeg-timeout".into(), seconds.to_string().into()]);
        let path = shell::file(path).into_os_string();
        std::iter::once(path).chain(size.into_iter().chain(levels).chain(timeout).flatten()).collect()
    }
}

/// Prints the address, and opens a browser with it if `made` has a place for a private file.
fn show(address: &str, is_json: bool, made: Option<&Made>) -> Result<()> {
    say(|out| match is_json {
        true => writeln!(out, "{}", serde_json::json!({ "address": address })),
        false => writeln!(out, "{address}\nCtrl-C ends it."),
    })?;
    let opened = made.map(|made| made.door(address).and_then(|door| Ok(open::that_detached(door)?)));
    if opened.is_some_and(|opened| opened.is_err()) {
        complain("note: no browser could be opened: open the address above yourself");
    }
    Ok(())
}

fn has_ffmpeg() -> bool {
    std::process::Command::new("ffmpeg").arg("-version").output().is_ok()
}

struct Desk {
    words: Vec<OsString>,
    images: Vec<String>,
}

impl Desk {
    /// True if a command without boxes follows these targets by the session, which also has lines and hidden frames.
    fn follows_session(&self, viewer: &Viewer, targets: &[Target]) -> bool {
        let has_more = |target: &Target| !target.hidden.is_empty() || target.locks.iter().any(|lock| lock.by_hand);
        let recording = self.words.first().map(Path::new);
        targets.iter().any(has_more) && recording.is_some_and(|path| viewer.session.holds(targets, path))
    }
}

impl Requests for Desk {
    fn variant(&self, method: &str, options: &Map<String, Value>) -> Result<Variant> {
        variant_of(method, options)
    }

    fn boxes(&self, viewer: &Viewer, format: &str) -> Result<(String, Vec<u8>)> {
        let Ok(format) = Format::from_str(format, true) else {
            let all: Vec<_> = Format::value_variants().iter().map(choice_name).collect();
            bail!("{format:?} is no format of boxes: expected one of {}", all.join(", "));
        };
        let (Viewer { followed, .. }, known, is_live) = (viewer, viewer.known(), viewer.source.live().is_some());
        let targets = followed.rows();
        ensure!(
            targets.len() == 1 || format.has_names(),
            "this format cannot name {} targets: expected csv, json, mot, coco or cvat",
            targets.len()
        );
        let is_named = targets.len() > 1;
        let about = About {
            name: viewer.name.clone(),
            is_one_of_several: false,
            origin: followed.variant().origin(),
            targets: targets.iter().map(|(target, _)| is_named.then(|| target.name.clone())).collect(),
            images: self.images.clone(),
            has_metres: viewer.session.length().is_some(),
            pixels_per_metre: viewer.session.length().map(|length| length.pixels_per_metre.resized((1.0, 1.0))),
        };
        let mut printer = Printer::new(format, about);
        let mut text = printer.head();
        let frames = || targets.iter().flat_map(|(_, rows)| rows).map(|(frame, _)| *frame);
        let first = frames().min().filter(|_| is_live).unwrap_or(1);
        let mut left: Vec<_> = targets.iter().map(|(_, rows)| rows.iter().peekable()).collect();
        let (reached, _) = followed.reached(known.frames);
        // After the last answer, up to frame `reached`, all targets are gone; some formats list such frames, too.
        for frame in first..=frames().max().map_or(0, |last| last.max(reached)) {
            for (target, rows) in left.iter_mut().enumerate() {
                let row = rows.next_if(|(at, _)| *at == frame).map(|(_, row)| row);
                let time = known.times.get(frame - 1).copied().or_else(|| row?.time);
                let report = row.map(|row| targets[target].0.said(frame, row.report, (1.0, 1.0)));
                let quality = row.and_then(|row| row.quality);
                text += &printer.line(&Answer {
                    target,
                    frame,
                    time,
                    size: viewer.size,
                    report: report.as_ref(),
                    quality,
                })?;
            }
        }
        text += &printer.foot()?;
        let ending = format.endings().last().unwrap_or(&"txt");
        // An unfinished result has the number of frames so far in its name.
        let so_far = match known.frames {
            Some(all) if reached >= all || is_live => String::new(),
            Some(all) => format!("-{reached}-of-{all}-frames"),
            None => format!("-{reached}-frames"),
        };
        Ok((file(&viewer.name, &so_far, ending), text.into_bytes()))
    }

    fn made(&self, viewer: &Viewer, ending: &str, look: Look) -> Result<Job> {
        let Viewer { name, source, followed, .. } = viewer;
        let is_kept = source.live().is_none();
        ensure!(is_kept, "the frames of a camera are not kept: record it with ffmpeg, and view the file");
        let targets: Vec<Target> = followed.targets().into_iter().filter(|target| !target.locks.is_empty()).collect();
        ensure!(!targets.is_empty(), "there is no target yet: drag a box first");
        let Variant { kind, options, .. } = followed.variant();
        let is_report = ending == "html";
        let ids = targets.iter().map(|target| target.id.to_string()).collect::<Vec<_>>().join(",");
        let (command, out) = if is_report {
            ("report", vec!["--out"])
        } else {
            ("track", vec!["--ids", &ids, "--format", "csv", "--video"])
        };
        let words = [
            vec![command.into()],
            self.words.clone(),
            followed.last_intact().map_or(Vec::new(), |last| vec!["--frames".into(), format!("..{last}").into()]),
            if self.follows_session(viewer, &targets) { Vec::new() } else { inits(&targets) },
            vec!["--method".into(), kind.name().into()],
            typed(&options),
            shown(&targets, look)?,
            out.iter().map(OsString::from).collect(),
        ]
        .concat();
        let lines = if is_report { 0 } else { followed.rows().iter().map(|(_, rows)| rows.len()).sum() };
        Ok(Job { name: file(name, "", ending), words, lines })
    }

    fn firmware(&self, variant: &Variant) -> String {
        match variant.kind {
            MethodKind::Robust => robust_settings(&variant.configs),
            MethodKind::Paper => paper_settings(&variant.configs.paper),
            _ => "Firmware has the methods robust and paper only.\n".to_owned(),
        }
    }
}

/// Returns a file name, valid on every system, that begins with the name of the source.
fn file(name: &str, so_far: &str, ending: &str) -> String {
    let name = plain(name);
    format!("{}{so_far}.{ending}", if name.is_empty() { "boxes" } else { &name })
}

/// Returns the options of `track` for the look of a video. Errors: the target that it is cropped to has no box.
fn shown(targets: &[Target], Look { draw, crop }: Look) -> Result<Vec<OsString>> {
    let draw = draw.map(|marks| format!("--draw={marks}"));
    let cropped = |id| {
        let target = targets.iter().find(|target| target.id == id);
        let Target { name, .. } = target.context("crop: this target has no box: expected one that has")?;
        Ok::<_, Error>(if targets.len() > 1 { format!("--crop={name}") } else { "--crop".to_owned() })
    };
    Ok(draw.into_iter().chain(crop.map(cropped).transpose()?).map(OsString::from).collect())
}

fn inits(targets: &[Target]) -> Vec<OsString> {
    let init = |target: &Target, Lock { frame, bbox, .. }: &Lock| {
        let name = if targets.len() > 1 { format!("{}=", target.name) } else { String::new() };
        let at = if *frame == 1 { String::new() } else { format!("@{frame}") };
        let place = |(x, y, width, height)| format!("{x},{y},{width},{height}");
        ["--init".into(), format!("{name}{}{at}", bbox.map_or("gone".to_owned(), place)).into()]
    };
    targets.iter().flat_map(|target| target.locks.iter().flat_map(|lock| init(target, lock))).collect()
}

fn robust_settings(configs: &Configs) -> String {
    let config = &configs.robust;
    let mut preset = if config.refiner { "refined()" } else { "robust()" }.to_owned();
    let mut base = if config.refiner { robust::Config::refined() } else { robust::Config::robust() };
    let (mut tracker, mut memory) = ("Robust", [size_of::<Robust>(), size_of::<Workspace>()]);
    if configs.robust_size == RobustSize::Small {
        (preset, base) = (preset + ".within::<Small>()", base.within::<Small>());
        (tracker, memory) = ("Robust<Small>", [size_of::<Robust<Small>>(), size_of::<Workspace<Small>>()]);
    }
    let mut changes = String::new();
    for setting in robust::Config::SETTINGS {
        let value = |of: &robust::Config| of.get(setting.name()).map_or(0, |[value, ..]| value);
        let (value, usual, is_switch) = (value(config), value(&base), setting.shape == Shape::Switch);
        if value != usual {
            let value = if is_switch { (value != 0).to_string() } else { value.to_string() };
            changes += &format!("    config.{} = {value};\n", setting.name());
        }
    }
    format!(
        "Rust (smr-core{}):\n\n    let {}config = robust::Config::{preset};\n{changes}    let tracker = Tracker::<{tracker}>::with(config)?;\n\n\
         It searches {} cells to each side; a cell grows with the target.\n\
         Memory: a target takes {} bytes, and all targets share a workspace of {} bytes (on a 64-bit machine; less on 32 bits).\n",
        if config.refiner { ", feature `refiner`" } else { "" },
        if changes.is_empty() { "" } else { "mut " },
        config.reach,
        memory[0],
        memory[1],
    )
}

fn paper_settings(config: &smr_core::paper::Config) -> String {
    let (x, y) = (config.window.x, config.window.y);
    let limit = config.window_limit.x.max(config.window_limit.y);
    let span = 2 * u32::from(limit) + 1;
    format!(
        "Rust (smr-core):\n\n    let config = paper::Config::camera_within({limit});\n    // for a box of at most 64x64 pixels\n    \
         let tracker = Tracker::<Paper<4096, {span}>>::with(config)?;\n\nThe window reaches {x} pixels to the sides and {y} up and down.\n"
    )
}
