//! Tests of the program host-sim, run as its users do. One test program, so that all of its tests run side by side.

mod browser;
#[path = "../missing.rs"]
mod missing;
mod program;

#[cfg(unix)]
mod cases;
mod command_line;
#[cfg(unix)]
mod endurance;
mod figures;
mod live;
mod page;
mod readme_commands;
mod replay;
mod session;
mod targets;
mod view;
