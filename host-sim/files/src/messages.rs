//! Messages for people: errors in plain words, without control characters, and the names of command-line choices.

use clap::ValueEnum;
use std::io::{self, ErrorKind};

pub fn choice_name<T: ValueEnum>(choice: &T) -> String {
    choice.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

pub fn of(error: &anyhow::Error) -> String {
    let words = error.chain().map(|cause| cause.downcast_ref().map_or_else(|| cause.to_string(), of_io));
    words.collect::<Vec<_>>().join(": ")
}

/// Returns an I/O error in plain words, without the system's error code.
pub fn of_io(error: &io::Error) -> String {
    let words = match error.kind() {
        ErrorKind::NotFound => "there is no such file",
        ErrorKind::PermissionDenied => "this user has no permission to open it",
        ErrorKind::NotADirectory => "it, or a part of its path, is not a folder",
        ErrorKind::IsADirectory => "it is a folder: expected a file",
        ErrorKind::AlreadyExists => "a file or folder of that name exists: expected another name",
        ErrorKind::DirectoryNotEmpty => "it is no longer empty: expected an empty or a new folder",
        ErrorKind::BrokenPipe => "its reader has ended before all was written",
        ErrorKind::UnexpectedEof => "it ends too early",
        _ => {
            let text = error.to_string();
            return text.split(" (os error").next().unwrap_or(&text).to_owned();
        }
    };
    words.to_owned()
}

/// Escapes control characters except line ends and tabs, because the name of a file must not control a terminal.
pub fn plain(text: &str) -> String {
    written_out(text, |letter| letter == '\n' || letter == '\t')
}

/// Returns the text as one line, without the user names and passwords in URLs.
pub fn line(text: &str) -> String {
    let mut parts = text.split("://");
    let first = parts.next().unwrap_or_default().to_owned();
    let public = |part: &str| {
        let host = part.find(|letter: char| letter.is_whitespace() || "/?\"'".contains(letter)).unwrap_or(part.len());
        format!("://{}", &part[part[..host].rfind('@').map_or(0, |at| at + 1)..])
    };
    written_out(&parts.fold(first, |text, part| text + &public(part)), |_| false)
}

fn written_out(text: &str, stays: impl Fn(char) -> bool) -> String {
    let mut plain = String::with_capacity(text.len());
    for letter in text.chars() {
        if letter.is_control() && !stays(letter) {
            plain += &format!("\\u{:04x}", u32::from(letter));
        } else {
            plain.push(letter);
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context;

    #[test]
    fn control_characters_are_written_out() {
        assert_eq!(plain("a\u{1b}[2Jb\r\nü\u{9b}\u{7f}"), "a\\u001b[2Jb\\u000d\nü\\u009b\\u007f");
        assert_eq!((line("a\nb\t"), plain("a\tb")), ("a\\u000ab\\u0009".to_owned(), "a\tb".to_owned()));
        let json = serde_json::to_string("\u{1b}\u{9b}").unwrap();
        assert_eq!(serde_json::from_str::<String>(&plain(&json)).unwrap(), "\u{1b}\u{9b}");
    }

    #[test]
    fn no_number_and_no_name_of_the_system_is_left() {
        let missing = std::fs::read("no/such/file").context("cannot read no/such/file").unwrap_err();
        assert_eq!(of(&missing), "cannot read no/such/file: there is no such file");
        // ENOSPC: 28 on Linux, macOS and the BSDs.
        #[cfg(unix)]
        assert_eq!(of_io(&io::Error::from_raw_os_error(28)), "No space left on device");
        assert_eq!(of_io(&io::Error::new(ErrorKind::TimedOut, "our own words")), "our own words");
        assert_eq!(of(&anyhow::anyhow!("b").context("a")), "a: b");
    }
}
