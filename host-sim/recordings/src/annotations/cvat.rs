//! CVAT XML 1.1, <https://docs.cvat.ai/docs/dataset_management/formats/format-cvat/>: tracks of a video, or shapes of
//! images. Frames and images count from 0. A shape is read as its bounding box.

use super::track::{Entry, Seen, Track, frame, line_of, number, shown, unused};
use super::xml::{Element, Step, Steps};
use crate::annotations::boxes::mask;
use crate::bounding_box::BoundingBox;
use anyhow::{Context, Result, bail, ensure};
use std::collections::HashMap;

const SHAPES: [&str; 8] = ["box", "polygon", "polyline", "points", "ellipse", "cuboid", "mask", "skeleton"];

/// Parses CVAT XML. In a track, a key frame is a lock or, with `outside`, the frame from which on the target is gone.
/// Shapes between key frames are skipped, because they lie on a line between these, as are shapes of a tracker
/// (`source="auto"`). In images, each shape is a lock of
/// the target that its label names.
pub(super) fn tracks(text: &str) -> Result<Vec<Track>> {
    let (mut steps, mut file) = (Steps::new(text), File::default());
    // The open elements from the root on, and the points of a skeleton.
    let (mut open, mut points): (Vec<Element>, Vec<Element>) = (Vec::new(), Vec::new());
    while let Some(step) = steps.next()? {
        match step {
            Step::Open(element) => {
                let line = || line_of(text, element.at);
                match open.as_slice() {
                    [] => ensure!(
                        element.name == "annotations",
                        "{}: <{}> is no CVAT XML: expected <annotations>",
                        line(),
                        element.name
                    ),
                    [_] => file.open(&element).with_context(line)?,
                    [_, _] => points.clear(),
                    _ => {}
                }
                open.push(element);
            }
            Step::Close => {
                let Some(element) = open.pop() else { continue };
                match open.as_slice() {
                    [_, parent] if ["track", "image"].contains(&parent.name.as_str()) && element.name != "tag" => {
                        let added = file.add(parent, &element, &points);
                        added.with_context(|| line_of(text, element.at))?;
                    }
                    [_, _, parent] if parent.name == "skeleton" && element.name != "attribute" => points.push(element),
                    _ => {}
                }
            }
        }
    }
    Ok(file.tracks)
}

#[derive(Default)]
struct File {
    tracks: Vec<Track>,
    /// Count of the tracks of each name.
    names: HashMap<String, usize>,
    /// Index of the track of each label in images.
    labels: HashMap<String, usize>,
}

impl File {
    fn open(&mut self, element: &Element) -> Result<()> {
        match element.name.as_str() {
            "version" | "meta" => Ok(()),
            "image" => number_of_frame(element, "id").map(|_| ()),
            "track" => self.begin(attribute(element, "label")?, true).map(|_| ()),
            other => bail!("<{other}> is not known: expected <track> or <image>"),
        }
    }

    /// Adds a track and returns its index.
    fn begin(&mut self, label: &str, is_line: bool) -> Result<usize> {
        let name = Some(unused(label, &mut self.names)?);
        self.tracks.push(Track { name, entries: Vec::new(), is_line });
        Ok(self.tracks.len() - 1)
    }

    /// Adds a shape of the last track or of an image.
    fn add(&mut self, parent: &Element, shape: &Element, points: &[Element]) -> Result<()> {
        let kind = shape.name.as_str();
        ensure!(SHAPES.contains(&kind), "<{kind}> is no shape of CVAT: expected one of {}", SHAPES.join(", "));
        let (frame, track) = if parent.name == "track" {
            (number_of_frame(shape, "frame")?, self.tracks.len() - 1)
        } else {
            let frame = number_of_frame(parent, "id")?;
            let label = attribute(shape, "label")?;
            let known = self.labels.get(label).copied();
            let track = known.map_or_else(|| self.begin(label, false), Ok)?;
            self.labels.insert(label.to_owned(), track);
            (frame, track)
        };
        if flag(shape, "keyframe")?.unwrap_or(true) {
            let seen = seen(shape, points)?;
            self.tracks[track].entries.push(Entry { frame, at: shape.at, seen });
        }
        Ok(())
    }
}

fn attribute<'a>(of: &'a Element, name: &str) -> Result<&'a str> {
    of.attribute(name).with_context(|| format!("there is no {name}=\"...\" in <{}>", of.name))
}

fn value(of: &Element, name: &'static str) -> Result<f64> {
    number(attribute(of, name)?).context(name)
}

fn number_of_frame(of: &Element, name: &'static str) -> Result<usize> {
    Ok(frame(attribute(of, name)?, 0).context(name)? as usize + 1)
}

fn flag(of: &Element, name: &'static str) -> Result<Option<bool>> {
    match of.attribute(name) {
        None => Ok(None),
        Some("0") => Ok(Some(false)),
        Some("1") => Ok(Some(true)),
        Some(other) => bail!("{name}: expected 0 or 1, found {}", shown(other)),
    }
}

fn seen(shape: &Element, points: &[Element]) -> Result<Seen> {
    if shape.attribute("source") == Some("auto") {
        return Ok(Seen::Answer);
    }
    // A skeleton is outside if all of its points are.
    let is_outside = flag(shape, "outside")?.unwrap_or(false);
    let corners = if is_outside { Vec::new() } else { corners(shape, points)? };
    Ok(BoundingBox::around(&corners).map_or(Seen::Gone, Seen::Box))
}

/// Returns points on the sides of a shape's bounding box; none if nothing of the shape is visible.
fn corners(shape: &Element, points: &[Element]) -> Result<Vec<[f64; 2]>> {
    let of = |name| value(shape, name);
    Ok(match shape.name.as_str() {
        "box" => {
            let ([x1, y1], [x2, y2]) = ([of("xtl")?, of("ytl")?], [of("xbr")?, of("ybr")?]);
            ensure!(x1 <= x2 && y1 <= y2, "expected xtl <= xbr and ytl <= ybr, found {x1}, {x2} and {y1}, {y2}");
            match rotation(shape)? {
                [_, 0.0] => vec![[x1, y1], [x2, y2]],
                [cos, sin] => {
                    let (rx, ry) = ((x2 - x1) / 2.0, (y2 - y1) / 2.0);
                    let (across, down) = (rx * cos.abs() + ry * sin.abs(), rx * sin.abs() + ry * cos.abs());
                    around_centre([(x1 + x2) / 2.0, (y1 + y2) / 2.0], [across, down])
                }
            }
        }
        "ellipse" => {
            let ([rx, ry], [cos, sin]) = ([of("rx")?, of("ry")?], rotation(shape)?);
            ensure!(rx > 0.0 && ry > 0.0, "expected rx and ry above 0, found {rx} and {ry}");
            let reach = [(rx * cos).hypot(ry * sin), (rx * sin).hypot(ry * cos)];
            around_centre([of("cx")?, of("cy")?], reach)
        }
        "cuboid" => {
            let corner = |[x, y]: [&'static str; 2]| Ok([of(x)?, of(y)?]);
            CUBOID.into_iter().map(corner).collect::<Result<_>>()?
        }
        "mask" => {
            let [left, top, width, height] =
                ["left", "top", "width", "height"].map(|name| attribute(shape, name).map(str::trim));
            let runs = format!("{},{},{},{},{}", left?, top?, width?, height?, attribute(shape, "rle")?);
            let bounds = mask(&runs).context("expected left, top, width, height and rle of a mask")?;
            bounds.map_or(Vec::new(), |of| vec![[of.x, of.y], [of.x + of.width, of.y + of.height]])
        }
        "skeleton" => {
            let mut all = Vec::new();
            for point in points {
                if !flag(point, "outside")?.unwrap_or(false) {
                    all.extend(outline(point)?);
                }
            }
            all
        }
        _ => outline(shape)?,
    })
}

fn around_centre([x, y]: [f64; 2], [across, down]: [f64; 2]) -> Vec<[f64; 2]> {
    vec![[x - across, y - down], [x + across, y + down]]
}

const CUBOID: [[&str; 2]; 8] = [
    ["xtl1", "ytl1"],
    ["xbl1", "ybl1"],
    ["xtr1", "ytr1"],
    ["xbr1", "ybr1"],
    ["xtl2", "ytl2"],
    ["xbl2", "ybl2"],
    ["xtr2", "ytr2"],
    ["xbr2", "ybr2"],
];

/// Returns cosine and sine of a shape's rotation, clockwise about its centre, in an image whose y axis points down.
fn rotation(shape: &Element) -> Result<[f64; 2]> {
    let degrees = if shape.attribute("rotation").is_some() { value(shape, "rotation")? } else { 0.0 };
    let (sin, cos) = (degrees % 360.0).to_radians().sin_cos();
    // Right angles turn a box into whole pixels again.
    Ok([cos, sin].map(|part| (part * 1e12).round() / 1e12))
}

/// Parses `points="x1,y1;x2,y2;..."`.
fn outline(of: &Element) -> Result<Vec<[f64; 2]>> {
    let text = attribute(of, "points")?;
    let point = |pair: &str| pair.split_once(',').and_then(|(x, y)| Some([number(x).ok()?, number(y).ok()?]));
    let all = text.split(';').map(point).collect::<Option<Vec<_>>>();
    all.with_context(|| format!("points: expected x,y;x,y;..., found {}", shown(text)))
}
