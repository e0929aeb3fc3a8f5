//! The program `host-sim`. Exit codes: 0 success, 1 a check failed, 2 bad usage or input.

use std::process::ExitCode;

fn main() -> ExitCode {
    host_sim::command::run()
}
