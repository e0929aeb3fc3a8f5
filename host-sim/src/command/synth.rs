//! Writes the built-in recording out as files, so that other tools can be fed the same pixels.

use super::places::Places;
use super::{Outcome, tell};
use crate::export::{Format, Writer};
use crate::sequence::synthetic;
use anyhow::Result;
use serde_json::json;
use std::io::Write;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Synth {
    /// The folder to write to; made if it is not there, and refused if there is something in it
    out: PathBuf,
    /// Pictures (00001.png ...) or one file (synthetic.y4m, synthetic.raw, synthetic.h)
    #[arg(long, value_enum, default_value = "png")]
    format: Format,
    /// Print a JSON object instead of a line
    #[arg(long)]
    json: bool,
}

impl Synth {
    /// What is read and written.
    pub fn places(&self) -> Places<'_> {
        Places::default().writes("OUT", Some(&self.out))
    }

    /// Writes the frames, and their boxes in TLD form.
    pub fn run(self) -> Result<Outcome> {
        write(&self.out, self.format)?;
        let (width, height, length) = (synthetic::WIDTH, synthetic::HEIGHT, synthetic::LENGTH);
        let hint =
            if self.format == Format::Raw { format!(", read with --size {width}x{height}") } else { String::new() };
        let report = json!({
            "version": env!("CARGO_PKG_VERSION"), "sequence": synthetic::NAME, "out": self.out, "format": self.format.name(),
            "frames": length, "width": width, "height": height, "boxes": ["init.txt", "gt.txt"],
        });
        let out = self.out.display();
        tell(self.json, &report, |_, to| {
            writeln!(to, "{out}: {length} frames of {width}x{height}{hint}; init.txt, gt.txt")
        })?;
        Ok(Outcome::Holds)
    }
}

fn write(out: &Path, format: Format) -> Result<()> {
    let truth: Vec<_> = (0..synthetic::LENGTH).map(synthetic::truth).collect();
    let mut writer = Writer::in_folder(out, format, synthetic::NAME, truth[0])?;
    for frame in synthetic::frames() {
        writer.frame(&frame)?;
    }
    writer.finish(Some(&truth))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::{self, OpenOptions};
    use std::fs;

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
