//! One-line error for a bad command line: the wrong word, the expected form, and a suggestion that makes it valid.

use clap::Command;
use clap::error::{ContextKind, ContextValue, ErrorKind as Usage};
use std::error::Error;
use std::ffi::OsString;
use std::path::Path;

/// Separators in option values, and their names in messages.
const SEPARATORS: [(&str, &str); 4] = [(",", "commas"), ("x", "an x"), ("..", "two dots"), ("/", "a slash")];
/// Characters that users type in place of the right separator.
const TYPED: [&str; 11] = [" ", ";", ":", "*", "...", "..=", "-", "X", "x", ",", "/"];

/// Joins `--frames -5..` to one argument, because clap would parse `-5..` as an option.
pub(super) fn joined(arguments: Vec<OsString>) -> Vec<OsString> {
    let mut all: Vec<OsString> = Vec::new();
    let mut is_over = false;
    for argument in arguments {
        is_over |= argument == "--";
        let is_negative = matches!(argument.as_encoded_bytes(), [b'-', b'0'..=b'9', ..]);
        match all.last_mut() {
            Some(option) if is_negative && !is_over && is_long(&option.to_string_lossy()) => {
                option.push("=");
                option.push(argument);
            }
            _ => all.push(argument),
        }
    }
    all
}

fn is_long(word: &str) -> bool {
    word.len() > 2 && word.starts_with("--") && !word.contains('=')
}

/// Explains in one line why clap cannot parse `arguments`; `all` is the program's command with all subcommands.
pub(super) fn explained(error: &clap::Error, all: &Command, arguments: &[OsString]) -> String {
    let words = arguments.iter().flat_map(|word| {
        let word = word.to_string_lossy().into_owned();
        match word.split_once('=') {
            Some((option, value)) if is_long(option) => vec![option.to_owned(), value.to_owned()],
            _ => vec![word],
        }
    });
    let words: Vec<String> = words.collect();
    let command = words.iter().skip(1).find_map(|word| all.find_subcommand(word)).unwrap_or(all);
    let line = Line { error, all, command, words };
    line.explained().unwrap_or_else(|| {
        let text = error.render().to_string();
        text.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned()
    })
}

struct Line<'a> {
    error: &'a clap::Error,
    all: &'a Command,
    command: &'a Command,
    words: Vec<String>,
}

impl Line<'_> {
    fn explained(&self) -> Option<String> {
        let word = self.texts(ContextKind::InvalidArg).join(" and ");
        match self.error.kind() {
            Usage::InvalidSubcommand => self.no_command(),
            Usage::DisplayHelpOnMissingArgumentOrSubcommand | Usage::MissingSubcommand => {
                Some(format!("expected a command: {}", self.commands()))
            }
            Usage::InvalidValue | Usage::ValueValidation => self.bad_value(&word),
            Usage::UnknownArgument => Some(self.unknown(&word)),
            Usage::MissingRequiredArgument => {
                let (verb, usage) = (if word.contains(" and ") { "are" } else { "is" }, self.usage()?);
                Some(format!("{word} {verb} missing: expected {usage} ({} has examples)", self.help()))
            }
            Usage::TooManyValues => Some(format!("{word} takes no value: expected it alone")),
            Usage::ArgumentConflict => match self.texts(ContextKind::PriorArg).join(" and ") {
                same if same == word => Some(format!("{word} is given more than once: expected it once")),
                other => Some(format!("{word} does not go with {other}: expected one of them")),
            },
            _ => None,
        }
    }

    fn texts(&self, kind: ContextKind) -> Vec<String> {
        match self.error.get(kind) {
            Some(ContextValue::String(text)) => vec![text.clone()],
            Some(ContextValue::Strings(texts)) => texts.clone(),
            _ => Vec::new(),
        }
    }

    fn usage(&self) -> Option<String> {
        let Some(ContextValue::StyledStr(usage)) = self.error.get(ContextKind::Usage) else { return None };
        Some(usage.to_string().trim_start_matches("Usage: ").to_owned())
    }

    fn help(&self) -> String {
        let (program, command) = (self.all.get_name(), self.command.get_name());
        if program == command { format!("`{program} --help`") } else { format!("`{program} {command} --help`") }
    }

    fn commands(&self) -> String {
        self.all.get_subcommands().map(Command::get_name).collect::<Vec<_>>().join(", ")
    }

    fn no_command(&self) -> Option<String> {
        let word = self.texts(ContextKind::InvalidSubcommand).pop()?;
        let meant = self.texts(ContextKind::SuggestedSubcommand).join(" or ");
        let meant = if meant.is_empty() { String::new() } else { format!("; did you mean {meant}?") };
        Some(format!(
            "{}: there is no such file and no such command: expected a recording, or one of {}{meant}",
            shown(&word),
            self.commands()
        ))
    }

    fn bad_value(&self, argument: &str) -> Option<String> {
        let value = self.texts(ContextKind::InvalidValue).pop()?;
        // Shortens the name of an option for messages: `--size <WxH>` to `--size`.
        let name = argument.split(' ').next().filter(|name| name.starts_with('-')).unwrap_or(argument);
        let known = self.texts(ContextKind::ValidValue);
        let expected = match self.error.kind() {
            Usage::ValueValidation => self.error.source()?.to_string(),
            _ if !known.is_empty() => format!("expected one of {}", known.join(", ")),
            _ if name == argument => return Some(format!("{name} is empty: expected a name")),
            _ => return Some(format!("{name} has no value: expected {argument}")),
        };
        let option = self.words.windows(2).position(|pair| pair[0] == name && pair[1].contains(&value));
        let meant = option.and_then(|option| self.meant(option));
        let meant = meant.map_or(String::new(), |(_, _, meant)| format!("; did you mean {meant}?"));
        Some(format!("{name} {}: {expected}{meant}", shown(&value)))
    }

    fn unknown(&self, word: &str) -> String {
        let name = word.split('=').next().unwrap_or(word);
        let path = self.words.iter().find(|typed| typed.starts_with(word) && Path::new(typed).exists());
        if let Some(path) = path.filter(|path| path.starts_with('-')) {
            return format!("{path} looks like an option: expected ./{path}, if it is a file");
        }
        let is_first = self.words.get(1).is_some_and(|first| first == name) && name.starts_with('-');
        if is_first && self.all.has_subcommands() {
            return format!("{name} stands before the command: expected one of {} first", self.commands());
        }
        if !name.starts_with('-') || has(self.command, name) {
            return self.too_many(word);
        }
        let others: Vec<_> =
            self.all.get_subcommands().filter(|other| has(other, name)).map(Command::get_name).collect();
        let command = self.command.get_name();
        let prints = !has(self.command, "--out") && ["-o", "--out", "--output"].contains(&name);
        let meant = self.texts(ContextKind::SuggestedArg).join(" or ");
        let rest = match (others.is_empty(), meant.as_str()) {
            _ if prints && !has(self.command, "--no-open") => {
                "it prints to standard output: `> FILE` writes that to a file".to_owned()
            }
            (false, _) => format!("it belongs to {}", others.join(", ")),
            (true, "") => format!("{} lists those that it has", self.help()),
            (true, meant) => format!("did you mean {meant}?"),
        };
        format!("{command} has no option {name}: {rest}")
    }

    /// Error for a surplus word. It may belong to the value before it, or be a value whose option is missing.
    fn too_many(&self, word: &str) -> String {
        let at = self.words.iter().skip(1).position(|typed| typed == word).map_or(0, |at| at + 1);
        let option = self.words[..at].iter().rposition(|word| is_option(word));
        if let Some((typed, separator, meant)) = option.and_then(|option| self.meant(option)) {
            return format!("{typed}: expected one value, with {separator} and without blanks: {meant}");
        }
        let usage = self.usage().unwrap_or_else(|| self.all.get_name().to_owned());
        if let Some(command) = self.all.find_subcommand(word) {
            let name = self.all.get_name();
            return format!("{word} is a command: expected it first, as in {name} {}", command.get_name());
        }
        let rest = &self.words[at..];
        let with = |option: &str, value: String, of: usize| {
            let line = [&self.words[..at], &[option.to_owned(), value.clone()], &rest[of..]].concat();
            self.is_read(&line).then(|| format!("; did you mean {option} {}?", shown(&value)))
        };
        let numbers = rest.iter().take_while(|word| word.starts_with(|first: char| first.is_ascii_digit())).count();
        let is_new = !Path::new(word).exists() && Path::new(word).extension().is_some();
        let file = || is_new.then(|| with("--out", word.to_owned(), 1)).flatten();
        let meant = with("--init", rest[..numbers].join(","), numbers).or_else(file).unwrap_or_default();
        format!("{} is one word too many: expected {usage}{meant}", shown(word))
    }

    /// Returns a correction: the option as typed, the name of the right separator (`commas`), and the option corrected.
    fn meant(&self, option: usize) -> Option<(String, &'static str, String)> {
        let (before, after) = self.words.split_at(option + 1);
        let name = &self.words[option];
        let run = after.iter().take(8).take_while(|word| !is_option(word)).count();
        for count in (1..=run).rev() {
            let with = |value: &str| self.is_read(&[before, &[value.to_owned()], &after[count..]].concat());
            // An option that accepts even `?` accepts any text, so parsing cannot confirm a suggestion.
            if with("?") {
                return None;
            }
            let typed = after[..count].join(" ");
            let bare = typed.trim_matches(|letter| "()[]{}".contains(letter));
            for (from, (to, separator)) in TYPED.iter().flat_map(|from| SEPARATORS.map(|to| (from, to))) {
                // A single word is also tried with its separators unchanged: brackets or capitals may be its only
                // fault.
                let is_tried = bare.contains(from) || (*from == " " && count == 1);
                let is_in_name =
                    *from != " " && bare.match_indices(from).any(|(at, _)| bare[..at].ends_with(char::is_alphabetic));
                if !is_tried || is_in_name {
                    continue;
                }
                let blanks = if *from == " " { bare.to_owned() } else { bare.replace(' ', "") };
                for value in [blanks.replace(from, to), blanks.replace(from, to).to_lowercase()] {
                    let fewer = value.strip_suffix(to).filter(|fewer| typed.starts_with(*fewer) && with(fewer));
                    let value = fewer.map_or_else(|| value.clone(), str::to_owned);
                    let is_new = value != typed && !value.contains(&to.repeat(2));
                    if is_new && with(&value) {
                        return Some((format!("{name} {typed}"), separator, format!("{name} {}", shown(&value))));
                    }
                }
            }
        }
        None
    }

    fn is_read(&self, words: &[String]) -> bool {
        self.all.clone().try_get_matches_from(words).is_ok()
    }
}

fn is_option(word: &str) -> bool {
    matches!(word.as_bytes(), [b'-', b'-' | b'a'..=b'z' | b'A'..=b'Z', ..])
}

fn has(command: &Command, option: &str) -> bool {
    command.get_arguments().any(|argument| {
        argument.get_long().is_some_and(|long| option == format!("--{long}"))
            || argument.get_short().is_some_and(|short| option == format!("-{short}"))
    })
}

fn shown(value: &str) -> String {
    if value.is_empty() || value.contains(char::is_whitespace) { format!("{value:?}") } else { value.to_owned() }
}
