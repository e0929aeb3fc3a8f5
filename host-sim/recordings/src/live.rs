//! Frames as they come, from a camera or an address: whoever is too slow gets the newest, and those in between are counted.

use super::color::Now;
use super::video::{self, Ffmpeg};
use super::y4m::{self, Planes};
use super::{Colors, Sequence};
use crate::cleanup::{self, locked};
use anyhow::{Context, Result, bail};
use std::io::{BufRead, BufReader, stdin};
use std::path::Path;
use std::process::Command;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// One that has come.
#[derive(Clone, Debug)]
pub struct LiveFrame {
    /// Counts all that came, also those that nobody took; the first is 1.
    pub number: usize,
    pub arrived: Instant,
    /// Since the first one.
    pub seconds: f64,
    pub planes: Planes,
}

/// A camera, an address or standard input, read by a thread of its own. Dropped, it is closed.
pub struct Live {
    /// The address without what is secret in it.
    pub name: String,
    newest: Arc<Newest>,
    /// `None` of standard input.
    ffmpeg: Option<Ffmpeg>,
    secrets: Vec<String>,
    /// Why it has ended, if that is known.
    pub ended: Option<String>,
}

#[derive(Default)]
struct Newest {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    frame: Option<LiveFrame>,
    came: usize,
    taken: usize,
    first: Option<Instant>,
    is_over: bool,
    reason: Option<String>,
}

/// True of what is read as it comes: an address with `://`, or a camera of Linux.
pub fn is_live(path: &Path) -> bool {
    let text = path.to_string_lossy();
    let is_scheme = |text: &str| !text.is_empty() && text.bytes().all(|letter| letter.is_ascii_alphanumeric());
    is_camera(path) || text.split_once("://").is_some_and(|(scheme, _)| is_scheme(scheme))
}

/// What it is called: nothing secret is in it.
pub(super) fn name(path: &Path) -> String {
    without_secrets(&path.to_string_lossy()).0
}

fn is_camera(path: &Path) -> bool {
    cfg!(target_os = "linux") && ["/dev/video", "/dev/v4l/"].iter().any(|of| path.to_string_lossy().starts_with(of))
}

/// The address without its user, password and query, and these.
fn without_secrets(address: &str) -> (String, Vec<String>) {
    let Some((scheme, rest)) = address.split_once("://") else { return (address.to_owned(), Vec::new()) };
    let (host, path) = rest.split_at(rest.find(['/', '?']).unwrap_or(rest.len()));
    let (user, host) = host.rsplit_once('@').map_or((None, host), |(user, host)| (Some(format!("{user}@")), host));
    let (path, query) = path.find('?').map_or((path, None), |at| (&path[..at], Some(path[at..].to_owned())));
    (format!("{scheme}://{host}{path}"), user.into_iter().chain(query).collect())
}

impl Live {
    /// Begins to read what [`is_live`]; waits for the first frame.
    /// Errors: There is no ffmpeg, or it cannot read there.
    pub fn open(address: &Path, patience: Duration) -> Result<Self> {
        let (name, secrets) = without_secrets(&address.to_string_lossy());
        let mut ffmpeg = Ffmpeg::run(&mut command(address), &name, patience)?;
        let mut stream = ffmpeg.output();
        if stream.fill_buf().with_context(|| format!("cannot read {name} through ffmpeg"))?.is_empty() {
            let reason = without(ffmpeg.last_words()?, &secrets);
            let reason = reason.trim_start_matches(&format!("{name}: "));
            bail!("ffmpeg cannot read {name}: {reason}: expected a camera, or an address that answers");
        }
        let live = Self { newest: Arc::default(), ffmpeg: Some(ffmpeg), secrets, name, ended: None };
        live.read(stream)
    }

    /// Begins to read Y4M from standard input.
    pub fn stdin() -> Result<Self> {
        let name = "standard input".to_owned();
        let live = Self { newest: Arc::default(), ffmpeg: None, secrets: Vec::new(), name, ended: None };
        live.read(BufReader::new(stdin()))
    }

    fn read(self, stream: impl BufRead + Send + 'static) -> Result<Self> {
        let mut frames = y4m::Frames::new(stream, self.name.clone())?;
        let newest = Arc::clone(&self.newest);
        thread::spawn(move || {
            loop {
                match frames.next_planes() {
                    Ok(Some(planes)) => newest.add(planes),
                    Ok(None) => return newest.end(None),
                    Err(error) => return newest.end(Some(error.root_cause().to_string())),
                }
            }
        });
        Ok(self)
    }

    /// How many came that nobody took.
    pub fn dropped(&self) -> usize {
        let state = locked(&self.newest.state);
        state.came - state.taken - usize::from(state.frame.is_some())
    }

    /// The same as a recording that gets what [`Now`] has, and ends without an error.
    pub(super) fn sequence(mut self) -> Sequence {
        let (now, name) = (Now::default(), self.name.clone());
        let at = now.clone();
        let frames = std::iter::from_fn(move || {
            let frame = self.next();
            let gray = frame.as_ref().map(|frame| Ok(frame.planes.gray()));
            at.set(frame, self.dropped(), self.ended.clone());
            gray
        });
        Sequence::streamed(name, frames, Colors::Live(now))
    }
}

/// An ffmpeg that hands frames over as soon as it can: luma over all levels, as of files, and color at half the size.
fn command(address: &Path) -> Command {
    // Of its own accord ffmpeg looks at a stream for five seconds before it begins.
    let options = ["-fflags", "nobuffer", "-flags", "low_delay", "-analyzeduration", "2000000", "-f", "v4l2"];
    let options = if is_camera(address) { &options[..] } else { &options[..6] };
    let mut command = video::command("ffmpeg", "level+warning", address.as_os_str(), options);
    command.args(["-vf", "scale=out_range=full,format=yuv420p", "-fps_mode", "passthrough", "-flush_packets", "1"]);
    command.args(["-f", "yuv4mpegpipe", "-strict", "-1", "-"]);
    command
}

fn without(text: String, secrets: &[String]) -> String {
    secrets.iter().fold(text, |text, secret| text.replace(secret, ""))
}

/// The newest frame that was not taken yet, as soon as there is one. It ends if the source does, or if a signal asks for that
/// ([`cleanup::stop_first`]).
impl Iterator for Live {
    type Item = LiveFrame;

    fn next(&mut self) -> Option<LiveFrame> {
        let newest = Arc::clone(&self.newest);
        let mut state = locked(&newest.state);
        while !cleanup::is_stopped() {
            if let Some(frame) = state.frame.take() {
                state.taken += 1;
                return Some(frame);
            }
            if state.is_over {
                let said = self.ffmpeg.as_mut().and_then(Ffmpeg::failure).or_else(|| state.reason.take());
                self.ended = said.map(|reason| without(reason, &self.secrets)).or(self.ended.take());
                return None;
            }
            let waited = newest.changed.wait_timeout(state, Duration::from_millis(50));
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        None
    }
}

impl Newest {
    fn add(&self, planes: Planes) {
        let arrived = Instant::now();
        let mut state = locked(&self.state);
        state.came += 1;
        // The first one, in which targets are, waits until it is taken.
        if state.taken == 0 && state.frame.is_some() {
            return;
        }
        let seconds = (arrived - *state.first.get_or_insert(arrived)).as_secs_f64();
        state.frame = Some(LiveFrame { number: state.came, arrived, seconds, planes });
        self.changed.notify_all();
    }

    fn end(&self, reason: Option<String>) {
        let mut state = locked(&self.state);
        (state.is_over, state.reason) = (true, reason);
        self.changed.notify_all();
    }
}
