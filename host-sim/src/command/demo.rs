//! The first thing to run: follows the target of a built-in recording, writes a page, and says what to type next.

use super::paths::{Places, Taken};
use super::{Command, HostSim, Outcome, say};
use anyhow::Result;
use clap::Parser;
use smr_recordings::street;
use std::ffi::OsStr;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Demo {
    /// The page to write, or a folder for it
    #[arg(long, short, default_value = "smr-demo.html")]
    out: PathBuf,
}

impl Demo {
    pub fn places(&self) -> Places<'_> {
        Places::default().writes_as("--out", Some(&self.out), Taken::PAGE)
    }

    /// Runs `report`, as a user would type it.
    pub fn run(self) -> Result<Outcome> {
        let words = ["host-sim", "report", street::NAME, "--out"].map(OsStr::new);
        let line = HostSim::try_parse_from(words.into_iter().chain([self.out.as_os_str()]))?;
        let Command::Report(report) = line.command else { return Ok(Outcome::CheckFailed) };
        let outcome = report.run()?;
        // As `report` names it.
        let page = if self.out.is_dir() { self.out.join(format!("{}.html", street::NAME)) } else { self.out };
        // As it was typed, so that the lines below can be copied. cargo leaves a path like target/release/host-sim.
        let program = std::env::args().next().unwrap_or_else(|| "host-sim".to_owned());
        say(|out| {
            writeln!(
                out,
                "The trackers were locked on a car of the built-in recording `{}`: it passes behind a tree, turns, and meets\n\
                 another like it. Open {} in a browser to see which of them follows it.\n\n\
                 Your own video, in the browser or with a box to start from (left, top, width, height):\n  \
                 {program} view video.mp4    # drag a box, and it is followed\n  \
                 {program} track video.mp4 --init 150,100,40,48 --video boxes.mp4\n  \
                 {program} report video.mp4 --init 150,100,40,48 --out report.html\n\n\
                 All commands: {program} --help",
                street::NAME,
                page.display()
            )
        })?;
        Ok(outcome)
    }
}
