//! `host-sim convert`: writes a recording as files for other programs or for replay in firmware.

use super::paths::{Places, Taken};
use super::recording_options::RecordingOptions;
use super::{Outcome, progress, tell};
use anyhow::{Result, bail, ensure};
use serde::Serialize;
use smr_files::messages::choice_name;
use smr_files::output::complain;
use smr_pages::export::{Format, Writer, Written, is_whole};
use smr_recordings::{BoundingBox, Sequence, misfit};
use std::io::Write;
use std::path::PathBuf;

const TAKEN: Taken = Taken { endings: [&Format::OF_FILES, &[]], is_folder: true };

#[derive(Debug, clap::Args)]
pub struct Convert {
    /// The recording
    #[arg(value_name = "SEQ")]
    sequence: PathBuf,
    /// The file or folder to write; a folder must be new or empty
    #[arg(long, short, value_name = "OUT")]
    out: PathBuf,
    /// The format of the frames, or a toolkit's layout [default: by the extension of OUT, else png]
    ///
    /// png, pgm, y4m, raw, h and vot keep every pixel. otb and got10k write JPEG of the best quality, because their toolkits read nothing
    /// else. vot, otb and got10k write one sequence into the folder OUT and need ground truth for every frame; otherwise host-sim writes
    /// only the initial box and says so. vot and got10k add the name of OUT to list.txt beside it, which their toolkits read. If OUT is in
    /// a folder called sequences, vot also writes config.yaml above that folder, unless it exists: a workspace of the VOT toolkit.
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Print a JSON object instead of a line
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recording: RecordingOptions,
}

#[derive(Serialize)]
struct Converted {
    version: &'static str,
    sequence: String,
    out: String,
    format: String,
    #[serde(flatten)]
    written: Written,
    /// Initial box of the target; null if unknown.
    init: Option<BoundingBox>,
}

impl Convert {
    pub fn run(self) -> Result<Outcome> {
        // For a toolkit (VOT, OTB, GOT-10k) `--out` is a folder, which may have any name and extension.
        let is_folder = self.format.is_some_and(Format::needs_boxes);
        let places = Places::of([&self.sequence]);
        places.writes("--out", Some(&self.out), (!is_folder).then_some(TAKEN)).check()?;
        let format = self.format()?;
        let Sequence { name, frames, length, init, truth, .. } = self.recording.open(&self.sequence)?;
        ensure!(
            !format.needs_boxes() || init.is_some(),
            "{name}: --format {} needs the box of the target in the first frame: give --init X,Y,W,H",
            choice_name(&format)
        );
        // Toolkits (VOT, OTB, GOT-10k) name a sequence after its folder.
        let own = if format.needs_boxes() { self.out.file_name() } else { self.out.file_stem() };
        let own = own.filter(|_| format.needs_boxes() || Format::of_file(&self.out).is_some());
        let title = own.map_or_else(|| name.clone(), |own| own.to_string_lossy().into_owned());
        let mut writer = Writer::create(&self.out, format, &title, init)?;
        let bar = progress::bar(&name, length);
        for frame in frames {
            writer.frame(&frame?.gray)?;
            bar.inc();
        }
        bar.clear();
        let written = writer.finish(truth.as_deref())?;
        let whole = truth.as_ref().is_some_and(|truth| is_whole(truth, written.frames));
        if format.needs_boxes() && !whole {
            let misfit = truth.and_then(|boxes| misfit(written.frames, boxes.len()));
            let why = misfit.unwrap_or_else(|| "no ground truth for each frame".to_owned());
            complain(&format!("note: {name}: {why}: only the initial box is written"));
        }
        let report = Converted {
            version: env!("CARGO_PKG_VERSION"),
            sequence: name,
            out: self.out.display().to_string(),
            format: choice_name(&format),
            written,
            init,
        };
        tell(self.json, &report, |report, out| out.write_all(line(report).as_bytes()))?;
        Ok(Outcome::Holds)
    }

    fn format(&self) -> Result<Format> {
        let of_file = Format::of_file(&self.out);
        let format = self.format.or(of_file).unwrap_or(Format::Png);
        if of_file.is_some_and(|of_file| of_file != format) {
            let (name, out) = (choice_name(&format), self.out.display());
            bail!("--format {name} into {out}: expected a folder, or a file with the extension of the format");
        }
        Ok(format)
    }
}

fn line(Converted { out, written, format, init, .. }: &Converted) -> String {
    let Written { frames, width, height, bytes, boxes, list, config } = written;
    let mut line = format!("{out}: {frames} frames of {width}x{height}, {bytes} bytes");
    if format == "raw" {
        line += &format!(", read with --size {width}x{height}");
    }
    if !boxes.is_empty() {
        line += &format!("; {}", boxes.join(", "));
    } else if let Some(init) = init {
        line += &format!("; it starts with --init {init}");
    }
    let files = [("added to", list), ("workspace", config)];
    for (relation, file) in files.iter().filter_map(|(relation, file)| Some((relation, file.as_ref()?))) {
        line += &format!("; {relation} {}", file.display());
    }
    line + "\n"
}
