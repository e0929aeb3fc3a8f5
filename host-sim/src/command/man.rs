//! `host-sim man`: pages of the manual, made from the command line itself.

use super::{HostSim, Outcome, say};
use anyhow::{Context, Result};
use clap::CommandFactory;
use clap_mangen::Man as Page;
use std::io::Write;

#[derive(Debug, clap::Args)]
pub struct Man {
    /// The page of this command [default: that of host-sim]
    command: Option<String>,
}

impl Man {
    pub fn run(self) -> Result<Outcome> {
        let mut all = HostSim::command();
        all.build();
        let page = match &self.command {
            None => Page::new(all),
            Some(name) => {
                let names = || all.get_subcommands().map(clap::Command::get_name).collect::<Vec<_>>().join(", ");
                let found = all
                    .find_subcommand(name)
                    .with_context(|| format!("no command {name}: expected one of {}", names()))?;
                Page::new(found.clone())
            }
        };
        let mut text = Vec::new();
        page.render(&mut text).context("cannot make the page")?;
        say(|out| out.write_all(&text))?;
        Ok(Outcome::Holds)
    }
}
