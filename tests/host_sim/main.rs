//! Runs the program host-sim as users do. All tests are in one test program, so that they run in parallel.

mod answers;
mod browser;
#[path = "../markdown.rs"]
mod markdown;
#[path = "../missing.rs"]
mod missing;
mod program;

#[cfg(unix)]
mod cases;
mod choice;
mod command_line;
mod documents;
#[cfg(unix)]
mod endurance;
mod environment;
mod exported_videos;
mod ffmpeg;
mod figures;
mod live;
mod replay;
mod report;
mod view;
