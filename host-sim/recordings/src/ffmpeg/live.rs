//! Live frames of a camera, a network address or standard input. A slow reader gets only the newest frame.

use super::process::{self, Ffmpeg};
use crate::formats::y4m;
use crate::frame::Frame;
use crate::planes::Planes;
use anyhow::{Context, Result, bail};
use smr_files::wait;
use smr_files::{locked, signals};
use std::io::{BufRead, BufReader, stdin};
use std::path::Path;
use std::process::Command;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// A live source (camera, network address or standard input), read by a thread; dropping it closes the source.
pub struct Live {
    /// The address without user, password and query.
    pub name: String,
    pub arrivals: Arc<Arrivals>,
    /// The process that reads the source; `None` for standard input.
    ffmpeg: Option<Ffmpeg>,
    secrets: Vec<String>,
}

/// The newest frame of a live source, and counts of its frames.
#[derive(Debug, Default)]
pub struct Arrivals {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    /// Newest frame: number, time in seconds since the first frame, and pixels.
    newest: Option<(usize, f64, Planes)>,
    came: usize,
    taken: usize,
    first: Option<Instant>,
    is_over: bool,
    reason: Option<String>,
}

/// True for a live source: an address with `://`, or a camera of Linux.
pub fn is_live(path: &Path) -> bool {
    let text = path.to_string_lossy();
    let is_scheme = |text: &str| !text.is_empty() && text.bytes().all(|letter| letter.is_ascii_alphanumeric());
    is_camera(path) || text.split_once("://").is_some_and(|(scheme, _)| is_scheme(scheme))
}

fn is_camera(path: &Path) -> bool {
    cfg!(target_os = "linux") && ["/dev/video", "/dev/v4l/"].iter().any(|of| path.to_string_lossy().starts_with(of))
}

/// Splits an address into its public part, and its secrets: user with password, and query.
pub(crate) fn without_secrets(address: &Path) -> (String, Vec<String>) {
    let address = address.to_string_lossy();
    let Some((scheme, rest)) = address.split_once("://") else { return (address.into_owned(), Vec::new()) };
    let (host, path) = rest.split_at(rest.find(['/', '?']).unwrap_or(rest.len()));
    let (user, host) = host.rsplit_once('@').map_or((None, host), |(user, host)| (Some(format!("{user}@")), host));
    let (path, query) = path.find('?').map_or((path, None), |at| (&path[..at], Some(path[at..].to_owned())));
    (format!("{scheme}://{host}{path}"), user.into_iter().chain(query).collect())
}

impl Live {
    /// Starts to read a live source and waits for its first frame; an error if ffmpeg is missing or cannot read it.
    pub fn open(address: &Path, patience: Duration) -> Result<Self> {
        let (name, secrets) = without_secrets(address);
        let mut ffmpeg = Ffmpeg::run(&mut command(address), &name, patience)?;
        let mut stream = ffmpeg.output();
        if stream.fill_buf().with_context(|| format!("cannot read {name} through ffmpeg"))?.is_empty() {
            let reason = without(ffmpeg.last_words()?, &secrets);
            let reason = reason.trim_start_matches(&format!("{name}: "));
            bail!("ffmpeg cannot read {name}: {reason}: expected a camera, or an address that answers");
        }
        Self { name, arrivals: Arc::default(), ffmpeg: Some(ffmpeg), secrets }.read(stream)
    }

    pub fn stdin() -> Result<Self> {
        let name = "standard input".to_owned();
        Self { name, arrivals: Arc::default(), ffmpeg: None, secrets: Vec::new() }.read(BufReader::new(stdin()))
    }

    fn read(self, stream: impl BufRead + Send + 'static) -> Result<Self> {
        let mut frames = y4m::Frames::new(stream, self.name.clone())?;
        let arrivals = Arc::clone(&self.arrivals);
        thread::spawn(move || {
            let reason = loop {
                match frames.next_planes() {
                    Ok(Some(planes)) => arrivals.add(planes),
                    Ok(None) => break None,
                    Err(error) => break Some(error.root_cause().to_string()),
                }
            };
            let mut state = locked(&arrivals.state);
            (state.is_over, state.reason) = (true, reason);
            arrivals.changed.notify_all();
        });
        Ok(self)
    }
}

/// Builds the low-delay ffmpeg command. Luma is full-range, as for video files; chroma has half its width and height.
fn command(address: &Path) -> Command {
    // Shortens the examination of the stream before the first frame, which by default takes ffmpeg five seconds.
    let mut command = process::command("ffmpeg");
    command.args(["-fflags", "nobuffer", "-flags", "low_delay", "-analyzeduration", "2000000"]);
    if is_camera(address) {
        command.args(["-f", "v4l2"]);
    }
    command.arg("-i").arg(address).args(["-an", "-sn", "-dn"]);
    command.args(["-vf", "scale=out_range=full,format=yuv420p", "-fps_mode", "passthrough", "-flush_packets", "1"]);
    command.args(["-f", "yuv4mpegpipe", "-strict", "-1", "-"]);
    command
}

fn without(text: String, secrets: &[String]) -> String {
    secrets.iter().fold(text, |text, secret| text.replace(secret, ""))
}

/// Waits for a frame newer than the one returned last. Ends when the source ends, or a signal requests a stop.
impl Iterator for Live {
    type Item = Frame;

    fn next(&mut self) -> Option<Frame> {
        let arrivals = Arc::clone(&self.arrivals);
        let mut state = locked(&arrivals.state);
        while !signals::is_stopped() && !wait::has_ended() {
            if let Some((number, seconds, planes)) = state.newest.take() {
                state.taken += 1;
                let frame = Frame::new(number, Some(seconds), planes.gray());
                return Some(Frame { planes: Some(planes), ..frame });
            }
            if state.is_over {
                let said = self.ffmpeg.as_mut().and_then(Ffmpeg::failure).or_else(|| state.reason.take());
                state.reason = said.map(|reason| without(reason, &self.secrets));
                return None;
            }
            let waited = arrivals.changed.wait_timeout(state, Duration::from_millis(50));
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        None
    }
}

impl Arrivals {
    fn add(&self, planes: Planes) {
        let mut state = locked(&self.state);
        state.came += 1;
        // The first frame, in which targets are locked, is kept until it is taken.
        if state.taken == 0 && state.newest.is_some() {
            return;
        }
        let arrived = Instant::now();
        let seconds = (arrived - *state.first.get_or_insert(arrived)).as_secs_f64();
        state.newest = Some((state.came, seconds, planes));
        self.changed.notify_all();
    }

    /// Returns the number of frames that arrived, were not taken, and are no longer available.
    pub fn dropped(&self) -> usize {
        let state = locked(&self.state);
        state.came - state.taken - usize::from(state.newest.is_some())
    }

    /// Returns the reason for the end of the stream, if known.
    pub fn ended(&self) -> Option<String> {
        locked(&self.state).reason.clone()
    }
}
