//! `host-sim completions`: what a shell completes, made from the command line itself.

use super::{HostSim, Outcome, say};
use anyhow::Result;
use clap::CommandFactory;
use clap_complete::Shell;

#[derive(Debug, clap::Args)]
pub struct Completions {
    /// Which shell
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    pub fn run(self) -> Result<Outcome> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut HostSim::command(), "host-sim", &mut text);
        say(|out| std::io::Write::write_all(out, &text))?;
        Ok(Outcome::Holds)
    }
}
