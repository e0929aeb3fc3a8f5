//! `host-sim trax`: a tracker behind the TraX protocol, as the VOT toolkit and others run it.

use super::Outcome;
use super::number::whole;
use super::tracker_options::TrackerOptions;
use crate::trax::{PROTOCOLS, Server, serve};
use anyhow::Result;
use smr_evaluation::MethodKind;
use std::io::{stdin, stdout};

#[derive(Debug, clap::Args)]
#[command(after_help = "Example, a section of the VOT toolkit's trackers.ini:
  [smr_robust]
  protocol = trax
  command = host-sim trax --method robust")]
pub struct Trax {
    /// How the target is followed
    #[arg(long, value_enum, default_value = "smr")]
    method: MethodKind,
    /// The version of the protocol to begin with; clients of version 4 also speak the earlier ones
    #[arg(long, value_name = "VERSION", default_value_t = *PROTOCOLS.end(), value_parser = whole::<u8>(1..=4))]
    protocol: u8,
    #[command(flatten)]
    tracker: TrackerOptions,
}

impl Trax {
    pub fn run(self) -> Result<Outcome> {
        let variant = self.tracker.variant(self.method)?;
        // What is wrong with the options is said before the session.
        variant.build()?;
        let options: Vec<String> =
            variant.origin().options.iter().map(|(name, value)| format!(" --{name} {value}")).collect();
        let server = Server {
            name: self.method.name().to_owned(),
            description: format!("smr, method {}{}", self.method.name(), options.concat()),
            protocol: self.protocol,
            build: || variant.build(),
        };
        serve(&server, stdin().lock(), stdout().lock())?;
        Ok(Outcome::Holds)
    }
}
