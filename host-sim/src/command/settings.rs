//! A file of tracker settings, put into the command line that names it: `--settings FILE`.
//!
//! The file is TOML. Its keys are the names of tracker options without their dashes, and `method`; as JSON results hold them in `options`, so that
//! a result can be run again:
//!
//! ```toml
//! method = "robust"
//! without = ["sweep", "velocity"]
//! ```

use super::{HostSim, bad_value};
use anyhow::{Context, Result, anyhow, bail};
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Command, CommandFactory};
use smr_recordings::input;
use std::ffi::OsString;
use std::path::PathBuf;
use toml::{Table, Value};

/// The command line `given` with the settings of the file that it names, after the command. If clap refuses it, it is left as it is.
/// Errors: The file cannot be read, is not TOML, or holds what is no tracker option of the command.
pub fn arguments(given: Vec<OsString>) -> Result<Vec<OsString>> {
    let command = HostSim::command();
    let Ok(matches) = command.clone().try_get_matches_from(&given) else { return Ok(given) };
    let Some((name, of_command)) = matches.subcommand() else { return Ok(given) };
    let Some(file) = of_command.get_one::<PathBuf>("settings").or_else(|| matches.get_one("settings")) else {
        return Ok(given);
    };
    let text = input::text(file, &input::SETTINGS).with_context(|| format!("cannot read {}", file.display()))?;
    let subcommand = command.find_subcommand(name).context("clap matches commands that there are")?;
    let settings = options(&text, subcommand, of_command).with_context(|| file.display().to_string())?;
    // Options of the command stand after its name, which the file may have, too.
    let named = (1..given.len()).find(|&at| given[at] == name && given[at - 1] != "--settings");
    let (before, after) = given.split_at(named.map_or(given.len(), |at| at + 1));
    Ok([before, &settings, after].concat())
}

/// The settings as options, but for those that are given on the command line.
fn options(text: &str, command: &Command, given: &ArgMatches) -> Result<Vec<OsString>> {
    let table: Table = text.parse().map_err(|error: toml::de::Error| at_line(text, &error))?;
    let mut options = Vec::new();
    for (key, value) in &table {
        let argument =
            command.get_arguments().find(|argument| argument.get_long() == Some(key) && is_setting(argument));
        let argument = argument.with_context(|| {
            let known: Vec<_> = command.get_arguments().filter(|argument| is_setting(argument)).collect();
            let known: Vec<_> = known.iter().filter_map(|argument| argument.get_long()).collect();
            let name = command.get_name();
            if known.is_empty() {
                format!("`{name}` runs no tracker: expected a command with tracker options")
            } else {
                format!("{key} is no tracker option of `{name}`: expected {}", known.join(", "))
            }
        })?;
        let option = option(key, value, argument)?;
        if let Some(option) = &option {
            check(argument, option)?;
        }
        if given.value_source(argument.get_id().as_str()) != Some(ValueSource::CommandLine) {
            options.extend(option);
        }
    }
    Ok(options)
}

/// Errors: The option does not take its value.
fn check(argument: &Arg, option: &OsString) -> Result<()> {
    let alone = Command::new("settings").no_binary_name(true).arg(argument.clone());
    let error = alone.try_get_matches_from([option]).err();
    let said = error.map(|error| bad_value(&error).unwrap_or_else(|| error.to_string()));
    said.map_or(Ok(()), |said| Err(anyhow!(said.trim_start_matches("--").to_owned())))
}

fn is_setting(argument: &Arg) -> bool {
    let of_tracker = argument.get_help_heading().is_some_and(|heading| heading.starts_with("Tracker"));
    of_tracker || argument.get_long() == Some("method")
}

fn option(key: &str, value: &Value, argument: &Arg) -> Result<Option<OsString>> {
    let is_flag = !argument.get_action().takes_values();
    Ok(match value {
        Value::Boolean(true) if is_flag => Some(format!("--{key}").into()),
        Value::Boolean(false) if is_flag => None,
        _ if is_flag => bail!("{key}: expected true or false"),
        value => {
            let values = value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
            let text = |value: &Value| match value {
                Value::String(text) => Ok(text.clone()),
                Value::Integer(number) => Ok(number.to_string()),
                Value::Float(number) => Ok(number.to_string()),
                _ => Err(anyhow!("{key}: expected a string or a number")),
            };
            let values: Result<Vec<String>> = values.iter().map(text).collect();
            Some(format!("--{key}={}", values?.join(",")).into())
        }
    })
}

/// In one line, as all errors are.
fn at_line(text: &str, error: &toml::de::Error) -> anyhow::Error {
    let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or("");
    let line = before.matches('\n').count() + 1;
    if error.message().starts_with("duplicate key") {
        return anyhow!("line {line}: expected TOML: the name at its beginning stands in an earlier line, too");
    }
    anyhow!("line {line}: expected TOML: a line like growth = 2, window = \"20x16\" or exhaustive = true")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn with(text: &str, line: &[&str]) -> Result<Vec<String>> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("track");
        fs::write(&file, text).unwrap();
        let file = file.to_str().unwrap();
        let given = line.iter().map(|word| word.replace("FILE", file));
        let whole = arguments(given.map(OsString::from).collect());
        let words = whole.map_err(|error| anyhow!("{}", format!("{error:#}").replace(file, "FILE")))?;
        Ok(words.into_iter().map(|word| word.into_string().unwrap().replace(file, "FILE")).collect())
    }

    const SETTINGS: &str =
        "# fast\nmethod = \"smr\"\nwindow = \"9x8\"\ngrowth = 2\nexhaustive = true\nrunner-up-always = false\n";

    #[test]
    fn settings_become_options_after_the_command() {
        let words = with(SETTINGS, &["host-sim", "--settings", "FILE", "track", "SEQ", "--window=3x3", "--", "x"]);
        // One operand too many: clap says so.
        assert_eq!(words.unwrap().len(), 8);
        let expected = "host-sim --settings FILE track --exhaustive --growth=2 --method=smr SEQ --window=3x3";
        let words = with(SETTINGS, &["host-sim", "--settings", "FILE", "track", "SEQ", "--window=3x3"]).unwrap();
        assert_eq!(words.join(" "), expected);
        let parts =
            with("without = [\"velocity\", \"sweep\"]", &["host-sim", "track", "--settings=FILE", "SEQ"]).unwrap();
        assert_eq!(parts.join(" "), "host-sim track --without=velocity,sweep --settings=FILE SEQ");
        let none = with(SETTINGS, &["host-sim", "track", "SEQ"]).unwrap();
        assert_eq!(none.join(" "), "host-sim track SEQ");
    }

    #[test]
    fn what_is_no_setting_is_named() {
        for (text, expected) in [
            ("colour = 1", "FILE: colour is no tracker option of `track`: expected method, config, window"),
            ("out = \"x\"", "FILE: out is no tracker option of `track`: expected "),
            ("a = 1\nb = = 2\n", "FILE: line 2: expected TOML: "),
            ("exhaustive = 1", "FILE: exhaustive: expected true or false"),
            ("window = [[1]]", "FILE: window: expected a string or a number"),
        ] {
            let error = with(text, &["host-sim", "track", "--settings", "FILE", "SEQ"]).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{text}: {error}");
            assert_eq!(error.lines().count(), 1);
        }
        let error =
            with("k = \"1/4\"", &["host-sim", "replay", "RECORD", "--settings", "FILE"]).unwrap_err().to_string();
        assert_eq!(error, "FILE: `replay` runs no tracker: expected a command with tracker options");
        let error = with("", &["host-sim", "track", "SEQ", "--settings", "missing.toml"]).unwrap_err().to_string();
        assert!(error.starts_with("cannot read missing.toml: "), "{error}");
    }
}
