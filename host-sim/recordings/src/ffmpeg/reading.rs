//! Reads the images of a file in order, up to the last whole one.
//!
//! A doubt about images that are read directly is checked by packets: joined files, and complaints about what is not
//! decoded, are no damage.

use super::decoder::{Decoder, End, Image, Part, Use};
use super::facts::{EXPECTED, Facts, Video};
use super::last_whole_image::{self, List, Whole};
use super::process::Input;
use crate::checked_frames::damaged;
use anyhow::{Context, Error, Result, anyhow};
use std::path::Path;
use std::time::Duration;

/// Number of decoded images before a doubt that do not count as whole: a wrong image can come before the complaint.
const MARGIN: usize = 2;

const ALL_PACKETS: Part = Part::Packets(usize::MAX);

/// Time error in seconds from which a seek is a miss; rounding to milliseconds alone causes errors of up to 0.0005 s.
const SEEK_TOLERANCE: f64 = 0.0006;

/// A video that is read in order: its images, then an error if they are not whole.
pub(crate) struct Reading {
    /// Sentence for people about a recording that is not read from its start.
    pub note: Option<String>,
    video: Video,
    wanted: Use,
    part: Part,
    decoder: Decoder,
    /// True if a check by packets has found the recording whole.
    is_checked: bool,
    /// The first image, taken from `decoder` but not yet given.
    first: Option<Image>,
    /// Hash of the first image.
    hash: Option<u64>,
    taken: usize,
    doubt: Option<Doubt>,
    is_over: bool,
}

struct Doubt {
    /// Number of whole images before the damage.
    whole: usize,
    /// Number of whole images that every run finds.
    advised: usize,
    words: String,
}

/// Opens a file. Errors: no ffmpeg, or no image.
pub(crate) fn open(program: &str, file: &Path, wanted: Use, patience: Duration) -> Result<Reading> {
    let name = file.display().to_string();
    let cannot_read = || format!("cannot read {name} through ffmpeg");
    let mut reading = Reading::start(Video::of(program, file, patience)?, wanted)?;
    let mut first = reading.next_whole().with_context(cannot_read)?;
    if reading.part == ALL_PACKETS {
        if reading.decoder.decoded() > 0 {
            reading.note = Some(format!("{name} begins between two key frames: it is read from the first one on"));
        } else {
            // Some containers mark no key frames.
            reading.video.facts.begins_at_key = true;
            reading = Reading::start(reading.video, wanted)?;
            first = reading.next_whole().with_context(cannot_read)?;
        }
    }
    let Facts { codec, notes, noted, .. } = &reading.video.facts;
    if reading.note.is_none() && *notes > 0 && codec != "mjpeg" {
        reading.note = Some(format!(
            "{name}: ffmpeg complains while it opens the file, so frames may be wrong or missing: {noted}"
        ));
    }
    if reading.decoder.decoded() == 0 {
        return Err(match reading.doubt {
            Some(_) if reading.video.input.end.is_some() => reading.damage(0, ""),
            Some(Doubt { words, .. }) => anyhow!("ffmpeg cannot decode {name}: {words}: {EXPECTED}"),
            None => anyhow!("{name} holds no frame that ffmpeg decodes"),
        });
    }
    reading.first = first;
    Ok(reading)
}

/// Returns the images of a file up to the first error.
pub(crate) fn good(file: &Path, wanted: Use, patience: Duration) -> impl Iterator<Item = Image> + use<> {
    open("ffmpeg", file, wanted, patience).into_iter().flatten().map_while(Result::ok)
}

/// Seeks the image shown at `time`, in seconds; returns it and all later ones, or `None` if the seek misses it.
pub(crate) fn sought(video: &Video, time: f64, wanted: Use) -> Option<(Image, Decoder)> {
    // Seeks 0.1 ms before `time`; after a miss, 10 s before: some files cannot be decoded from just before it.
    [0.0001, 10.0].iter().find_map(|before| {
        let part = Part::From { seek: time - before, time: time - SEEK_TOLERANCE / 2.0 };
        let mut decoder = Decoder::start(video, wanted, part).ok()?;
        let first = decoder.next().ok()??;
        first.seconds().is_some_and(|found| (found - time).abs() < SEEK_TOLERANCE).then_some((first, decoder))
    })
}

impl Reading {
    fn start(video: Video, wanted: Use) -> Result<Self> {
        let part = if video.facts.begins_at_key { Part::Whole } else { ALL_PACKETS };
        Ok(Self {
            note: None,
            decoder: Decoder::start(&video, wanted, part)?,
            video,
            wanted,
            part,
            is_checked: false,
            first: None,
            hash: None,
            taken: 0,
            doubt: None,
            is_over: false,
        })
    }

    /// Takes the next whole image; after `None`, `doubt` says whether the recording goes on.
    fn next_whole(&mut self) -> Result<Option<Image>> {
        while self.doubt.is_none() {
            if let Some(image) = self.decoder.next()? {
                self.taken += 1;
                self.hash.get_or_insert_with(|| image.hash());
                return Ok(Some(image));
            }
            match self.decoder.end() {
                Some(End::Doubtful { decoded, words }) => {
                    let (decoded, words) = (*decoded, words.clone());
                    if self.part == Part::Whole && self.is_whole_by_packets()? {
                        self.go_on(Decoder::start(&self.video, self.wanted, ALL_PACKETS)?)?;
                        (self.part, self.is_checked) = (ALL_PACKETS, true);
                    } else {
                        self.doubt_after(decoded, words)?;
                    }
                }
                // Directly, ffmpeg itself ends at a packet that is marked as damaged.
                _ if self.part == ALL_PACKETS && !self.is_checked => match List::of(&self.video)?.doubt() {
                    Some(packet) => self.doubt_after(packet, "a packet is damaged".to_owned())?,
                    None => self.is_checked = true,
                },
                _ => return Ok(None),
            }
        }
        if self.doubt.as_ref().is_none_or(|doubt| self.taken >= doubt.whole) {
            return Ok(None);
        }
        let image = self.decoder.next()?;
        self.taken += usize::from(image.is_some());
        Ok(image)
    }

    /// Searches the last whole image, and goes on up to it. Before a doubt, `decoded` images were decoded.
    fn doubt_after(&mut self, decoded: usize, words: String) -> Result<()> {
        let is_file = self.video.input.file.is_file();
        let found = if is_file { last_whole_image::whole(&self.video, decoded)? } else { Whole::unknown(decoded) };
        let whole = found.images.saturating_sub(MARGIN);
        let advised = whole.saturating_sub(found.spread);
        self.doubt = Some(Doubt { whole, advised, words });
        if self.taken < whole {
            self.go_on(Decoder::lenient(&self.video, self.wanted, self.part)?)?;
        }
        Ok(())
    }

    /// Goes on with the next image, decoded in another way.
    fn go_on(&mut self, decoder: Decoder) -> Result<()> {
        self.decoder = decoder;
        for _ in 0..self.taken {
            self.decoder.next()?;
        }
        Ok(())
    }

    fn damage(&self, whole: usize, words: &str) -> Error {
        let name = &self.video.input.name;
        let reason = match self.video.input.end {
            Some(end) => format!("{name} is damaged: the checksum of its part from byte {end} on is wrong"),
            None => format!("{name} is damaged, says ffmpeg: {words}"),
        };
        let none = if whole == 0 { ", and no frame before the damage is sure to be right" } else { "" };
        damaged(reason + none, Some(whole))
    }

    /// True if another ffmpeg decodes copies of all packets without a doubt, into the same first image.
    fn is_whole_by_packets(&mut self) -> Result<bool> {
        let Input { file, end, .. } = &self.video.input;
        if !file.is_file() || end.is_some() || !List::of(&self.video)?.is_plain() {
            return Ok(false);
        }
        let hash = self.hash.or_else(|| self.decoder.first_held());
        let mut decoder = Decoder::start(&self.video, self.wanted, ALL_PACKETS)?;
        let first = decoder.next()?;
        if hash.is_some() && first.map(|first| first.hash()) != hash {
            return Ok(false);
        }
        while decoder.next()?.is_some() {}
        Ok(decoder.is_whole() && decoder.decoded() >= self.taken)
    }
}

impl Iterator for Reading {
    type Item = Result<Image>;

    fn next(&mut self) -> Option<Result<Image>> {
        if let Some(first) = self.first.take() {
            return Some(Ok(first));
        }
        if self.is_over {
            return None;
        }
        let number = self.taken + 1;
        let next = match self.next_whole() {
            Ok(Some(image)) => return Some(Ok(image)),
            Ok(None) => self.doubt.take().map(|doubt| self.damage(doubt.advised, &doubt.words)),
            Err(error) => Some(error.context(format!("{}, frame {number}", self.video.input.name))),
        };
        self.is_over = true;
        next.map(Err)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ffmpeg::PATIENCE;

    #[test]
    fn a_missing_ffmpeg_is_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.mp4");
        std::fs::write(&file, "a video").unwrap();
        let error = format!("{:#}", open("no-such-ffmpeg", &file, Use::Gray, PATIENCE).err().unwrap());
        let expected = "a.mp4 needs ffmpeg to be decoded, and there is none on the PATH: install the package `ffmpeg` (5.1 or later)";
        assert!(error.ends_with(expected), "{error}");
    }

    /// Writes a program that states the facts of a video and then acts as `decoder`, which may print `$0.nut`.
    #[cfg(unix)]
    fn program(folder: &Path, decoder: &str) -> String {
        use std::os::unix::fs::PermissionsExt;
        let file = folder.join("ffmpeg");
        let facts =
            "#tb 0: 1/25\\n#media_type 0: video\\n#codec_id 0: h264\\n#dimensions 0: 2x1\\n0, 0, 0, 1, 9, 0x1\\n";
        let script = format!("#!/bin/sh\ncase \"$*\" in *framecrc*) printf '{facts}' >&2;; *) {decoder};; esac\n");
        std::fs::write(&file, script).unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o755)).unwrap();
        std::fs::write(folder.join("ffmpeg.nut"), crate::ffmpeg::nut::tests::images(5)).unwrap();
        file.to_str().unwrap().to_owned()
    }

    #[cfg(unix)]
    #[test]
    fn a_hanging_ffmpeg_is_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let short = Duration::from_millis(300);
        let file = folder.path().join("a.mp4");
        std::fs::write(&file, "a video").unwrap();
        let begin = std::time::Instant::now();
        let silent = "ffmpeg has done nothing for 0.3 s (--ffmpeg-timeout)";

        let never = program(folder.path(), "exec sleep 60");
        let error = format!("{:#}", open(&never, &file, Use::Gray, short).err().unwrap());
        assert_eq!(error, format!("cannot read {} through ffmpeg: {silent}", file.display()));
        let images = "for n in 0 1 2 3 4; do echo \"frame:$n pts:$n pts_time:$n\" >&2; done; cat \"$0.nut\"";
        for then in ["", "exec >&-;"] {
            let stops = program(folder.path(), &format!("{images}; {then} exec sleep 60"));
            let mut frames = open(&stops, &file, Use::Gray, short).unwrap();
            assert!(frames.next().unwrap().is_ok());
            let error = format!("{:#}", frames.next().unwrap().err().unwrap());
            assert!(error.starts_with(&format!("{}, frame 2: ", file.display())) && error.ends_with(silent), "{error}");
        }
        assert!(begin.elapsed() < Duration::from_secs(30));
    }

    /// The test image, at half of the signal range, shows 92 cd/m2 in PQ (ITU-R BT.2100), and 51 cd/m2 in HLG.
    #[test]
    fn light_of_more_than_a_screen_has_is_mapped_to_what_it_has() {
        let test = "light_of_more_than_a_screen_has_is_mapped_to_what_it_has";
        if !crate::missing::has_ffmpeg(test) {
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        for (transfer, shown) in [("bt709", 128), ("smpte2084", 153), ("arib-std-b67", 124)] {
            let file = folder.path().join(format!("{transfer}.mkv"));
            let colors = format!("-color_trc {transfer} -color_primaries bt2020 -colorspace bt2020nc");
            let input = "-f lavfi -i color=gray:size=32x16:duration=0.1 -c:v ffv1 -pix_fmt yuv420p10le";
            assert!(crate::fixtures::ffmpeg(&format!("{input} {colors}"), &file));
            let (frame, _) = good(&file, Use::Color(16), PATIENCE).next().unwrap().color();
            let apart = frame.pixels[70].map(|level| level.abs_diff(shown)).into_iter().max();
            assert!((frame.width, frame.height) == (16, 8) && apart <= Some(4), "{transfer}: {:?}", frame.pixels[70]);
            let gray = good(&file, Use::Gray, PATIENCE).next().unwrap().gray(1).gray;
            assert!(gray.pixels[70].abs_diff(128) <= 2);
        }
    }
}
