//! The page on which boxes are dragged over a recording: that of the window, with the frames in it and nothing that follows.

use crate::encode::{self, base64};
use crate::front_end;
use anyhow::{Result, bail, ensure};
use serde_json::json;
use smr_recordings::{BoundingBox, ColorFrame};

/// The longest side of a frame in the page, but for the one that is shown first.
pub const SIDE: u16 = 960;

/// The most frames of the page, but for the one that is shown first: enough to find a place by.
const MOST: usize = 600;

/// What the page is made for. Frames have the numbers that they have in the recording.
pub struct Choosing {
    pub name: String,
    /// The number of the first frame that is read.
    pub first: usize,
    /// The number of the frame that is shown first. It is kept as it is.
    pub shown: usize,
    /// The box to begin with in that frame.
    pub target: Option<BoundingBox>,
    /// The options that each command line has, quoted for a shell, and how the recording is called in it.
    pub options: String,
    pub recording: String,
    /// The page's own file.
    pub file: String,
}

pub struct Picked {
    pub page: String,
    /// Of the recording.
    pub size: (u16, u16),
    /// The number of the last frame, and how many are in the page.
    pub last: usize,
    pub pictures: usize,
}

/// Frames as JPEG files with their numbers, spread evenly over the recording.
struct Frames {
    first: usize,
    every: usize,
    kept: Vec<(usize, Vec<u8>)>,
}

pub struct Shots<F> {
    /// In the size of the recording or smaller.
    pub frames: F,
    /// Of the recording.
    pub size: (u16, u16),
    /// The frame that is shown first, if `frames` has a smaller one.
    pub shown: Option<ColorFrame>,
}

/// A page of at most `budget` bytes. `least` is the smallest box.
/// Errors: No frame with the number to show, or a budget that is too small for it.
pub fn pick(
    Shots { frames, size, shown: large }: Shots<impl Iterator<Item = ColorFrame>>,
    choosing: &Choosing,
    least: (u16, u16),
    budget: usize,
) -> Result<Picked> {
    let first = choosing.first;
    let mut kept = Frames { first, every: 1, kept: Vec::new() };
    let (mut shown, mut last) = (None, first - 1);
    for (number, frame) in (first..).zip(frames) {
        last = number;
        if number == choosing.shown {
            shown = Some((number, encode::color_jpeg(large.as_ref().unwrap_or(&frame), encode::GOOD)?));
        }
        kept.offer(number, &frame, budget)?;
    }
    let Some(shown) = shown else {
        bail!("{}: there is no frame {}: expected {first} to {last}", choosing.name, choosing.shown);
    };
    loop {
        let pictures = kept.with(&shown);
        let page = choosing.page(&pictures, size, last, kept.every, least);
        if page.len() <= budget {
            return Ok(Picked { page, size, last, pictures: pictures.len() });
        }
        let bytes = page.len().div_ceil(1_000_000);
        ensure!(kept.thin(), "the page has {bytes} MB with one frame: expected --budget {bytes} or more");
    }
}

impl Frames {
    fn offer(&mut self, number: usize, frame: &ColorFrame, budget: usize) -> Result<()> {
        if (number - self.first).is_multiple_of(self.every) {
            self.kept.push((number, encode::color_jpeg(&encode::within(frame, SIDE), encode::ENOUGH)?));
        }
        while (self.kept.len() > MOST || self.bytes() > budget) && self.thin() {}
        Ok(())
    }

    /// In the page, where 3 bytes become 4 characters.
    fn bytes(&self) -> usize {
        self.kept.iter().map(|(_, jpeg)| jpeg.len().div_ceil(3) * 4).sum()
    }

    /// Leaves out every other frame; false if there is only one.
    fn thin(&mut self) -> bool {
        if self.kept.len() < 2 {
            return false;
        }
        self.every *= 2;
        self.kept.retain(|(number, _)| (number - self.first).is_multiple_of(self.every));
        true
    }

    /// In order, with the frame that is shown first in its better quality.
    fn with<'a>(&'a self, shown: &'a (usize, Vec<u8>)) -> Vec<&'a (usize, Vec<u8>)> {
        let others = self.kept.iter().filter(|(number, _)| *number != shown.0);
        let mut all: Vec<_> = others.chain([shown]).collect();
        all.sort_by_key(|(number, _)| *number);
        all
    }
}

impl Choosing {
    fn page(
        &self,
        pictures: &[&(usize, Vec<u8>)],
        (width, height): (u16, u16),
        last: usize,
        every: usize,
        least: (u16, u16),
    ) -> String {
        let Self { name, first, shown, options, recording, file, .. } = self;
        let words = [recording, options].map(String::as_str).join(" ").trim_end().to_owned();
        let mut commands = json!({ "track": "--video out.mp4", "report": "-o report.html" });
        // The window shows all of a recording.
        if options.is_empty() {
            commands["view"] = "".into();
        }
        let mut about = format!("{width}x{height} pixels, frames {first} to {last}.");
        if every > 1 {
            let again = format!("host-sim frame {recording} NUMBER {options}").trim_end().to_owned();
            about += &format!(
                " To keep the page small, one of {every} frames is here. For a frame that is missing: {again} -o {file}"
            );
        }
        let target = self.target.and_then(|target| target.to_rect()).map(|rect| {
            json!({ "id": 1, "name": "", "locks": [{ "frame": shown, "box": [rect.x, rect.y, rect.width, rect.height] }] })
        });
        let data = json!({
            "name": name,
            "about": about,
            "width": width,
            "height": height,
            "first": first,
            "last": last,
            "shown": shown,
            "version": env!("CARGO_PKG_VERSION"),
            "words": words,
            "commands": commands,
            "least": least,
            "targets": Vec::from_iter(target),
            "frames": pictures.iter().map(|(number, jpeg)| json!([number, base64(jpeg)])).collect::<Vec<_>>(),
        });
        let data = data.to_string().replace('<', "\\u003c");
        front_end::window(&format!(
            "<script type=\"application/json\" id=\"data\">{data}</script>\n{}\n<script type=\"module\">import \"smr/window.js\";</script>",
            front_end::import_map()
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::canvas::Canvas;
    use base64::Engine as _;
    use serde_json::Value;
    use smr_recordings::{decode_picture, synthetic};

    const BUDGET: usize = 25_000_000;

    fn choosing(first: usize, shown: usize) -> Choosing {
        Choosing {
            name: "<b>name".into(),
            first,
            shown,
            target: None,
            options: "--frames 20..60".into(),
            recording: "'my clip.mp4'".into(),
            file: "pick.html".into(),
        }
    }

    fn made(choosing: &Choosing, frames: usize, budget: usize) -> Result<(Picked, Value)> {
        let frames = (choosing.first - 1..).take(frames).map(|index| (&synthetic::frame(index)).into());
        let picked = pick(Shots { frames, size: (160, 120), shown: None }, choosing, (2, 3), budget)?;
        let data = picked.page.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
        let data = serde_json::from_str(data).unwrap();
        Ok((picked, data))
    }

    fn numbers(data: &Value) -> Vec<u64> {
        data["frames"].as_array().unwrap().iter().map(|frame| frame[0].as_u64().unwrap()).collect()
    }

    #[test]
    fn a_page_has_what_its_script_needs_and_nothing_from_elsewhere() {
        let choosing = Choosing { target: "36,20.4,10,30".parse().ok(), ..choosing(20, 20) };
        let (Picked { page, size, last, pictures }, data) = made(&choosing, 41, BUDGET).unwrap();
        assert_eq!((size, last, pictures), ((160, 120), 60, 41));
        assert_eq!(data["about"], "160x120 pixels, frames 20 to 60.");
        assert!(data["name"] == "<b>name" && !page.contains("<b>name"), "a name is no part of the page");
        let page = page.replace("<link rel=\"icon\" href=\"data:,\">", "");
        let loads = ["http", "href=\"", " src=\"", "url("];
        assert!(loads.iter().all(|one| !page.contains(one)));
        assert_eq!(numbers(&data), (20..=60).collect::<Vec<_>>());
        assert_eq!(
            data["targets"],
            json!([{ "id": 1, "name": "", "locks": [{ "frame": 20, "box": [36, 20, 10, 30] }] }])
        );
        assert_eq!(data["least"], json!([2, 3]));
        assert_eq!(data["words"], "'my clip.mp4' --frames 20..60");
        assert_eq!(data["commands"], json!({ "track": "--video out.mp4", "report": "-o report.html" }));
        let (_, whole) = made(&Choosing { options: String::new(), ..choosing }, 41, BUDGET).unwrap();
        assert_eq!((&whole["words"], &whole["commands"]["view"]), (&"'my clip.mp4'".into(), &"".into()));
    }

    #[test]
    fn a_budget_thins_the_frames_evenly_and_keeps_the_one_that_is_shown() {
        let (all, data) = made(&choosing(1, 6), 40, BUDGET).unwrap();
        let bytes = data["frames"].to_string().len();
        let budget = all.page.len() - bytes * 2 / 3;
        let (picked, data) = made(&choosing(1, 6), 40, budget).unwrap();
        assert!(picked.page.len() <= budget);
        assert_eq!(numbers(&data), [1, 5, 6, 9, 13, 17, 21, 25, 29, 33, 37]);
        let about = data["about"].as_str().unwrap();
        assert!(about.contains("one of 4 frames is here"));
        assert!(about.ends_with("host-sim frame 'my clip.mp4' NUMBER --frames 20..60 -o pick.html"), "{about}");
        let error = made(&choosing(1, 6), 40, 1000).err().unwrap().to_string();
        assert!(error.contains("expected --budget 1 or more"), "{error}");
    }

    #[test]
    fn the_frame_that_is_shown_first_has_all_its_pixels() {
        let wide = |width: u16| ColorFrame { width, height: 8, pixels: vec![[90, 200, 40]; usize::from(width) * 8] };
        let shots = |width, shown| Shots { frames: (0..3).map(move |_| wide(width)), size: (1920, 8), shown };
        let picked = pick(shots(1920, None), &choosing(1, 2), (1, 1), BUDGET).unwrap();
        let small = pick(shots(480, Some(wide(1920))), &choosing(1, 2), (1, 1), BUDGET).unwrap();
        let widths = |picked: &Picked| {
            let data = picked.page.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
            let data: Value = serde_json::from_str(data).unwrap();
            let width = |frame: &Value| {
                let jpeg = base64::engine::general_purpose::STANDARD.decode(frame[1].as_str().unwrap()).unwrap();
                Canvas::of(&decode_picture(&jpeg).unwrap()).width
            };
            data["frames"].as_array().unwrap().iter().map(width).collect::<Vec<_>>()
        };
        assert_eq!((widths(&picked), widths(&small)), (vec![960, 1920, 960], vec![480, 1920, 480]));
    }

    #[test]
    fn of_a_long_recording_frames_are_left_out() {
        let frame = || ColorFrame { width: 8, height: 8, pixels: vec![[90, 200, 40]; 64] };
        let shots = Shots { frames: (0..1300).map(|_| frame()), size: (8, 8), shown: None };
        let picked = pick(shots, &choosing(1, 2), (1, 1), BUDGET).unwrap();
        // Every fourth, and the one that is shown.
        assert_eq!(picked.pictures, 1300 / 4 + 1);
    }

    #[test]
    fn a_frame_that_there_is_not_is_named() {
        let error = made(&choosing(20, 61), 41, BUDGET).err().unwrap().to_string();
        assert_eq!(error, "<b>name: there is no frame 61: expected 20 to 60");
    }
}
