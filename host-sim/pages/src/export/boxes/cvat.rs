//! CVAT XML 1.1 for video, <https://docs.cvat.ai/docs/other/xml_format>: a track for each target. Frames count from 0;
//! a box is its left, top, right and bottom edge. CVAT drops boxes that are not key frames, so every box is a key
//! frame. `source="auto"`, which CVAT ignores, marks boxes of a tracker, unlike those of the user or of a baseline.

use super::{About, Answer};
use smr_recordings::BoundingBox;
use std::fmt::Write;

pub(super) struct Tracks {
    tracks: Vec<Track>,
    size: (u16, u16),
    frames: usize,
}

#[derive(Clone, Default)]
struct Track {
    boxes: String,
    last: Option<BoundingBox>,
    is_outside: bool,
    is_gone: bool,
}

impl Tracks {
    pub fn new(targets: usize) -> Self {
        Self { tracks: vec![Track::default(); targets], size: (0, 0), frames: 0 }
    }

    pub fn add(&mut self, answer: &Answer<'_>) {
        (self.size, self.frames) = (answer.size, self.frames.max(answer.frame));
        let track = &mut self.tracks[answer.target];
        let target = answer.report.and_then(|report| report.target);
        // `outside="1"` holds until the next box, so one box with it is enough while a target is lost. If the user then
        // marks the target as gone, a second one, without `source`, follows.
        let (is_outside, is_gone) = (target.is_none(), answer.report.is_none());
        let is_told = track.is_outside && (track.is_gone || !is_gone);
        let Some(seen) = target.or(track.last.filter(|_| !is_told)) else { return };
        (track.last, track.is_outside, track.is_gone) = (Some(seen), is_outside, is_gone);
        let source =
            if answer.report.is_some_and(|report| report.evidence.is_some()) { r#" source="auto""# } else { "" };
        let BoundingBox { x, y, width, height } = seen;
        let (right, bottom) = (x + width, y + height);
        let (frame, outside) = (answer.frame - 1, u8::from(is_outside));
        // Writing to a string cannot fail.
        let _ = writeln!(
            track.boxes,
            r#"    <box frame="{frame}" keyframe="1" outside="{outside}" occluded="0" xtl="{x:.2}" ytl="{y:.2}" xbr="{right:.2}" ybr="{bottom:.2}" z_order="0"{source}></box>"#
        );
    }

    pub fn text(&self, about: &About) -> String {
        let ((width, height), frames, name) = (self.size, self.frames, escaped(&about.name));
        let label = |target| escaped(about.label(target));
        let element =
            |target| format!("        <label><name>{}</name><attributes></attributes></label>\n", label(target));
        let labels: String = (0..self.tracks.len()).map(element).collect();
        let mut text = format!(
            r#"<?xml version="1.0" encoding="utf-8"?>
<annotations>
  <version>1.1</version>
  <meta>
    <task>
      <name>{name}</name>
      <size>{frames}</size>
      <mode>interpolation</mode>
      <start_frame>0</start_frame>
      <stop_frame>{}</stop_frame>
      <labels>
{labels}      </labels>
      <original_size><width>{width}</width><height>{height}</height></original_size>
    </task>
  </meta>
"#,
            frames.saturating_sub(1)
        );
        for (target, track) in self.tracks.iter().enumerate() {
            let (label, boxes) = (label(target), &track.boxes);
            let _ = write!(text, "  <track id=\"{target}\" label=\"{label}\" source=\"auto\">\n{boxes}  </track>\n");
        }
        text + "</annotations>\n"
    }
}

/// Escapes text for XML 1.0: <https://www.w3.org/TR/xml/#charsets>.
fn escaped(text: &str) -> String {
    let letter = |letter: char| match letter {
        '&' => "&amp;".to_owned(),
        '<' => "&lt;".to_owned(),
        '>' => "&gt;".to_owned(),
        '"' => "&quot;".to_owned(),
        '\t' | '\n' | '\r' => format!("&#{};", u32::from(letter)),
        '\0'..' ' | '\u{fffe}' | '\u{ffff}' => char::REPLACEMENT_CHARACTER.to_string(),
        _ => letter.to_string(),
    };
    text.chars().map(letter).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn names_of_all_kinds_are_text_of_xml() {
        assert_eq!(
            super::escaped("a<&\">\n\u{1}\u{fffe}\u{202e}ü"),
            "a&lt;&amp;&quot;&gt;&#10;\u{fffd}\u{fffd}\u{202e}ü"
        );
    }
}
