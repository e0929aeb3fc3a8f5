//! Writes the built-in recording out as files, so that other tools can be fed the same pixels.

use super::Outcome;
use crate::output::{Folder, print};
use crate::sequence::{GrayFrame, boxes, synthetic};
use anyhow::{Context, Result, bail};
use image::{ColorType, ImageFormat};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Synth {
    /// The folder to write to; made if it is not there, and refused if there is something in it
    out: PathBuf,
    /// Pictures (00001.png ...) or one file (synthetic.y4m, synthetic.raw)
    #[arg(long, value_enum, default_value_t = Format::Png)]
    format: Format,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    Png,
    Pgm,
    Y4m,
    Raw,
}

impl Synth {
    /// Writes the frames, and their boxes in TLD form.
    pub fn run(self) -> Result<Outcome> {
        write(&self.out, self.format)?;
        let (width, height, length) = (synthetic::WIDTH, synthetic::HEIGHT, synthetic::LENGTH);
        let hint =
            if self.format == Format::Raw { format!(", read with --size {width}x{height}") } else { String::new() };
        let out = self.out.display();
        print(|to| writeln!(to, "{out}: {length} frames of {width}x{height}{hint}; init.txt, gt.txt"))?;
        Ok(Outcome::Holds)
    }
}

fn write(out: &Path, format: Format) -> Result<()> {
    // Files already there would become part of the recording, or be lost.
    let folder = Folder::create(out)?;
    write_files(folder.path(), format)?;
    folder.finish()
}

fn write_files(out: &Path, format: Format) -> Result<()> {
    match format {
        Format::Png => write_pictures(out, "png", ImageFormat::Png),
        Format::Pgm => write_pictures(out, "pgm", ImageFormat::Pnm),
        Format::Y4m => write_file(&out.join("synthetic.y4m"), write_y4m),
        Format::Raw => write_file(&out.join("synthetic.raw"), write_raw),
    }?;
    write_boxes(out)
}

fn write_pictures(out: &Path, extension: &str, format: ImageFormat) -> Result<()> {
    for (number, frame) in (1..).zip(synthetic::frames()) {
        let file = out.join(format!("{number:05}.{extension}"));
        let GrayFrame { width, height, pixels } = frame;
        image::save_buffer_with_format(&file, &pixels, width.into(), height.into(), ColorType::L8, format)
            .with_context(|| cannot_write(&file))?;
    }
    Ok(())
}

fn write_file(file: &Path, write: fn(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    let create = || {
        let mut out = BufWriter::new(File::create(file)?);
        write(&mut out)?;
        anyhow::Ok(out.flush()?)
    };
    create().with_context(|| cannot_write(file))
}

fn write_raw(out: &mut BufWriter<File>) -> Result<()> {
    for frame in synthetic::frames() {
        out.write_all(&frame.pixels)?;
    }
    Ok(())
}

fn write_y4m(out: &mut BufWriter<File>) -> Result<()> {
    let (width, height) = (synthetic::WIDTH.into(), synthetic::HEIGHT.into());
    let header = y4m::encode(width, height, y4m::Ratio::new(25, 1)).with_colorspace(y4m::Colorspace::Cmono);
    let mut encoder = header.write_header(out)?;
    for frame in synthetic::frames() {
        encoder.write_frame(&y4m::Frame::new([&frame.pixels, &[], &[]], None))?;
    }
    Ok(())
}

fn write_boxes(out: &Path) -> Result<()> {
    let lines = (0..synthetic::LENGTH).map(|index| boxes::tld_line(synthetic::truth(index).as_ref()) + "\n");
    let truth: String = lines.collect();
    let Some(init) = truth.lines().next() else { bail!("the recording has no first frame") };
    for (name, text) in [("init.txt", &format!("{init}\n")), ("gt.txt", &truth)] {
        let file = out.join(name);
        fs::write(&file, text).with_context(|| cannot_write(&file))?;
    }
    Ok(())
}

fn cannot_write(file: &Path) -> String {
    format!("cannot write {}", file.display())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::{self, OpenOptions};

    fn reads_back(format: Format, size: Option<(u16, u16)>) {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("new").join("folder");
        write(&out, format).unwrap();
        let read = sequence::open(&out, &OpenOptions { size, ..OpenOptions::default() }).unwrap();
        let made = sequence::open(Path::new(synthetic::NAME), &OpenOptions::default()).unwrap();
        assert_eq!((read.name.as_str(), read.init, read.truth), ("folder", made.init, made.truth));
        assert!(read.length.is_none_or(|length| length == synthetic::LENGTH));
        assert!(read.frames.map(Result::unwrap).eq(synthetic::frames()));
    }

    #[test]
    fn every_format_reads_back_bit_identical() {
        reads_back(Format::Png, None);
        reads_back(Format::Pgm, None);
        reads_back(Format::Y4m, None);
        reads_back(Format::Raw, Some((synthetic::WIDTH, synthetic::HEIGHT)));
    }

    #[test]
    fn a_folder_in_use_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("notes.txt"), "mine").unwrap();
        let error = format!("{:#}", write(folder.path(), Format::Raw).unwrap_err());
        assert_eq!(error, format!("{} is not empty: expected an empty or a new folder", folder.path().display()));
        let error = format!("{:#}", write(&folder.path().join("notes.txt"), Format::Raw).unwrap_err());
        assert!(error.starts_with("cannot make the folder"), "{error}");
    }
}
