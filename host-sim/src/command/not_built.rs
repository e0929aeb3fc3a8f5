//! In the place of a command that this program was built without: says how to get it.

use super::Outcome;
use anyhow::{Result, bail};
use std::ffi::OsString;

/// A command that needs the feature `emulator`.
#[derive(Debug, clap::Args)]
#[command(disable_help_flag = true)]
pub struct NotBuilt {
    /// Whatever the command would take, `--help` included.
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _arguments: Vec<OsString>,
}

impl NotBuilt {
    pub fn run(self) -> Result<Outcome> {
        bail!(
            "this command is not built into this program, so that the program builds quickly: \
             expected `cargo run --release -p host-sim --features emulator -- ...`"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        command: NotBuilt,
    }

    #[test]
    fn whatever_is_given_the_answer_is_how_to_get_the_command() {
        for arguments in [&["run"][..], &["run", "--help"], &["run", "f.elf", "--machine", "virt", "--", "-x"]] {
            let error = Line::try_parse_from(arguments).unwrap().command.run().unwrap_err().to_string();
            assert!(error.contains("cargo run --release -p host-sim --features emulator -- "), "{error}");
        }
    }
}
