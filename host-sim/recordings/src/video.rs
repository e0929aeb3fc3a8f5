//! Any video that an `ffmpeg` on the PATH (5.1 or later) decodes: its pictures one after the other, each with its time.
//!
//! All that reads videos does so by [`command`], so that it reads one stream: the one that ffmpeg itself takes if nobody says which, which is
//! that of the most pixels. Gray pixels are those of `ffmpeg -i FILE -pix_fmt gray -fps_mode passthrough -f rawvideo -`. Sizes and times are
//! those that its filter `showinfo` says on standard error.

use super::damage::Damaged;
use super::hdr::{Tones, Transfer};
use super::{ColorFrame, GrayFrame, MOST_PIXELS, has_extension};
use crate::cleanup::Process;
use crate::input::chunks;
use anyhow::{Context, Result, bail, ensure};
use std::ffi::{OsStr, OsString};
use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::path::Path;
use std::process::{ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

/// How long ffmpeg may be silent, unless said otherwise.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// What is looked for in a folder. A file that is named is given to ffmpeg whatever its extension.
const EXTENSIONS: [&str; 22] = [
    "mpg", "mpeg", "mp4", "m4v", "mov", "avi", "mkv", "webm", "wmv", "flv", "ts", "mts", "m2ts", "ogv", "3gp", "m1v",
    "m2v", "h264", "h265", "hevc", "ivf", "mjpeg",
];

pub(super) fn is_video(file: &Path) -> bool {
    has_extension(file, &EXTENSIONS)
}

/// When a frame of a video is shown, and how wide its pixels are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moment {
    /// In units of `base`.
    pub time: i64,
    /// In seconds, as a fraction.
    pub base: (u32, u32),
    /// The width of a pixel over its height.
    pub aspect: (u32, u32),
}

impl Moment {
    pub fn seconds(&self) -> f64 {
        self.time as f64 * f64::from(self.base.0) / f64::from(self.base.1)
    }
}

/// With several threads, what ffmpeg puts in place of damage is different in every run.
const ONE_THREAD: [&str; 2] = ["-threads", "1"];

/// The frames in color, as ffmpeg decodes them; what is wrong with them is said by [`open`]. None if there is no ffmpeg.
pub(super) fn colors(
    file: &Path,
    side: u16,
    patience: Duration,
) -> impl Iterator<Item = (ColorFrame, Option<Moment>)> + use<> {
    good(file, &ONE_THREAD, Use::Color(side), patience).map(Picture::color)
}

/// The pictures of a file until something is wrong.
pub(super) fn good(
    file: &Path,
    options: &[&str],
    wanted: Use,
    patience: Duration,
) -> impl Iterator<Item = Picture> + use<> {
    let mut pictures = Pictures::start(("ffmpeg", file), options, "", wanted, patience).ok();
    std::iter::from_fn(move || pictures.as_mut()?.next().ok()?)
}

/// The frames in gray, each with its time in seconds if it has one, then ffmpeg's verdict.
pub(super) fn open(
    program: &str,
    file: &Path,
    patience: Duration,
) -> Result<impl Iterator<Item = Result<(GrayFrame, Option<f64>)>> + use<>> {
    let name = file.display().to_string();
    let mut pictures = Pictures::start((program, file), &ONE_THREAD, "", Use::Gray, patience)?;
    let mut first = pictures.next().with_context(|| format!("cannot read {name} through ffmpeg"))?;
    if first.is_none() {
        let (status, said) = pictures.ffmpeg.end()?;
        ensure!(!said.last.contains("does not contain any stream"), "{name} holds no pictures: expected a video");
        ensure!(
            said.last.is_empty() && status.success(),
            "ffmpeg cannot decode {name}: {}: expected a whole video, or else pictures, Y4M or a raw dump (--size)",
            said.or(status)
        );
        bail!("{name} holds no frame that ffmpeg decodes");
    }
    let mut number = 0;
    Ok(std::iter::from_fn(move || {
        number += 1;
        match first.take().map_or_else(|| pictures.next(), |first| Ok(Some(first))) {
            Ok(Some(picture)) => Some(Ok(picture.gray())),
            Ok(None) => pictures.verdict().err().map(Err),
            Err(error) => Some(Err(error.context(format!("{name}, frame {number}")))),
        }
    }))
}

/// The use that pictures have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// To be followed in.
    Gray,
    /// To be looked at; no side is longer than this.
    Color(u16),
    /// Only their times count.
    Times,
}

/// Pictures as they come out of an ffmpeg: gray, or red, green and blue.
pub(super) struct Pictures {
    ffmpeg: Ffmpeg,
    pixels: Patient,
    tones: Option<Tones>,
    /// Bytes of a pixel.
    depth: usize,
    times: Continued,
}

pub(super) struct Picture {
    size: (u16, u16),
    moment: Option<Moment>,
    bytes: Vec<u8>,
    /// ffmpeg has complained before.
    pub is_doubtful: bool,
}

impl Picture {
    pub fn seconds(&self) -> Option<f64> {
        self.moment.map(|moment| moment.seconds())
    }

    pub fn gray(self) -> (GrayFrame, Option<f64>) {
        let (time, (width, height)) = (self.seconds(), self.size);
        (GrayFrame { width, height, pixels: self.bytes }, time)
    }

    pub fn color(self) -> (ColorFrame, Option<Moment>) {
        let (width, height) = self.size;
        (ColorFrame { width, height, pixels: self.bytes.as_chunks().0.to_vec() }, self.moment)
    }
}

/// Times begin with the file, not with the first picture, wherever reading begins.
pub(super) const FROM_ZERO: [&str; 2] = ["-copyts", "-start_at_zero"];

/// Seconds from the wanted time within which a seek has found a picture: files in milliseconds round by half of that. This only tells whether
/// the seek has come to the right place; `Index::has` then tests the time of each picture to the microsecond.
const NEAR: f64 = 0.0006;

impl Pictures {
    /// All of a file, with such options of ffmpeg, and filters that come first.
    pub fn start(
        (program, file): (&str, &Path),
        options: &[&str],
        filters: &str,
        wanted: Use,
        patience: Duration,
    ) -> Result<Self> {
        // Frames of another size would be scaled without a word: without a new filter there is at least a warning.
        let options = [&FROM_ZERO, &["-reinit_filter", "0"], options].concat();
        let scale = match wanted {
            Use::Gray => String::new(),
            Use::Color(side) => {
                format!("scale='min({side},iw)':'min({side},ih)':force_original_aspect_ratio=decrease,")
            }
            Use::Times => "scale=1:1:flags=neighbor,".to_owned(),
        };
        // Behind showinfo, times that grow, as what writes them expects.
        let start = |format| {
            let mut command = command(program, "level+info", &input(file), &options);
            let filters = format!("{filters}{scale}format={format},showinfo=checksum=0,setpts=N*1000/TB");
            command.args(["-vf", &filters, "-fps_mode", "passthrough", "-f", "rawvideo", "-"]);
            Ffmpeg::run(&mut command, &file.display().to_string(), patience)
        };
        let is_color = matches!(wanted, Use::Color(_));
        let (mut ffmpeg, mut depth) = if is_color { (start("rgb24")?, 3) } else { (start("gray")?, 1) };
        let tones = if is_color { ffmpeg.transfer.recv_timeout(patience).ok().flatten().map(Tones::of) } else { None };
        if tones.is_some() {
            (ffmpeg, depth) = (start("rgb48le")?, 6);
        }
        Ok(Self { pixels: ffmpeg.output(), ffmpeg, tones, depth, times: Continued::default() })
    }

    /// The picture that is shown at `time`, and all behind it, without decoding all that comes before. `None` if that one is not found.
    pub fn at(file: &Path, time: f64, wanted: Use, patience: Duration) -> Option<(Picture, Self)> {
        let select = format!("select='gte(t,{:.6})',", time - NEAR / 2.0);
        // In some files the place is not where a picture begins: then it begins earlier.
        [0.0001, 10.0].iter().find_map(|before| {
            let seek = format!("{:.6}", (time - before).max(0.0));
            let mut pictures = Self::start(("ffmpeg", file), &["-ss", &seek], &select, wanted, patience).ok()?;
            let first = pictures.next().ok()??;
            first.seconds().is_some_and(|found| (found - time).abs() < NEAR).then_some((first, pictures))
        })
    }

    /// `None` at the end.
    pub fn next(&mut self) -> Result<Option<Picture>> {
        // Said before the pixels are written.
        let shown = match self.ffmpeg.shown.recv_timeout(self.ffmpeg.patience) {
            Ok(shown) => shown,
            Err(RecvTimeoutError::Disconnected) => return Ok(None),
            Err(RecvTimeoutError::Timeout) => return Err(silent(self.ffmpeg.patience).into()),
        };
        let Shown { size: (width, height), moment, is_doubtful } = shown;
        let sides = u16::try_from(width).ok().zip(u16::try_from(height).ok());
        let size = sides.filter(|_| u64::from(width) * u64::from(height) <= MOST_PIXELS);
        let size = size.with_context(|| {
            format!("it is {width}x{height}: expected sides of at most 65535 and at most {MOST_PIXELS} pixels")
        })?;
        let mut bytes = vec![0; usize::from(size.0) * usize::from(size.1) * self.depth];
        match self.pixels.read_exact(&mut bytes) {
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(None),
            other => other?,
        }
        let bytes = self.tones.as_ref().map(|tones| tones.of_all(&bytes)).unwrap_or(bytes);
        let second = |Moment { base: (unit, second), .. }| i64::from(second.div_ceil(unit));
        let moment = moment.map(|moment| Moment { time: self.times.next(moment.time, second(moment)), ..moment });
        Ok(Some(Picture { size, moment, bytes, is_doubtful }))
    }

    /// Errors: ffmpeg has complained.
    pub fn verdict(&mut self) -> Result<()> {
        self.ffmpeg.verdict(self.times.has_gap)
    }
}

/// A jump of more than this many seconds is a new beginning: in MPEG-TS, time that goes back looks like a clock that has run over.
pub(super) const LEAP: u32 = 43_200;

/// Times that do not go back: where a file begins anew (pieces that were joined), they go on from there.
#[derive(Default)]
struct Continued {
    last: Option<i64>,
    /// Between the last two.
    step: i64,
    /// Later than the file says by this.
    shift: i64,
    /// Frames are missing: for a moment, not for so long that another piece begins.
    has_gap: bool,
}

impl Continued {
    /// `second`: in units of the times.
    fn next(&mut self, time: i64, second: i64) -> i64 {
        let mut now = time + self.shift;
        if let Some(last) = self.last {
            // A little too early is a fault of one time.
            if now <= last - self.step || now - last > i64::from(LEAP) * second {
                now = last + self.step;
                self.shift = now - time;
            }
            self.has_gap |= self.step > 0 && 2 * (now - last) > 3 * self.step && now - last < second;
            now = now.max(last);
            self.step = if now > last { now - last } else { self.step };
        }
        self.last = Some(now);
        now
    }
}

/// Reads the output of ffmpeg, as long as it writes.
pub(super) struct Patient {
    chunks: Receiver<io::Result<Vec<u8>>>,
    chunk: Vec<u8>,
    read: usize,
    patience: Duration,
}

impl Patient {
    pub fn new(stream: ChildStdout, patience: Duration) -> Self {
        Self { chunks: chunks(|| Ok(stream)), chunk: Vec::new(), read: 0, patience }
    }
}

impl BufRead for Patient {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.read == self.chunk.len() {
            (self.chunk, self.read) = match self.chunks.recv_timeout(self.patience) {
                Ok(chunk) => (chunk?, 0),
                Err(RecvTimeoutError::Disconnected) => (Vec::new(), 0),
                Err(RecvTimeoutError::Timeout) => return Err(silent(self.patience)),
            };
        }
        Ok(&self.chunk[self.read..])
    }

    fn consume(&mut self, amount: usize) {
        self.read += amount;
    }
}

impl Read for Patient {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.fill_buf()?.read(buffer)?;
        self.consume(length);
        Ok(length)
    }
}

/// The error of an ffmpeg that does nothing.
pub fn silent(patience: Duration) -> io::Error {
    let seconds = patience.as_secs_f64();
    io::Error::new(ErrorKind::TimedOut, format!("ffmpeg has done nothing for {seconds} s (--ffmpeg-timeout)"))
}

pub(super) struct Ffmpeg {
    process: Process,
    /// One for each picture that it gives.
    shown: Receiver<Shown>,
    /// The transfer function of the chosen stream; `None` for ordinary light.
    transfer: Receiver<Option<Transfer>>,
    said: Receiver<Said>,
    file: String,
    patience: Duration,
}

impl Ffmpeg {
    /// `file`: what is read, as it is called in errors.
    pub fn run(command: &mut Command, file: &str, patience: Duration) -> Result<Self> {
        let process = match Process::start(command) {
            Err(error) if error.kind() == ErrorKind::NotFound => bail!(
                "{file} needs ffmpeg to be decoded, and there is none on the PATH: install the package `ffmpeg` (5.1 or later)"
            ),
            other => other.context("cannot start ffmpeg")?,
        };
        let complaints = process.complaints().expect("standard error is piped");
        let ((sender, said), (pictures, shown), (chosen, transfer)) = (channel(), channel(), channel());
        let name = file.to_owned();
        thread::spawn(move || {
            // Everything is read, or ffmpeg would wait.
            let said = Said::read(complaints, &name, |heard| match heard {
                Heard::Shown(one) => drop(pictures.send(one)),
                Heard::Chosen(transfer) => drop(chosen.send(transfer)),
            });
            // The reader learns why no pictures come.
            let _ = sender.send(said);
        });
        Ok(Self { process, shown, transfer, said, file: file.to_owned(), patience })
    }

    pub fn output(&mut self) -> Patient {
        Patient::new(self.process.output().expect("standard output is piped"), self.patience)
    }

    fn end(&mut self) -> Result<(ExitStatus, Said)> {
        let status = self.process.wait_while(|waited| waited <= self.patience).context("cannot wait for ffmpeg")?;
        let Some(status) = status else {
            return Err(silent(self.patience)).with_context(|| format!("cannot read {}", self.file));
        };
        Ok((status, self.said.recv_timeout(self.patience).unwrap_or_default()))
    }

    /// Its last words and its exit status.
    pub fn last_words(&mut self) -> Result<String> {
        self.end().map(|(status, said)| said.or(status))
    }

    /// Its last words, if it has ended and not as it should.
    pub fn failure(&mut self) -> Option<String> {
        let is_ended = self.process.ended().is_ok_and(|status| status.is_some_and(|status| !status.success()));
        is_ended.then(|| self.last_words().ok())?
    }

    /// ffmpeg conceals what is damaged or missing, goes on, and ends without an error code: what it has complained about is
    /// damage, because such pixels are not those of the recording. A packet looks damaged also where pieces were joined: then no frame is missing.
    fn verdict(&mut self, has_gap: bool) -> Result<()> {
        let (status, mut said) = self.end()?;
        if has_gap && said.last.is_empty() {
            said.last = std::mem::take(&mut said.packet);
        }
        let file = &self.file;
        ensure!(
            !said.changed,
            "{file}: the size of its frames or the format of their pixels changes on the way: expected one"
        );
        if said.last.is_empty() && status.success() {
            return Ok(());
        }
        Err(Damaged::new(format!("{file} is damaged, says ffmpeg: {}", said.or(status))).into())
    }
}

/// The file as ffmpeg takes it: without the protocol, a colon in its name is taken for the end of one.
pub fn input(file: &Path) -> OsString {
    let mut input = OsString::from("file:");
    input.push(file);
    input
}

/// An ffmpeg that reads one stream of pictures and nothing else. All that it writes and says is piped.
pub(super) fn command(program: &str, level: &str, input: &OsStr, options: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.args(["-nostdin", "-nostats", "-hide_banner", "-v", level]).args(options).arg("-i").arg(input);
    command.args(["-an", "-sn", "-dn"]);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

#[derive(Debug, PartialEq)]
struct Shown {
    size: (u32, u32),
    moment: Option<Moment>,
    is_doubtful: bool,
}

#[derive(Debug, PartialEq)]
enum Heard {
    Chosen(Option<Transfer>),
    Shown(Shown),
}

#[derive(Debug, Default, PartialEq, Eq)]
struct Said {
    /// The last complaint.
    last: String,
    /// Words about the last packet that looks damaged.
    packet: String,
    /// Frames of another size came, or with pixels of another format.
    changed: bool,
    /// True after ffmpeg's first message with a level; from then on a line without one continues a message.
    has_begun: bool,
    /// The unit of times, in seconds.
    base: Option<(u32, u32)>,
    /// The streams whose light is coded so, as `#0:1`.
    transfers: Vec<(String, Transfer)>,
}

impl Said {
    /// Everything that is said; `hear` gets what is no complaint.
    fn read(stream: impl Read, file: &str, mut hear: impl FnMut(Heard)) -> Self {
        let mut said = Self::default();
        for line in BufReader::new(stream).split(b'\n').map_while(Result::ok) {
            if let Some(heard) = said.add(String::from_utf8_lossy(&line).trim(), file) {
                hear(heard);
            }
        }
        said
    }

    /// A line is `[h264 @ 0x55f520328f40] [error] missing picture`: who (the address is another one in every run), level, words.
    fn add(&mut self, mut line: &str, file: &str) -> Option<Heard> {
        // Some say twice who they are.
        while let Some((speaker, words)) = line.split_once("] ")
            && speaker.starts_with('[')
            && speaker.contains(" @ 0x")
        {
            if let Some(words) = words.strip_prefix("[info] ")
                && speaker.starts_with("[Parsed_showinfo")
            {
                return self.picture(words).map(Heard::Shown);
            }
            line = words;
        }
        if let Some(words) = line.strip_prefix("[info] ") {
            self.has_begun = true;
            return self.stream(words.trim_start()).map(Heard::Chosen);
        }
        let (is_warning, words) = match line.strip_prefix("[warning] ") {
            Some(words) => (true, words),
            None => match ["[error] ", "[fatal] ", "[panic] "].iter().find_map(|level| line.strip_prefix(level)) {
                Some(words) => (false, words),
                // A further line of a message: a title in the file, for example.
                None if self.has_begun => return None,
                None => (false, line),
            },
        };
        self.changed |= words.contains("Changing video frame properties");
        let of_frame = words.contains("corrupt decoded frame");
        let words = words.trim_start_matches(&format!("file:{file}: "));
        // Of the warnings only these are about damage.
        if words.contains("corrupt input packet") {
            words.clone_into(&mut self.packet);
        } else if !words.is_empty() && (!is_warning || of_frame) {
            words.clone_into(&mut self.last);
        }
        None
    }

    /// ` n:   1 pts:    512 pts_time:0.0333333 pos: 5000 fmt:yuv420p sar:1/1 s:640x480 i:P iskey:0 ...`
    fn picture(&mut self, line: &str) -> Option<Shown> {
        self.base = line.split_once("time_base: ").and_then(|(_, base)| fraction(base)).or(self.base);
        let field = |name: &str| line.split_once(name)?.1.split_whitespace().next();
        let (width, height) = field(" s:")?.split_once('x')?;
        let time = field(" pts:").and_then(|time| time.parse().ok());
        let aspect = field(" sar:").and_then(fraction).unwrap_or((1, 1));
        let moment = time.zip(self.base).map(|(time, base)| Moment { time, base, aspect });
        let size = (width.parse().ok()?, height.parse().ok()?);
        Some(Shown { size, moment, is_doubtful: self.changed || !self.packet.is_empty() || !self.last.is_empty() })
    }

    /// `Stream #0:1[0x1e0]: Video: hevc (Main 10), yuv420p10le(tv, bt2020nc/bt2020/smpte2084), ...`, and for the stream that is taken
    /// `Stream #0:1 -> #0:0 (hevc (native) -> rawvideo (native))`.
    fn stream(&mut self, line: &str) -> Option<Option<Transfer>> {
        let line = line.strip_prefix("Stream ")?;
        if let Some((stream, _)) = line.split_once(" -> #0:0") {
            return Some(self.transfers.iter().find(|(of, _)| of == stream).map(|(_, transfer)| *transfer));
        }
        let (file, rest) = line.split_once(':')?;
        let number = rest.split(|letter: char| !letter.is_ascii_digit()).next()?;
        let coded = [("smpte2084", Transfer::Pq), ("arib-std-b67", Transfer::Hlg)];
        if let Some((_, transfer)) = coded.iter().find(|(name, _)| rest.contains(name)) {
            self.transfers.push((format!("{file}:{number}"), *transfer));
        }
        None
    }

    /// The last complaint; without one, what the process ended with.
    fn or(&self, status: ExitStatus) -> String {
        if self.last.is_empty() { status.to_string() } else { self.last.clone() }
    }
}

/// `1/15360` at the beginning of `text`; `None` if a number is 0.
pub(super) fn fraction(text: &str) -> Option<(u32, u32)> {
    let (numerator, rest) = text.split_once('/')?;
    let denominator = rest.split(|letter: char| !letter.is_ascii_digit()).next()?;
    let number = |text: &str| text.parse().ok().filter(|&number: &u32| number > 0);
    number(numerator).zip(number(denominator))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_ffmpeg_is_asked_for() {
        let error = open("no-such-ffmpeg", Path::new("a.mp4"), PATIENCE).err().unwrap();
        assert_eq!(
            format!("{error:#}"),
            "a.mp4 needs ffmpeg to be decoded, and there is none on the PATH: install the package `ffmpeg` (5.1 or later)"
        );
    }

    /// A program in place of ffmpeg.
    #[cfg(unix)]
    fn program(folder: &Path, script: &str) -> String {
        use std::os::unix::fs::PermissionsExt;
        let file = folder.join("ffmpeg");
        std::fs::write(&file, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o755)).unwrap();
        file.to_str().unwrap().to_owned()
    }

    #[cfg(unix)]
    #[test]
    fn a_hanging_ffmpeg_is_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let short = Duration::from_millis(300);
        let frame = "echo '[Parsed_showinfo_1 @ 0x5] [info] n: 0 pts: 0 s:2x1' >&2; printf ab";
        let begin = std::time::Instant::now();
        let silent = "ffmpeg has done nothing for 0.3 s (--ffmpeg-timeout)";

        let never = program(folder.path(), "exec sleep 60");
        let error = format!("{:#}", open(&never, Path::new("a.mp4"), short).err().unwrap());
        assert_eq!(error, format!("cannot read a.mp4 through ffmpeg: {silent}"));
        for then in ["", "exec >&-;"] {
            let stops = program(folder.path(), &format!("{frame}; {then} exec sleep 60"));
            let mut frames = open(&stops, Path::new("a.mp4"), short).unwrap();
            assert!(frames.next().unwrap().is_ok());
            assert_eq!(format!("{:#}", frames.next().unwrap().unwrap_err()), format!("a.mp4, frame 2: {silent}"));
        }
        assert!(begin.elapsed() < Duration::from_secs(30));
    }

    #[test]
    fn of_what_ffmpeg_says_the_last_complaint_is_kept() {
        let said = |text: &str| Said::read(text.as_bytes(), "a.mp4", |_| ());
        let last = |text: &str| said(text).last;
        assert_eq!(
            last("[NULL @ 0x55f5] [error] Invalid NAL\n[mov,mp4 @ 0x7f] [error] partial file\r\n\n"),
            "partial file"
        );
        assert_eq!(last("[error] file:a.mp4: Invalid [data] found"), "Invalid [data] found");
        assert_eq!(last("[swscaler @ 0x55] [swscaler @ 0x55] [warning] deprecated pixel format used"), "");
        assert_eq!(last(""), "");
        let corrupt = "[warning] a.mp4: corrupt decoded frame in stream 0\n";
        assert_eq!(last(corrupt), "a.mp4: corrupt decoded frame in stream 0");
        let changed = "[graph 0 input @ 0x5] [warning] Changing video frame properties on the fly is not supported";
        assert_eq!(said(changed), Said { changed: true, ..Said::default() });
        assert_eq!(
            (last("cannot load a library"), last("[info] title: a\n   : b")),
            ("cannot load a library".into(), "".into())
        );
    }

    #[test]
    fn what_showinfo_says() {
        let heard = |text: &str| {
            let mut heard = Vec::new();
            Said::read(text.as_bytes(), "a.mp4", |one| heard.push(one));
            heard
        };
        let config = "[Parsed_showinfo_1 @ 0x55d] [info] config in time_base: 1/15360, frame_rate: 30/1\n";
        let line = "[Parsed_showinfo_1 @ 0x55d] [info] n:   1 pts:    512 pts_time:0.0333333 pos:     5000 fmt:yuv420p sar:12/11 s:720x576 i:P iskey:0";
        let moment = Moment { time: 512, base: (1, 15360), aspect: (12, 11) };
        let shown = |moment, is_doubtful| vec![Heard::Shown(Shown { size: (720, 576), moment, is_doubtful })];
        assert_eq!(heard(&format!("{config}{line}")), shown(Some(moment), false));
        assert_eq!(heard(&format!("{config}[h264 @ 0x5] [error] lost\n{line}")), shown(Some(moment), true));
        assert_eq!(heard(&line.replace("    512", " NOPTS")), shown(None, false));
        let streams = "[info]   Stream #0:0[0x1]: Video: h264 (High), yuv420p(tv, bt709), 8x8\n\
            [info]   Stream #0:1[0x2](und): Video: hevc (Main 10), yuv420p10le(tv, bt2020nc/bt2020/smpte2084), 8x8\n[info] Stream mapping:\n";
        for (number, transfer) in [(0, None), (1, Some(Transfer::Pq))] {
            let mapping = format!("{streams}[info]   Stream #0:{number} -> #0:0 (hevc (native) -> rawvideo (native))");
            assert_eq!(heard(&mapping), [Heard::Chosen(transfer)]);
        }
        assert_eq!(fraction("1001/30000, frame_rate: 30/1"), Some((1001, 30000)));
        assert_eq!((fraction("0/1"), fraction("1/"), fraction("x")), (None, None, None));
    }

    /// Half of the levels of PQ are 92 cd/m2 (ITU-R BT.2100), of HLG 51.
    #[test]
    fn light_of_more_than_a_screen_has_is_mapped_to_what_it_has() {
        let test = "light_of_more_than_a_screen_has_is_mapped_to_what_it_has";
        if !crate::missing::has_ffmpeg(test) {
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        for (transfer, shown) in [("bt709", 128), ("smpte2084", 153), ("arib-std-b67", 124)] {
            let (file, mut ffmpeg) = (folder.path().join(format!("{transfer}.mkv")), Command::new("ffmpeg"));
            ffmpeg.args(["-nostdin", "-v", "error", "-f", "lavfi", "-i", "color=gray:size=32x16:duration=0.1"]);
            ffmpeg.args(["-c:v", "ffv1", "-pix_fmt", "yuv420p10le", "-color_trc", transfer]);
            ffmpeg.args(["-color_primaries", "bt2020", "-colorspace", "bt2020nc"]);
            assert!(crate::missing::runs(ffmpeg.arg(&file)));
            let (frame, _) = colors(&file, 16, PATIENCE).next().unwrap();
            let apart = frame.pixels[70].map(|level| level.abs_diff(shown)).into_iter().max();
            assert!((frame.width, frame.height) == (16, 8) && apart <= Some(4), "{transfer}: {:?}", frame.pixels[70]);
            assert!(open("ffmpeg", &file, PATIENCE).unwrap().next().unwrap().unwrap().0.pixels[70].abs_diff(128) <= 2);
        }
    }

    #[test]
    fn times_go_on_where_a_file_begins_anew() {
        let mut times = Continued::default();
        let found = [0, 40, 80, 0, 40, 40, 30, 5000, 50_000_000].map(|time| times.next(time, 1000));
        assert_eq!((found, times.has_gap), ([0, 40, 80, 120, 160, 160, 160, 5120, 10_080], false));
        assert_eq!((times.next(50_000_040, 1000), times.next(50_000_120, 1000), times.has_gap), (10_120, 10_200, true));
    }
}
