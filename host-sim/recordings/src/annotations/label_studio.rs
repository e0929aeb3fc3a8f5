//! JSON of Label Studio, <https://labelstud.io/guide/export>: the regions `videorectangle` of a video. Frames count from 1;
//! sides are in percent of the frame, and a box is turned about its upper left corner.

use super::track::{Entry, Seen, Track, unused};
use crate::bounding_box::BoundingBox;
use crate::frame_number::FrameNumber;
use anyhow::{Context, Result, anyhow, ensure};
use serde::Deserialize;
use std::collections::{HashMap, HashSet};

#[derive(Deserialize)]
struct Task {
    annotations: Vec<Annotation>,
}

#[derive(Deserialize)]
struct Annotation {
    result: Vec<Region>,
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

/// Parses the export of one video, whose frames have the size `size`.
pub(super) fn tracks(text: &str, size: (u16, u16)) -> Result<Vec<Track>> {
    let wrong = |error: serde_json::Error| {
        let line = error.line();
        anyhow!("line {line}: it is damaged, or no JSON of Label Studio ({error}): expected its export of a video")
    };
    let tasks: Vec<Task> = serde_json::from_str(text).map_err(wrong)?;
    let annotations: Vec<&Annotation> = tasks.iter().flat_map(|task| &task.annotations).collect();
    ensure!(
        annotations.len() <= 1,
        "it has {} annotations: expected that of one video by one person",
        annotations.len()
    );
    let regions = annotations.iter().flat_map(|annotation| &annotation.result);
    let mut names = HashMap::new();
    regions
        .filter(|region| region.kind == "videorectangle")
        .map(|region| track(&region.value, size, &mut names))
        .collect()
}

fn track(value: &Value, size: (u16, u16), names: &mut HashMap<String, usize>) -> Result<Track> {
    let name = unused(value.labels.first().map_or("target", String::as_str), names)?;
    let mut entries = Vec::new();
    let mut frames = HashSet::new();
    for key in &value.sequence {
        let frame = key.frame.get();
        ensure!(frames.insert(frame), "{name} is in frame {frame} twice: expected one box of a target in a frame");
        let bbox = key.bounds(size).with_context(|| format!("{name} in frame {frame}"))?;
        entries.push(Entry { frame, at: 0, seen: Seen::Box(bbox) });
    }
    for key in value.sequence.iter().filter(|key| !key.enabled) {
        let frame = key.frame.get() + 1;
        if !frames.contains(&frame) {
            entries.push(Entry { frame, at: 0, seen: Seen::Gone });
        }
    }
    Ok(Track { name: Some(name), entries, is_line: true })
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
