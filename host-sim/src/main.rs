//! Entry point of `host-sim`; all other code is in its library.

use std::process::ExitCode;

fn main() -> ExitCode {
    host_sim::command::run()
}
