//! Documents say what holds: their examples compile and run, their commands can be run, and their figures are those of
//! code and records.

mod commands;
mod examples;
mod figures;
