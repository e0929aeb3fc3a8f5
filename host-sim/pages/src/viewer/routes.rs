//! HTTP routes of the viewer: the page, its modules, frames, news, and the user's requests.

use super::answers::{AnsweredFrame, Changes, Followed};
use super::model::{Length, Lock, Target, TargetSpan, check_inside};
use super::ordered_files::{Job, Made};
use super::server::{Reply, Request, Server};
use super::session::Session;
use super::source::{Known, Source};
use super::spans::Spans;
use super::truth_recording::Recordings;
use crate::export::boxes::{Format, rounded};
use crate::{encode, front_end};
use anyhow::{Context, Result, bail, ensure};
use clap::ValueEnum;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};
use smr_evaluation::{MethodAnswer, Variant, name_of};
use smr_files::messages::{self, choice_name};
use smr_files::output::complain;
use smr_recordings::annotations::{self, Labelled};
use smr_recordings::{BoundingBox, FrameNumber};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

/// Longest time that a poll for news waits for a change.
const PATIENCE: Duration = Duration::from_secs(15);
/// Delay before a reply with news, so that the reply covers several frames.
const GATHERING: Duration = Duration::from_millis(40);

/// Handlers of those page requests that depend on the options of the command line.
pub trait Requests: Send + Sync {
    fn variant(&self, method: &str, options: &Map<String, Value>) -> Result<Variant>;

    /// Returns the name and the content of a file with the boxes of all targets.
    fn boxes(&self, viewer: &Viewer, format: &str) -> Result<(String, Vec<u8>)>;

    /// Returns the command line that writes a video with boxes (`mp4`, ...) that has this look, or the report (`html`).
    fn made(&self, viewer: &Viewer, ending: &str, look: Look) -> Result<Job>;

    fn firmware(&self, variant: &Variant) -> String;
}

/// The look of a video.
#[derive(Default)]
pub struct Look {
    /// The marks of `--draw`.
    pub draw: Option<String>,
    /// The id of the target that the video is cropped to.
    pub crop: Option<u32>,
}

pub struct Viewer {
    pub name: String,
    pub size: (u16, u16),
    /// Command-line arguments that name the source and its options.
    pub words: String,
    pub films: Vec<&'static str>,
    /// Folder in which recordings with truth are written.
    pub place: PathBuf,
    pub source: Arc<dyn Source>,
    pub followed: Arc<Followed>,
    pub made: Arc<Made>,
    pub requests: Box<dyn Requests>,
    pub session: Session,
    /// Program and options of the source, on which the answers depend beside the method.
    pub made_by: String,
}

impl Viewer {
    /// Runs the trackers and serves the page until the program ends.
    pub fn serve(self, server: Server) -> Result<()> {
        self.start();
        server.run(move |request| self.answer(&request))
    }

    /// Starts the thread of the trackers, and one that tells the page how many frames the source knows.
    pub(super) fn start(&self) {
        let (source, followed) = (Arc::clone(&self.source), Arc::clone(&self.followed));
        thread::spawn(move || followed.run(source.as_ref()));
        let (source, followed) = (Arc::clone(&self.source), Arc::clone(&self.followed));
        let name = self.name.clone();
        thread::spawn(move || {
            let mut told = Known::default();
            loop {
                thread::sleep(Duration::from_millis(250));
                let known = source.known();
                if known != told || source.live().is_some() {
                    followed.learns(known.frames.filter(|_| source.live().is_none()));
                    told = known;
                }
                if source.live().is_none()
                    && let Some(line) = followed.beyond(told.frames)
                {
                    complain(&format!("warning: {name}: {line}"));
                    followed.tell(|log| log.say(line));
                }
            }
        });
    }

    pub(super) fn answer(&self, request: &Request) -> Reply {
        self.routed(request).unwrap_or_else(|error| Reply::error(400, &messages::of(&error)))
    }

    fn routed(&self, Request { posts, path, query, revision, body }: &Request) -> Result<Reply> {
        let (first, rest) = path.split_once('/').unwrap_or((path, ""));
        Ok(match (posts, first, rest) {
            (false, "", "") => page(""),
            (false, "page", name) => module(name),
            (false, "source", "") => json_reply(&self.source_json()),
            (false, "news", "") => json_reply(&self.news(query)?),
            (false, "answers", "") => {
                let (target, from, to) =
                    (number(query, "target")?, frame_number(query, "from")?, frame_number(query, "to")?);
                let (rows, to) = self.followed.part(TargetSpan { target, from, to });
                let rows: Vec<_> = rows.into_iter().map(|(frame, row)| answer_json(&(target, frame, row))).collect();
                json_reply(&json!({ "rows": rows, "to": to }))
            }
            (false, "frames", name) if name.ends_with(".png") => self.part(name, query)?,
            (false, "frames", name) => self.image(name),
            (false, "boxes", "") => {
                let format = value(query, "format").context("expected ?format=")?;
                saved(self.requests.boxes(self, format)?)
            }
            (false, "made", id) => saved(self.made.file(id.parse().context("expected a number")?)?),
            (false, "firmware", "") => {
                Reply::new("text/plain; charset=utf-8", self.requests.firmware(&self.followed.variant()))
            }
            (true, "targets", "") => {
                let targets: Vec<Target> = serde_json::from_slice(body).context("expected a list of targets")?;
                let (former, before) = self.followed.revision();
                let is_new = |(_, lock): &(&str, &Lock)| !former.iter().any(|target| target.locks.contains(lock));
                check_inside(targets.iter().flat_map(Target::named_locks).filter(is_new), self.size)?;
                let made = self.followed.set_targets(targets, *revision, self.source.as_ref())?;
                if made != before {
                    self.keep();
                }
                json_reply(&revision.map_or(json!({}), |_| json!({ "revision": made })))
            }
            (true, "boxes", "") => {
                let name = value(query, "name").map_or("these boxes".to_owned(), decoded);
                let of = Labelled { name: &self.name, size: self.size, frames: self.known().frames };
                let targets = annotations::parse(body, &of).and_then(Target::numbered).context(name)?;
                json_reply(&json!({ "targets": targets }))
            }
            (true, "method", "") => {
                let (method, options): (String, Option<Map<_, _>>) = (field(body, "method")?, field(body, "options")?);
                self.followed.set_variant(self.requests.variant(&method, &options.unwrap_or_default())?);
                self.keep();
                json_reply(&json!({}))
            }
            (true, "length", "") => {
                self.set_length(serde_json::from_slice(body).context("expected null, or { pixels_per_metre, line }")?)?;
                json_reply(&json!({}))
            }
            (true, "place", "") => {
                self.log_message(self.session.shows(field::<FrameNumber>(body, "frame")?.get()));
                json_reply(&json!({}))
            }
            (true, "film", "") => {
                let ending: String = field(body, "as")?;
                if !self.films.contains(&&*ending) {
                    bail!("no video can be made as {ending:?}: expected one of {}", self.films.join(", "));
                }
                self.make(&ending, Look { draw: field(body, "draw")?, crop: field(body, "crop")? })?
            }
            (true, "report", "") => self.make("html", Look::default())?,
            (true, "recording", "") => self.write_recording()?,
            (true, "checked", "") => {
                let frames: Spans = field(body, "frames")?;
                if let Some((last, all)) = frames.last_to(usize::MAX).zip(self.known().frames) {
                    ensure!(last <= all, "there is no frame {last}: expected 1 to {all}");
                }
                self.followed.checks(field(body, "target")?, frames)?;
                self.keep();
                json_reply(&json!({}))
            }
            (true, "cancel", "") => {
                self.made.cancel(field(body, "id")?)?;
                json_reply(&json!({}))
            }
            (true, "stop", "") => {
                self.source.stop();
                self.followed.stop();
                json_reply(&json!({}))
            }
            _ => Reply::error(404, "there is nothing here"),
        })
    }

    fn keep(&self) {
        let (variant, targets) = (self.followed.variant(), self.followed.targets());
        self.session.ids(&targets);
        self.log_message(self.session.keep(|work| {
            (work.method, work.options, work.targets) = (variant.kind.name().to_owned(), variant.options, targets);
            work.made_by.clone_from(&self.made_by);
        }));
    }

    /// Errors: An end of the line is outside the frame.
    fn set_length(&self, length: Option<Length>) -> Result<()> {
        let (width, height) = self.size;
        if let Some([x1, y1, x2, y2]) = length.as_ref().and_then(|length| length.line) {
            ensure!(
                x1.max(x2) <= width && y1.max(y2) <= height,
                "the line {x1},{y1},{x2},{y2} is not wholly inside {width}x{height} pixels"
            );
        }
        self.session.set_length(length);
        self.keep();
        // Other pages poll at once.
        self.followed.tell(|log| _ = log.next());
        Ok(())
    }

    fn log_message(&self, line: Option<String>) {
        line.into_iter().for_each(|line| self.followed.tell(|log| log.say(line)));
    }

    pub fn known(&self) -> Known {
        self.followed.known(self.source.as_ref())
    }

    /// Returns the command-line arguments for the source, limited to the frames before damaged data.
    fn words(&self) -> String {
        self.words.clone() + &self.followed.last_intact().map_or(String::new(), |last| format!(" --frames ..{last}"))
    }

    fn source_json(&self) -> Value {
        let Known { frames, times } = self.known();
        let variant = self.followed.variant();
        let (targets, revision) = self.followed.revision();
        let offer = |format: &Format| json!({ "name": choice_name(format), "several": format.has_names() });
        let origin = serde_json::to_value(variant.origin()).unwrap_or_default();
        let ids = self.session.ids(&targets);
        json!({
            "name": self.name,
            "live": self.source.live().is_some(),
            "rate": self.source.live().map(|live| live.rate),
            "width": self.size.0,
            "height": self.size.1,
            "frames": frames,
            "times": (!times.is_empty()).then_some(times),
            "version": env!("CARGO_PKG_VERSION"),
            "methods": ["robust", "paper"],
            "method": variant.kind.name(),
            "options": origin["options"],
            "words": self.words(),
            "targets": targets,
            "revision": revision,
            "ids": ids,
            "formats": Format::value_variants().iter().map(offer).collect::<Value>(),
            "films": self.films,
            "session": self.session.name(),
            "frame": self.session.frame(),
            "length": self.session.length(),
        })
    }

    /// Returns the changes after log position `since`. If there are many answers, it returns only their frame ranges,
    /// and the page requests the answers from the route `answers`. With `wait=0` it returns at once.
    fn news(&self, query: &str) -> Result<Value> {
        let since = number(query, "since")?;
        let patience = match value(query, "wait") {
            None => PATIENCE,
            Some("0") => Duration::ZERO,
            Some(other) => bail!("wait={other}: expected 0"),
        };
        let mut heard = self.followed.wait_for_changes(since, patience);
        if !patience.is_zero() && heard.position > since && heard.rows.len() < 100 {
            thread::sleep(GATHERING);
            heard = self.followed.wait_for_changes(since, Duration::ZERO);
        }
        let Changes { position, void, changed, rows, messages, made, frames, targets } = heard;
        let (followed, at) = self.followed.reached(self.source.known().frames);
        // JavaScript has no exact integers beyond 2^53.
        let told = |part: &TargetSpan| json!([part.target, part.from, part.to.min(FrameNumber::MAX)]);
        let mut news = json!({
            "position": position,
            "rows": rows.iter().map(answer_json).collect::<Vec<_>>(),
            "changed": changed.iter().map(told).collect::<Vec<_>>(),
            "followed": followed,
            "silent": self.followed.silent(),
            "session": self.session.name(),
            "length": self.session.length(),
            "progress": at.map(|(frame, rate)| json!({ "frame": frame, "rate": rate })),
        });
        if !void.is_empty() {
            news["clear"] = void.iter().map(told).collect();
        }
        if let Some((targets, revision)) = &targets {
            (news["targets"], news["revision"]) = (json!(targets), json!(revision));
            news["ids"] = json!(self.session.ids(targets));
        }
        if frames || targets.is_some() {
            news["words"] = json!(self.words());
        }
        if frames {
            let Known { frames, times } = self.known();
            news["frames"] = json!(frames);
            if self.source.live().is_none() {
                news["times"] = json!((!times.is_empty()).then_some(times));
            }
            news["live"] = json!(self.source.live());
        }
        if !messages.is_empty() {
            news["said"] = json!(messages.join(" / "));
        }
        if !made.is_empty() {
            news["exports"] = made.iter().filter_map(|&id| self.made.of(id)).map(|one| json!(one)).collect();
        }
        Ok(news)
    }

    fn image(&self, name: &str) -> Reply {
        let number = self.frame(name, ".jpg");
        if let Some(image) = number.and_then(|number| self.source.image(number)) {
            return Reply::new("image/jpeg", image.to_vec());
        }
        let is_recording = self.source.live().is_none();
        let error =
            number.filter(|_| is_recording).and_then(|number| self.source.gray_from(number).ok()?.next()?.err());
        let said =
            error.map_or("there is no such frame, or it is not kept any more".to_owned(), |error| messages::of(&error));
        Reply::error(404, &said)
    }

    /// Parses the name of an image, such as `7.jpg`; `None` if the source has no such frame.
    fn frame(&self, name: &str, ending: &str) -> Option<usize> {
        let number: FrameNumber = name.strip_suffix(ending)?.parse().ok()?;
        let is_there = |number: &usize| self.known().frames.is_none_or(|frames| *number <= frames);
        Some(number.get()).filter(is_there)
    }

    fn part(&self, name: &str, query: &str) -> Result<Reply> {
        let numbers = value(query, "part").and_then(|part| part.split(',').map(|number| number.parse().ok()).collect());
        let part = numbers.and_then(|numbers: Vec<i32>| numbers.try_into().ok()).context("expected ?part=X,Y,W,H")?;
        let Some(color) = self.frame(name, ".png").and_then(|number| self.source.color(number)) else {
            return Ok(Reply::error(404, "there is no such frame, or only its picture is kept"));
        };
        let bytes = encode::part_png(&color, part)?;
        Ok(Reply::new("image/png", bytes.context("this part lies outside the frame: expected one inside")?))
    }

    /// Writes the parts of the recording in which the truth is known.
    fn write_recording(&self) -> Result<Reply> {
        ensure!(
            self.source.live().is_none(),
            "the frames of a camera are not kept: record it with ffmpeg, and view the file"
        );
        let frames = self.known().frames.context("the recording is still being counted: wait a moment")?;
        let (reached, _) = self.followed.reached(Some(frames));
        if let Some(last) = self.followed.awaited(frames) {
            bail!("still following, at frame {reached} of {frames}: wait until frame {last} is followed, too");
        }
        let known = |(target, rows): (Target, Vec<_>)| {
            let parts = target.known_parts(&rows, frames, self.size);
            parts.into_iter().map(|part| (target.clone(), part)).collect::<Vec<_>>()
        };
        let parts: Vec<_> = self.followed.rows().into_iter().flat_map(known).collect();
        ensure!(
            !parts.is_empty(),
            "nothing is checked yet from a box inside the frame on: play the recording, and correct the box where it is wrong"
        );
        let name = format!("{} with truth", self.name);
        let recordings = Recordings { name: plain(&self.name), method: self.followed.variant().kind.name(), parts };
        let (place, source, followed) = (self.place.clone(), Arc::clone(&self.source), Arc::clone(&self.followed));
        let write = move |progress: &dyn Fn(f64) -> bool| recordings.write(&place, source.as_ref(), progress);
        let id = self.made.write(name, write, move |id| followed.tell(|log| log.log_progress(id)))?;
        Ok(json_reply(&json!(self.made.of(id))))
    }

    fn make(&self, ending: &str, look: Look) -> Result<Reply> {
        let job = self.requests.made(self, ending, look)?;
        let [followed, told] = [(); 2].map(|()| Arc::clone(&self.followed));
        let say = move |note| told.tell(|log| log.say(note));
        let id = self.made.begin(job, move |id| followed.tell(|log| log.log_progress(id)), say)?;
        Ok(json_reply(&json!(self.made.of(id))))
    }
}

/// Returns the page, with `lead` above its heading.
pub(super) fn page(lead: &str) -> Reply {
    let script = "<script type=\"module\" src=\"page/viewer.js\"></script>";
    let page = front_end::viewer(script).replacen("<header>", &format!("{lead}<header>"), 1);
    Reply::new("text/html; charset=utf-8", page)
}

/// Returns a module of the page.
pub(super) fn module(name: &str) -> Reply {
    match front_end::module(name) {
        Some(text) => Reply::new("text/javascript; charset=utf-8", text),
        None => Reply::error(404, "there is no such module"),
    }
}

/// Returns the name of a source as one that is valid on every system.
pub fn plain(name: &str) -> String {
    let plain = |letter: char| if letter.is_ascii_alphanumeric() || "-_".contains(letter) { letter } else { '_' };
    name.trim_start_matches('-').chars().map(plain).take(80).collect()
}

fn json_reply(value: &Value) -> Reply {
    Reply::new("application/json", value.to_string())
}

fn saved((name, bytes): (String, Vec<u8>)) -> Reply {
    Reply { file: Some(name), ..Reply::new("application/octet-stream", bytes) }
}

fn field<T: DeserializeOwned>(body: &[u8], name: &str) -> Result<T> {
    let object: Value = serde_json::from_slice(body).unwrap_or_default();
    let value = object.get(name).cloned().unwrap_or_default();
    serde_json::from_value(value).with_context(|| format!("expected {{ {name} }}"))
}

/// Returns the value of `name` in a query such as `a=1&b=2`.
fn value<'a>(query: &'a str, name: &str) -> Option<&'a str> {
    query.split('&').find_map(|pair| pair.strip_prefix(name)?.strip_prefix('='))
}

fn decoded(text: &str) -> String {
    let mut parts = text.split('%');
    let mut bytes = parts.next().unwrap_or_default().as_bytes().to_vec();
    for part in parts {
        let byte = part.get(..2).and_then(|digits| u8::from_str_radix(digits, 16).ok());
        bytes.push(byte.unwrap_or(b'%'));
        bytes.extend(&part.as_bytes()[if byte.is_some() { 2 } else { 0 }..]);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

fn number<T: FromStr>(query: &str, name: &str) -> Result<T> {
    let text = value(query, name).with_context(|| format!("expected ?{name}=NUMBER"))?;
    text.parse().ok().with_context(|| format!("{name}={text}: expected a number"))
}

fn frame_number(query: &str, name: &str) -> Result<usize> {
    number(query, name).map(FrameNumber::get)
}

/// Returns an answer as JSON for the page:
/// `[target, frame, state, x, y, width, height, confidence, alpha, ratio, scale, work, runner-up's ratio, identity]`
fn answer_json(&(target, frame, AnsweredFrame { report, shown, .. }): &(u32, usize, AnsweredFrame)) -> Value {
    let MethodAnswer { state, evidence, work, .. } = report;
    let BoundingBox { x, y, width, height } = shown;
    json!([
        target,
        frame,
        name_of(state),
        x,
        y,
        width,
        height,
        evidence.map(|evidence| rounded(evidence.confidence)),
        evidence.and_then(|evidence| evidence.alpha),
        evidence.map(|evidence| rounded(evidence.ratio)),
        evidence.map(|evidence| rounded(evidence.scale)),
        work,
        evidence.and_then(|evidence| evidence.runner_up_ratio).map(rounded),
        evidence.and_then(|evidence| evidence.identity).map(rounded),
    ])
}

#[cfg(test)]
mod tests;
