//! JSON of Label Studio, <https://labelstud.io/guide/export>: the regions `videorectangle` of a video. Frames count from 1;
//! sides are in percent of the frame, and a box is turned about its upper left corner.

use super::Labelled;
use super::track::{Entry, Seen, Track, unused};
use crate::bounding_box::BoundingBox;
use crate::frame_number::FrameNumber;
use anyhow::{Context, Result, anyhow, ensure};
use serde::Deserialize;
use serde_json::Value as Json;
use std::collections::{BTreeMap, HashMap, HashSet};

/// A video, with the work of each person on it.
#[derive(Deserialize)]
struct Task {
    /// Absent from the export "JSON-MIN".
    annotations: Option<Vec<Annotation>>,
    /// Names the video, by an address in any of its fields.
    #[serde(default)]
    data: BTreeMap<String, Json>,
}

#[derive(Deserialize)]
struct Annotation {
    result: Vec<Region>,
    /// True if the person has skipped the video.
    #[serde(default)]
    was_cancelled: bool,
}

#[derive(Deserialize)]
struct Region {
    #[serde(rename = "type")]
    kind: String,
    #[serde(default)]
    value: Value,
}

/// Of other regions than `videorectangle`, the sequence is empty.
#[derive(Default, Deserialize)]
struct Value {
    #[serde(default)]
    sequence: Vec<KeyFrame>,
    #[serde(default)]
    labels: Vec<String>,
    /// Count of the frames that Label Studio has numbered: by 24 a second unless its configuration says otherwise.
    #[serde(default, rename = "framesCount")]
    frames: Option<f64>,
}

#[derive(Deserialize)]
struct KeyFrame {
    frame: FrameNumber,
    x: f64,
    y: f64,
    width: f64,
    height: f64,
    /// In degrees, clockwise.
    #[serde(default)]
    rotation: f64,
    /// False if the target is gone after this frame; true if it goes to the next key frame on a line.
    #[serde(default = "enabled")]
    enabled: bool,
}

const fn enabled() -> bool {
    true
}

/// Parses an export. Of several videos, the one with the recording's name is taken.
pub(super) fn tracks(text: &str, of: &Labelled<'_>) -> Result<Vec<Track>> {
    let wrong = |error: serde_json::Error| {
        let line = error.line();
        anyhow!("line {line}: it is damaged, or no JSON of Label Studio ({error}): expected its export of a video")
    };
    let tasks: Vec<Task> = serde_json::from_str(text).map_err(wrong)?;
    ensure!(
        tasks.is_empty() || tasks.iter().any(|task| task.annotations.is_some()),
        "no task of it has annotations: expected Label Studio's export JSON, not JSON-MIN"
    );
    let done = task_of(&tasks, of.name)?.and_then(|task| task.annotations.as_ref());
    let annotations: Vec<_> = done.into_iter().flatten().filter(|annotation| !annotation.was_cancelled).collect();
    ensure!(
        annotations.len() <= 1,
        "it has {} annotations of the video: expected that of one person",
        annotations.len()
    );
    let regions = annotations.iter().flat_map(|annotation| &annotation.result);
    let mut names = HashMap::new();
    regions
        .filter(|region| region.kind == "videorectangle")
        .map(|region| track(&region.value, of, &mut names))
        .collect()
}

/// Returns the task about the video `name`; a single task is about any video.
fn task_of<'a>(tasks: &'a [Task], name: &str) -> Result<Option<&'a Task>> {
    if tasks.len() <= 1 {
        return Ok(tasks.first());
    }
    let mut named = tasks.iter().filter(|task| task.videos().any(|video| is_called(&video, name)));
    let found = named.next();
    ensure!(
        found.is_some() && named.next().is_none(),
        "it is about {} videos: expected one called {name}, found {}",
        tasks.len(),
        names(tasks)
    );
    Ok(found)
}

/// Lists the names of a few videos for a message.
fn names(tasks: &[Task]) -> String {
    let names: Vec<_> = tasks.iter().filter_map(|task| task.videos().find(|name| !name.is_empty())).take(4).collect();
    match &names[..] {
        [first, second, third, _] => format!("{first}, {second}, {third}, ..."),
        few => few.join(", "),
    }
}

impl Task {
    /// Returns the file names of its data, without their extensions: the last in the path of an address, and the last in
    /// its query (`/data/local-files/?d=folder/clip.mp4`).
    fn videos(&self) -> impl Iterator<Item = String> {
        let addresses = self.data.values().filter_map(Json::as_str);
        let parts = addresses.flat_map(|address| [address.split('?').next().unwrap_or_default(), address]);
        parts.filter_map(|part| {
            let file = without_percent(part.rsplit(['/', '\\', '=', '?']).next()?);
            Some(file.rsplit_once('.').map_or(&*file, |(stem, _)| stem).to_owned())
        })
    }
}

/// Resolves `%20` and the like in a part of an address.
fn without_percent(text: &str) -> String {
    let (mut bytes, mut rest) = (Vec::new(), text.as_bytes());
    while let [first, after @ ..] = rest {
        let code = after.get(..2).filter(|_| *first == b'%').and_then(|code| std::str::from_utf8(code).ok());
        let byte = code.and_then(|code| u8::from_str_radix(code, 16).ok());
        bytes.push(byte.unwrap_or(*first));
        rest = if byte.is_some() { &after[2..] } else { after };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// True if Label Studio's file `video` is the video `name`: an upload has a number of eight hexadecimal digits before its
/// name, and other characters for some.
fn is_called(video: &str, name: &str) -> bool {
    let plain = |text: &str| text.chars().map(|letter| if letter.is_alphanumeric() { letter } else { '_' }).collect();
    let (video, name): (String, String) = (plain(video), plain(name));
    let upload =
        video.split_once('_').filter(|(number, _)| number.len() == 8 && u32::from_str_radix(number, 16).is_ok());
    video == name || upload.is_some_and(|(_, rest)| rest == name)
}

fn track(value: &Value, of: &Labelled<'_>, names: &mut HashMap<String, usize>) -> Result<Track> {
    let name = unused(value.labels.first().map_or("target", String::as_str), names)?;
    let mut entries = Vec::new();
    let (mut counted, mut frames) = (HashSet::new(), HashSet::new());
    for key in &value.sequence {
        let number = key.frame.get();
        ensure!(counted.insert(number), "{name} is in frame {number} twice: expected one box of a target in a frame");
        let bbox = key.bounds(of.size).with_context(|| format!("{name} in frame {number}"))?;
        let frame = value.in_recording(key.frame, of.frames);
        // Of two boxes that fall into one frame of the recording, the first in the file is taken.
        if frames.insert(frame) {
            entries.push(Entry { frame, at: 0, seen: Seen::Box(bbox) });
        }
    }
    for key in value.sequence.iter().filter(|key| !key.enabled) {
        let frame = value.in_recording(key.frame, of.frames) + 1;
        if frames.insert(frame) {
            entries.push(Entry { frame, at: 0, seen: Seen::Gone });
        }
    }
    Ok(Track { name: Some(name), entries, is_line: true })
}

/// Greatest ratio of the rates at which Label Studio and the recording count frames, either way.
const MOST: f64 = 20.0;

impl Value {
    /// Returns a frame as the recording counts it: at the same time, if Label Studio has counted another number of frames.
    fn in_recording(&self, frame: FrameNumber, frames: Option<usize>) -> usize {
        let frame = frame.get();
        #[allow(clippy::cast_precision_loss)] // exact: numbers of frames are below 2^31
        let both = self.frames.zip(frames).map(|(counted, frames)| (counted, frames as f64));
        // A count that no rate explains is no count.
        let is_rate = |(counted, frames): &(f64, f64)| (1.0 / MOST..=MOST).contains(&(counted / frames));
        let differs = |(counted, frames): &(f64, f64)| (counted - frames).abs() > 1.0;
        let Some((counted, frames)) = both.filter(|both| is_rate(both) && differs(both)) else {
            return frame;
        };
        #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
        let moved = ((frame - 1) as f64 * frames / counted).round() as usize + 1;
        moved.min(FrameNumber::MAX)
    }
}

impl KeyFrame {
    /// Returns the box in pixels. Errors: It has none.
    fn bounds(&self, (wide, high): (u16, u16)) -> Result<BoundingBox> {
        ensure!(
            self.width > 0.0 && self.height > 0.0,
            "expected width and height above 0, found {} and {}",
            self.width,
            self.height
        );
        let [wide, high] = [wide, high].map(|side| f64::from(side) / 100.0);
        let (left, top) = (self.x * wide, self.y * high);
        let (width, height) = (self.width * wide, self.height * high);
        let (sin, cos) = (self.rotation % 360.0).to_radians().sin_cos();
        let turned = |[x, y]: [f64; 2]| [left + x * cos - y * sin, top + x * sin + y * cos];
        let corners = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]].map(turned);
        let bbox = BoundingBox::around(&corners).context("the box has no corners")?;
        bbox.pixels().map_err(|what| anyhow!("the box {what}"))?;
        Ok(bbox)
    }
}
