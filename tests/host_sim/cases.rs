//! Runs `tests/cases` and `host-sim/README.md`: command lines, each with the expected output of host-sim.
//!
//! The blocks ```console of a file run one after the other in a new folder. Below a line that begins with `$ ` stand the command's output, its
//! errors, and in brackets its exit code if that is not 0; `...` stands for anything. `printf TEXT > FILE`, `head -c BYTES FILE > FILE` and
//! `host-sim ... > FILE` make files, `mkdir` a folder, `cat FILE` and `ls DIR` show them. `SMR_RECORD=1 cargo test -p host-sim --test program cases` writes into the files what host-sim says now.

use crate::program::{PROGRAM, output};
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};

/// Resolves `\n`, `\r`, `\0` and `\xNN`; before any other character, the backslash is removed.
fn unescaped(text: &str) -> Vec<u8> {
    let (mut bytes, mut rest) = (Vec::new(), text.as_bytes());
    while let [first, after @ ..] = rest {
        rest = after;
        let byte = match (first, after) {
            (b'\\', [b'x', high, low, after @ ..]) => {
                rest = after;
                u8::from_str_radix(&format!("{}{}", char::from(*high), char::from(*low)), 16).expect("two digits")
            }
            (b'\\', [letter, after @ ..]) => {
                rest = after;
                match letter {
                    b'n' => b'\n',
                    b'r' => b'\r',
                    b'0' => 0,
                    other => *other,
                }
            }
            (other, _) => *other,
        };
        bytes.push(byte);
    }
    bytes
}

/// Runs a command in a folder; returns its output, its errors and its exit code.
fn said(command: &str, folder: &Path) -> String {
    let words = shlex::split(command).unwrap_or_else(|| panic!("`{command}` has an open quote"));
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["host-sim", ref arguments @ ..] => {
            let mut program = Command::new(PROGRAM);
            program.stdout(Stdio::piped());
            let arguments = match arguments {
                [arguments @ .., ">", file] => {
                    program.stdout(File::create(folder.join(file)).expect("a file can be made"));
                    arguments
                }
                all => all,
            };
            let said = output(program.args(arguments).current_dir(folder).env("COLUMNS", "120"));
            let code = said.status.code().filter(|code| *code != 0).map(|code| format!("[{code}]\n"));
            let [out, err] = [said.stdout, said.stderr].map(|text| String::from_utf8(text).expect("UTF-8"));
            out + &err + &code.unwrap_or_default()
        }
        ["mkdir", name] => {
            fs::create_dir(folder.join(name)).expect("a folder can be made");
            String::new()
        }
        ["printf", text, ">", file] => {
            fs::write(folder.join(file), unescaped(text)).expect("a file can be written");
            String::new()
        }
        ["head", "-c", count, from, ">", to] => {
            let mut bytes = Vec::new();
            let from = File::open(folder.join(from)).expect("a file");
            from.take(count.parse().expect("a number")).read_to_end(&mut bytes).expect("a file can be read");
            fs::write(folder.join(to), bytes).expect("a file can be written");
            String::new()
        }
        ["cat", file] => fs::read_to_string(folder.join(file)).expect("a text"),
        ["ls", path] => {
            let names =
                fs::read_dir(folder.join(path)).expect("a folder").map(|entry| entry.expect("a file").file_name());
            let mut names: Vec<_> = names.map(|name| name.into_string().expect("UTF-8") + "\n").collect();
            names.sort();
            names.concat()
        }
        _ => panic!("`{command}` is not known here"),
    }
}

/// Returns true if the whole `text` matches `pattern`, in which `...` stands for any characters or none.
fn fits(pattern: &str, text: &str) -> bool {
    let mut parts = pattern.split("...");
    let Some(mut rest) = text.strip_prefix(parts.next().unwrap_or_default()) else { return false };
    let mut parts = parts.peekable();
    while let Some(part) = parts.next() {
        let is_last = parts.peek().is_none();
        let place = if is_last { rest.len().checked_sub(part.len()) } else { rest.find(part) };
        match place.filter(|&place| rest.get(place..).is_some_and(|there| there.starts_with(part))) {
            Some(place) => rest = &rest[place + part.len()..],
            None => return false,
        }
    }
    rest.is_empty()
}

/// Returns the lines of `said`, but for a line that an expected one with `...` fits: that one stays.
fn recorded(said: &str, expected: &str) -> String {
    let line =
        |said| expected.lines().find(|line| *line != "..." && fits(line, said)).unwrap_or(said).to_owned() + "\n";
    said.lines().map(line).collect()
}

fn run(file: &Path) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let text = fs::read_to_string(file).expect("a file of cases");
    let (mut right, mut lines, mut is_inside) = (String::new(), text.lines().peekable(), false);
    while let Some(line) = lines.next() {
        right += line;
        right.push('\n');
        is_inside = if line.starts_with("```") { line == "```console" } else { is_inside };
        let Some(command) = line.strip_prefix("$ ").filter(|_| is_inside) else { continue };
        let mut expected = String::new();
        while let Some(line) = lines.next_if(|line| !line.starts_with("$ ") && !line.starts_with("```")) {
            expected += line;
            expected.push('\n');
        }
        let said = said(command, folder.path());
        right += &if fits(&expected, &said) { expected } else { recorded(&said, &expected) };
    }
    right
}

#[test]
fn host_sim_says_what_the_cases_say() {
    let host_sim = Path::new(env!("CARGO_MANIFEST_DIR"));
    let cases = fs::read_dir(host_sim.join("../tests/cases")).expect("cases");
    let mut files: Vec<_> = cases.map(|entry| entry.expect("a file").path()).collect();
    assert!(files.len() > 3);
    files.push(host_sim.join("README.md"));
    std::thread::scope(|scope| {
        for file in &files {
            scope.spawn(move || {
                let (is, right) = (fs::read_to_string(file).expect("a file of cases"), run(file));
                if std::env::var_os("SMR_RECORD").is_some() {
                    fs::write(file, right).expect("a file can be written");
                } else if let Some((is, right)) = is.lines().zip(right.lines()).find(|(is, right)| is != right) {
                    panic!("{}: expected\n{is}\nhost-sim says\n{right}", file.display());
                } else {
                    assert_eq!(is.lines().count(), right.lines().count(), "{}", file.display());
                }
            });
        }
    });
}

#[test]
fn what_is_recorded_keeps_its_patterns() {
    assert_eq!(recorded("version 2, 3 frames\nnew\n", "...\nversion ..., 3 frames\n"), "version ..., 3 frames\nnew\n");
}

#[test]
fn a_pattern_fits_what_has_its_parts_in_their_order() {
    for (pattern, text, expected) in [
        ("a\n", "a\n", true),
        ("a\n", "ab\n", false),
        ("a...c\n", "abc\n", true),
        ("a...\n", "b\n", false),
        ("a...b...c\n", "a c b c\n", true),
        ("a...b...c\n", "a c c\n", false),
        ("...\n", "a\nb\n", true),
        ("a...a\n", "a\n", false),
    ] {
        assert_eq!(fits(pattern, text), expected, "{pattern:?} {text:?}");
    }
}
