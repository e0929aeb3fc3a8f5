//! The method of a session of `view`, as words of a command line.

use super::tracker_options::TrackerOptions;
use super::usage;
use anyhow::Result;
use clap::{CommandFactory, Parser};
use serde_json::{Map, Value};
use smr_evaluation::{MethodKind, Variant};
use std::ffi::OsString;

/// The options of a method, as the page sends them.
#[derive(Parser)]
#[command(no_binary_name = true, name = "host-sim track")]
struct Line {
    #[arg(long, value_enum)]
    method: MethodKind,
    #[command(flatten)]
    tracker: TrackerOptions,
}

pub fn variant_of(method: &str, options: &Map<String, Value>) -> Result<Variant> {
    let words = [vec!["--method".into(), method.into()], typed(options)].concat();
    let Line { method, tracker } = Line::try_parse_from(&words)
        .map_err(|error| anyhow::anyhow!(usage::explained(&error, &Line::command(), &words)))?;
    tracker.variant(method)
}

pub fn typed(options: &Map<String, Value>) -> Vec<OsString> {
    let word = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let option = |(name, value): (&String, &Value)| {
        let values = value.as_array().map_or_else(|| std::slice::from_ref(value), Vec::as_slice);
        values.iter().flat_map(|value| [format!("--{name}"), word(value)]).collect::<Vec<_>>()
    };
    options.iter().flat_map(option).map(OsString::from).collect()
}
