//! The session of a tracker: it introduces itself, is told what to follow, and answers every frame.

use super::message::Message;
use super::{image, region};
use anyhow::{Context, Result, anyhow, bail, ensure};
use smr_evaluation::{Follower, Method, Report};
use smr_recordings::{BoundingBox, GrayFrame, messages};
use std::io::{BufRead, Read, Write};
use std::ops::RangeInclusive;

/// The versions of the protocol. Up to 3 `initialize` holds an image and a region, and there is one object. In 4 it holds a region alone,
/// there may be several, and the image comes with the `frame` that follows.
pub const PROTOCOLS: RangeInclusive<u8> = 1..=4;

/// The most objects that are followed at a time.
const MOST_OBJECTS: usize = 256;

/// The longest line: an image of 8192x8192 pixels, three bytes each, in base 64.
const LONGEST_LINE: u64 = 8192 * 8192 * 4 + 65536;

/// What a client sees of the tracker.
pub struct Server<F> {
    /// What it is called.
    pub name: String,
    /// What it is, in one sentence.
    pub description: String,
    /// The version that it introduces itself with, one of [`PROTOCOLS`].
    pub protocol: u8,
    /// Makes a tracker without a target, one for each object.
    pub build: F,
}

/// Serves one session. It ends when the client says `quit`, or has gone.
/// Errors: The client said what it must not, or what cannot be followed. It has been told so by `quit` with the reason.
pub fn serve<F: Fn() -> Result<Box<dyn Method>>>(
    server: &Server<F>,
    mut input: impl BufRead,
    mut output: impl Write,
) -> Result<()> {
    send(&mut output, &server.hello())?;
    let mut session = Session { server, objects: Vec::new(), new: Vec::new(), frames: 0 };
    loop {
        let answers = match read(&mut input).and_then(|message| session.answer(message)) {
            Ok(Some(answers)) => answers,
            Ok(None) => return Ok(()),
            Err(error) => {
                let quit = Message::new("quit").property("trax.reason", messages::of(&error));
                // That nobody hears it any more is no news.
                let _ = send(&mut output, &quit);
                return Err(error);
            }
        };
        for answer in answers {
            send(&mut output, &answer)?;
        }
    }
}

impl<F> Server<F> {
    fn hello(&self) -> Message {
        let hello = Message::new("hello")
            .property("trax.version", self.protocol.to_string())
            .property("trax.name", &*self.name)
            .property("trax.identifier", concat!("host-sim ", env!("CARGO_PKG_VERSION")))
            .property("trax.description", &*self.description)
            .property("trax.family", "template matching")
            .property("trax.region", "rectangle;polygon;")
            .property("trax.image", "path;memory;buffer;")
            .property("trax.channels", "color;");
        if self.protocol >= 4 { hello.property("trax.multiobject", "1") } else { hello }
    }
}

fn send(output: &mut impl Write, message: &Message) -> Result<()> {
    let sent = output.write_all(message.line().as_bytes()).and_then(|()| output.flush());
    sent.context("cannot write to the client")
}

/// The next message; `None` when the client has gone. Lines that are not of the protocol are passed over.
fn read(input: &mut impl BufRead) -> Result<Option<Message>> {
    loop {
        let mut line = Vec::new();
        input.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line).context("cannot read from the client")?;
        if line.is_empty() {
            return Ok(None);
        }
        let ended = line.ends_with(b"\n");
        ensure!(ended || (line.len() as u64) < LONGEST_LINE, "a line of more than {LONGEST_LINE} bytes");
        let line = String::from_utf8(line).map_err(|_| anyhow!("a line is not UTF-8: expected text"))?;
        if let Some(message) = Message::parse(&line)? {
            return Ok(Some(message));
        }
    }
}

struct Session<'a, F> {
    server: &'a Server<F>,
    objects: Vec<Object>,
    /// Objects that are to be started in the next frame.
    new: Vec<BoundingBox>,
    /// Of this session.
    frames: usize,
}

/// One that is followed, and where it was seen last.
type Object = (Follower, BoundingBox);

impl<F: Fn() -> Result<Box<dyn Method>>> Session<'_, F> {
    /// `None` at the end of the session.
    fn answer(&mut self, message: Option<Message>) -> Result<Option<Vec<Message>>> {
        let Some(Message { name, arguments, .. }) = message else { return Ok(None) };
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let answers = match (name.as_str(), &arguments[..]) {
            ("quit", []) => return Ok(None),
            // Both forms are taken whatever was said in the introduction: the number of arguments tells which one it is.
            ("initialize", [picture, target]) => {
                let target = region::parse(target)?;
                self.reset();
                self.new.push(target);
                self.frame(picture)?
            }
            // So clients of version 4 begin again: what is followed comes in further messages.
            ("initialize", []) => {
                self.reset();
                Vec::new()
            }
            ("initialize", [target]) => {
                let most = if self.server.protocol >= 4 { MOST_OBJECTS } else { 1 };
                let count = self.objects.len() + self.new.len();
                ensure!(count < most, "initialize: there are {count} objects: expected at most {most}");
                self.new.push(region::parse(target)?);
                Vec::new()
            }
            ("frame", [picture]) => self.frame(picture)?,
            ("initialize" | "frame" | "quit", _) => {
                let expected = match name.as_str() {
                    "initialize" => "an image and a region, a region, or none",
                    "frame" => "an image",
                    _ => "none",
                };
                bail!("{name} has {} arguments: expected {expected}", arguments.len())
            }
            _ => bail!("the message {name:?}: expected initialize, frame or quit"),
        };
        Ok(Some(answers))
    }

    fn reset(&mut self) {
        (self.objects, self.new, self.frames) = (Vec::new(), Vec::new(), 0);
    }

    /// Answers of the objects that are followed, then of those that begin in this frame.
    fn frame(&mut self, picture: &str) -> Result<Vec<Message>> {
        ensure!(
            !self.objects.is_empty() || !self.new.is_empty(),
            "frame before initialize: there is nothing to follow"
        );
        self.frames += 1;
        let number = self.frames;
        let frame = self.begin(picture).with_context(|| format!("frame {number}"))?;
        let answer = |(follower, last): &mut Object| {
            let report = follower.step(number, &frame)?.context("an object begins in the frame that it comes with")?;
            *last = report.target.unwrap_or(*last);
            Ok(state(last, &report))
        };
        self.objects.iter_mut().map(answer).collect()
    }

    /// The next frame, in which the new objects will be locked on.
    fn begin(&mut self, picture: &str) -> Result<GrayFrame> {
        let frame = image::frame(picture)?;
        for target in self.new.drain(..) {
            let inside = region::inside(&target, frame.width, frame.height)?;
            self.objects.push((Follower::new((self.server.build)()?, vec![(self.frames, inside)]), inside.into()));
        }
        Ok(frame)
    }
}

/// Where the object is, or was when it was seen last; the confidence tells them apart. A method that does not know its own, and the
/// frame that was started in, are sure.
fn state(place: &BoundingBox, report: &Report) -> Message {
    let confidence = if report.target.is_some() { report.confidence().unwrap_or(1.0) } else { 0.0 };
    Message::new("state").argument(region::text(place)).property("confidence", format!("{confidence:.6}"))
}

#[cfg(test)]
mod tests;
