//! A recording as files that this program, others, and firmware read.

use super::{c_array, pgm, png};
use crate::output::{Folder, Output};
use crate::sequence::{BoundingBox, GrayFrame, boxes};
use anyhow::Result;
use serde::Serialize;
use std::path::Path;

/// What frames are written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// A folder of PNG pictures, 00001.png ...
    Png,
    /// A folder of PGM pictures, 00001.pgm ...
    Pgm,
    /// One Y4M file, gray, 25 frames a second
    Y4m,
    /// One raw dump: 8-bit gray, row after row, frame after frame
    Raw,
    /// One C header with an array of frames
    H,
}

impl Format {
    /// As on the command line, and the usual extension of such a file.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Pgm => "pgm",
            Self::Y4m => "y4m",
            Self::Raw => "raw",
            Self::H => "h",
        }
    }

    /// True if it is one file, not one for each frame.
    #[must_use]
    pub const fn is_file(self) -> bool {
        matches!(self, Self::Y4m | Self::Raw | Self::H)
    }

    /// That of a file of this name, if the extension tells.
    #[must_use]
    pub fn of_file(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "y4m" => Some(Self::Y4m),
            "raw" | "gray" | "bin" | "y8" => Some(Self::Raw),
            "h" => Some(Self::H),
            _ => None,
        }
    }
}

/// A recording under way. Until [`Writer::finish`] nothing has its name.
pub struct Writer {
    name: String,
    format: Format,
    start: Option<BoundingBox>,
    place: Place,
    written: Written,
}

enum Place {
    /// One file alone.
    File(Output),
    /// A folder with one file for the frames.
    FileIn(Folder, Output),
    /// A folder of pictures.
    Pictures(Folder),
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Written {
    pub frames: usize,
    /// Of a frame; 0 before the first one.
    pub width: u16,
    pub height: u16,
    /// Of all frames, with the headers of their format.
    pub bytes: u64,
    /// The files with boxes, beside the frames.
    pub boxes: Vec<&'static str>,
}

impl Writer {
    /// Begins the recording called `name`: a file alone if `out` has the extension of one, else a folder, in which there will be boxes, too.
    ///
    /// # Errors
    /// It cannot be written there, or the folder is not empty.
    pub fn create(out: &Path, format: Format, name: &str, start: Option<BoundingBox>) -> Result<Self> {
        if Format::of_file(out) != Some(format) {
            return Self::in_folder(out, format, name, start);
        }
        Ok(Self::new(format, name, start, Place::File(Output::create(out)?)))
    }

    /// Begins the recording called `name` in the folder `out`, in which there will be boxes, too.
    ///
    /// # Errors
    /// It cannot be written there, or the folder is not empty.
    pub fn in_folder(out: &Path, format: Format, name: &str, start: Option<BoundingBox>) -> Result<Self> {
        // Files already there would become part of the recording, or be lost.
        let folder = Folder::create(out)?;
        let place = if format.is_file() {
            let file = folder.file(&format!("{name}.{}", format.name()))?;
            Place::FileIn(folder, file)
        } else {
            Place::Pictures(folder)
        };
        Ok(Self::new(format, name, start, place))
    }

    fn new(format: Format, name: &str, start: Option<BoundingBox>, place: Place) -> Self {
        Self { name: name.to_owned(), format, start, place, written: Written::default() }
    }

    /// Writes the next frame.
    ///
    /// # Errors
    /// The disk's.
    pub fn frame(&mut self, frame: &GrayFrame) -> Result<()> {
        let bytes = match self.format {
            Format::Png => png(frame)?,
            Format::Pgm => pgm(frame),
            Format::Y4m => [b"FRAME\n", &frame.pixels[..]].concat(),
            Format::Raw => frame.pixels.clone(),
            Format::H => c_array::element(frame).into_bytes(),
        };
        if self.written.frames == 0 {
            (self.written.width, self.written.height) = (frame.width, frame.height);
            self.text(&match self.format {
                Format::Y4m => format!("YUV4MPEG2 W{} H{} F25:1 Ip A1:1 Cmono\n", frame.width, frame.height),
                Format::H => c_array::head(&self.name, frame, self.start.as_ref()),
                _ => String::new(),
            })?;
        }
        self.written.frames += 1;
        self.written.bytes += bytes.len() as u64;
        match &mut self.place {
            Place::File(file) | Place::FileIn(_, file) => file.write(&bytes),
            Place::Pictures(folder) => {
                let name = format!("{:05}.{}", self.written.frames, self.format.name());
                folder.write(&name, &bytes)
            }
        }
    }

    /// Before or after all frames; pictures have no such text.
    fn text(&mut self, text: &str) -> Result<()> {
        self.written.bytes += text.len() as u64;
        match &mut self.place {
            Place::File(file) | Place::FileIn(_, file) => file.write(text.as_bytes()),
            Place::Pictures(_) => Ok(()),
        }
    }

    /// Ends it. Into a folder go `init.txt` and, where there is ground truth, `gt.txt`, both in TLD form.
    ///
    /// # Errors
    /// The disk's.
    pub fn finish(mut self, truth: Option<&[Option<BoundingBox>]>) -> Result<Written> {
        if self.format == Format::H && self.written.frames > 0 {
            let foot = c_array::foot(&self.name);
            self.text(&foot)?;
        }
        let Self { start, place, mut written, .. } = self;
        let folder = match place {
            Place::File(file) => {
                file.finish()?;
                return Ok(written);
            }
            Place::FileIn(folder, file) => {
                file.finish()?;
                folder
            }
            Place::Pictures(folder) => folder,
        };
        let line = |entry: &Option<BoundingBox>| boxes::Form::Tld.line(entry.as_ref()) + "\n";
        let init = start.map(|start| line(&Some(start)));
        let truth = truth.map(|truth| truth.iter().map(line).collect::<String>());
        for (name, text) in [("init.txt", init), ("gt.txt", truth)] {
            if let Some(text) = text {
                folder.write(name, text.as_bytes())?;
                written.boxes.push(name);
            }
        }
        folder.finish()?;
        Ok(written)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::{self, OpenOptions, synthetic};
    use std::fs;

    const FORMATS: [Format; 4] = [Format::Png, Format::Pgm, Format::Y4m, Format::Raw];
    const FRAMES: usize = 5;

    fn truth() -> Vec<Option<BoundingBox>> {
        (0..FRAMES).map(synthetic::truth).collect()
    }

    fn written(out: &Path, format: Format) -> Written {
        let mut writer = Writer::create(out, format, "clip", truth()[0]).unwrap();
        for frame in synthetic::frames().take(FRAMES) {
            writer.frame(&frame).unwrap();
            assert!(!out.exists());
        }
        writer.finish(Some(&truth())).unwrap()
    }

    #[test]
    fn a_folder_reads_back_with_its_boxes() {
        for format in FORMATS {
            let above = tempfile::tempdir().unwrap();
            let out = above.path().join("clip");
            let written = written(&out, format);
            assert_eq!((written.frames, &written.boxes[..]), (FRAMES, &["init.txt", "gt.txt"][..]));
            let size = (format == Format::Raw).then_some((synthetic::WIDTH, synthetic::HEIGHT));
            let read = sequence::open(&out, &OpenOptions { size, ..OpenOptions::default() }).unwrap();
            assert_eq!((read.init, read.truth), (truth()[0], Some(truth())), "{format:?}");
            assert!(read.frames.map(Result::unwrap).eq(synthetic::frames().take(FRAMES)), "{format:?}");
        }
    }

    #[test]
    fn a_file_alone_reads_back() {
        let above = tempfile::tempdir().unwrap();
        for (name, format) in [("a.Y4M", Format::Y4m), ("b.gray", Format::Raw)] {
            let out = above.path().join(name);
            let written = written(&out, format);
            assert_eq!((written.bytes, written.boxes.len()), (fs::metadata(&out).unwrap().len(), 0));
            let size = (format == Format::Raw).then_some((synthetic::WIDTH, synthetic::HEIGHT));
            let read = sequence::open(&out, &OpenOptions { size, ..OpenOptions::default() }).unwrap();
            assert!(read.frames.map(Result::unwrap).eq(synthetic::frames().take(FRAMES)), "{format:?}");
        }
        assert_eq!(fs::read_dir(above.path()).unwrap().count(), 2, "nothing else is written");
    }

    #[test]
    fn a_c_array_holds_the_pixels() {
        let above = tempfile::tempdir().unwrap();
        let out = above.path().join("clip.h");
        let written = written(&out, Format::H);
        let text = fs::read_to_string(&out).unwrap();
        assert_eq!(written.bytes, text.len() as u64);
        let (head, array) = text.split_once("= {\n").unwrap();
        assert!(head.contains(&format!("#define CLIP_WIDTH {}\n", synthetic::WIDTH)), "{head}");
        let rect = truth()[0].unwrap().to_rect().unwrap();
        assert!(head.contains(&format!("#define CLIP_X {}\n", rect.x)), "{head}");
        let (array, foot) = array.split_once("};\n").unwrap();
        assert!(foot.contains("#define CLIP_FRAMES (sizeof clip / sizeof clip[0])"), "{foot}");
        let numbers = array.split(['{', '}', ',', '\n']).filter(|text| !text.is_empty());
        let pixels: Vec<u8> = numbers.map(|number| number.parse().unwrap()).collect();
        let expected: Vec<u8> = synthetic::frames().take(FRAMES).flat_map(|frame| frame.pixels).collect();
        assert!(pixels == expected);
    }

    #[test]
    fn what_breaks_off_leaves_nothing() {
        let above = tempfile::tempdir().unwrap();
        for (name, format) in [("a.y4m", Format::Y4m), ("folder", Format::Pgm), ("other", Format::Raw)] {
            let mut writer = Writer::create(&above.path().join(name), format, "clip", None).unwrap();
            writer.frame(&synthetic::frames().next().unwrap()).unwrap();
        }
        assert_eq!(fs::read_dir(above.path()).unwrap().count(), 0);
    }
}
