//! Checks that the commands in `core/EVIDENCE.md` and in other documents for maintainers can be run. The packages, test
//! programs, features, tests and scripts that they name must exist, and host-sim must accept the options given to it.
//! `host_sim/documents.rs` runs the commands of documents for users.

use super::root;
use crate::markdown;
use clap::CommandFactory;
use clap::error::ErrorKind;
use host_sim::command::HostSim;
use std::fs;
use std::path::{Path, PathBuf};

const DOCUMENTS: [&str; 6] = [
    "CONTRIBUTING.md",
    "core/EVIDENCE.md",
    "core/README.md",
    "host-sim/RESULTS.md",
    "host-sim/FAULTS.md",
    "tests/README.md",
];

fn commands(text: &str) -> Vec<&str> {
    let parts = markdown::code(text).map(|part| part.split("  #").next().unwrap_or(part).trim());
    let begins = ["cargo test ", "host-sim ", ".ci/", "FUZZ_"];
    parts.filter(|part| begins.iter().any(|begin| part.starts_with(begin)) && !part.contains("...")).collect()
}

fn packages() -> Vec<(PathBuf, String)> {
    let workspace = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let members = workspace.split_once("members = [").unwrap().1.split_once(']').unwrap().0;
    let folders = members.split('"').skip(1).step_by(2).map(|member| root().join(member));
    folders.map(|folder| (folder.clone(), fs::read_to_string(folder.join("Cargo.toml")).unwrap())).collect()
}

/// Returns all Rust of a folder as one text, with the file names.
fn sources(folder: &Path) -> String {
    let entries = fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path());
    let text = |path: PathBuf| match path.extension() {
        _ if path.is_dir() => format!("mod {} {}", path.file_name().unwrap().display(), sources(&path)),
        Some(ending) if ending == "rs" => {
            format!("mod {} {}", path.file_stem().unwrap().display(), fs::read_to_string(&path).unwrap())
        }
        _ => String::new(),
    };
    entries.filter(|path| !path.ends_with("target")).map(text).collect()
}

/// Returns an error if the arguments `words` of a `cargo test` name a package, feature, test or filter that does not
/// exist, or if they contain a second filter or an option that the `match` does not list.
fn cargo_test(words: &[&str], packages: &[(PathBuf, String)]) -> Result<(), String> {
    let mut words = words.iter().copied();
    let (mut package, mut test, mut features, mut filters) = (None, None, String::new(), Vec::new());
    while let Some(word) = words.next() {
        match word {
            "-p" => package = words.next(),
            "--test" => test = words.next(),
            "--features" => features = words.next().unwrap_or_default().to_owned(),
            "--all-features" => features = "*".to_owned(),
            "--lib" | "--locked" | "--tests" => {}
            "--" => filters.extend(words.by_ref().filter(|word| !word.starts_with('-'))),
            option if option.starts_with('-') => return Err(format!("the option {option} is not known here")),
            filter if filters.is_empty() => filters.push(filter),
            filter => return Err(format!("{filter} is one filter too many: cargo takes one")),
        }
    }
    let Some(package) = package else { return Ok(()) };
    let named = format!("\nname = \"{package}\"\n");
    let found = packages.iter().find(|(_, manifest)| manifest.contains(&named));
    let (folder, manifest) = found.ok_or_else(|| format!("there is no package {package}"))?;
    for feature in features.split(',').filter(|feature| !["", "*"].contains(feature)) {
        let is_there = manifest.contains(&format!("\n{feature} = "));
        is_there.then_some(()).ok_or_else(|| format!("{package} has no feature {feature}"))?;
    }
    let mut tests = vec![folder.join("src"), folder.join("tests")];
    if let Some(test) = test {
        let target = manifest.split("[[test]]").skip(1).find(|target| target.contains(&format!("name = \"{test}\"\n")));
        if let Some(target) = target.and_then(|target| target.split("\n[").next()) {
            let path = target.split("path = \"").nth(1).and_then(|path| path.split('"').next()).unwrap_or_default();
            tests = vec![folder.join(path).parent().unwrap().to_owned()];
        } else if !folder.join("tests").join(test).join("main.rs").is_file() {
            return Err(format!("{package} has no test {test}"));
        }
    }
    let text: String = tests.iter().map(|folder| sources(folder)).collect();
    // A filter may be a path of modules such as `track::tests`, so it is compared with the names after `fn` and `mod`.
    let is_end = |letter: char| !(letter.is_alphanumeric() || letter == '_');
    let named = ["fn ", "mod "].into_iter().flat_map(|what| text.split(what).skip(1));
    let known: Vec<&str> = named.filter_map(|rest| rest.split(is_end).next()).collect();
    let mut names = filters.iter().flat_map(|filter| filter.split("::"));
    let missing = names.find(|name| !known.iter().any(|known| known.contains(name)));
    missing.map_or(Ok(()), |name| Err(format!("no test of {package} is called {name}")))
}

fn refusal(command: &str, packages: &[(PathBuf, String)]) -> Result<(), String> {
    let words: Vec<&str> = command.split_whitespace().filter(|word| !word.starts_with("FUZZ_")).collect();
    match words[..] {
        ["cargo", "test", ref rest @ ..] => cargo_test(rest, packages),
        ["host-sim", ..] => match HostSim::command().try_get_matches_from(&words) {
            // A document may name a command and an option without a recording, so a missing argument is no error.
            Err(error) if error.use_stderr() && error.kind() != ErrorKind::MissingRequiredArgument => {
                Err(error.to_string())
            }
            _ => Ok(()),
        },
        [".ci/run", step, ..] if !is_step(step) => Err(format!(".ci/run has no step {step}")),
        [script, ..] if root().join(script).is_file() => Ok(()),
        _ => Err("there is no such script".to_owned()),
    }
}

/// True for a tier, a target of the Makefile or a script beside it.
fn is_step(name: &str) -> bool {
    let steps = fs::read_to_string(root().join(".ci/Makefile")).unwrap();
    ["quick", "default", "nightly"].contains(&name.trim_matches(['[', ']']))
        || name.starts_with(|letter: char| !letter.is_lowercase())
        || steps.lines().any(|line| line.starts_with(&format!("{name}: ##")))
        || root().join(".ci").join(name).is_file()
}

#[test]
fn the_commands_of_the_documents_can_be_run() {
    let packages = packages();
    let mut count = 0;
    for document in DOCUMENTS {
        let text = fs::read_to_string(root().join(document)).unwrap();
        for command in commands(&text) {
            count += 1;
            refusal(command, &packages).unwrap_or_else(|why| panic!("{document}: `{command}`: {why}"));
        }
    }
    assert!(count > 60, "{count} commands were found");
}

#[test]
fn requirements_are_numbered() {
    let read = |name| fs::read_to_string(root().join(name)).unwrap();
    let number = |word: &str| word.strip_prefix('R')?.parse::<usize>().ok();
    let rows: Vec<usize> =
        read("core/EVIDENCE.md").lines().filter_map(|line| number(line.split(' ').nth(1)?)).collect();
    assert!(rows.len() > 9 && rows.iter().copied().eq(1..=rows.len()), "core/EVIDENCE.md: {rows:?}");
    let safety = read("core/SAFETY.md");
    let unknown = safety.split(|letter: char| !letter.is_alphanumeric()).filter_map(number).find(|n| !rows.contains(n));
    assert_eq!(unknown, None, "core/SAFETY.md names a number that core/EVIDENCE.md does not have");
}

/// The bounds have their tests in the last column.
#[test]
fn the_tests_of_the_bounds_are_there() {
    let evidence = fs::read_to_string(root().join("core/EVIDENCE.md")).unwrap();
    let bounds = evidence.split_once("## Bounds").unwrap().1.split("\n## ").next().unwrap();
    let rows = bounds.lines().filter_map(|line| line.trim_end_matches(" |").rsplit_once(" | "));
    let words = rows.flat_map(|(_, tests)| tests.split('`').skip(1).step_by(2));
    let names: Vec<&str> = words.filter(|word| word.matches('_').count() > 1).collect();
    let text = ["core/src", "core/tests", "core/c/tests"].map(|folder| sources(&root().join(folder))).concat();
    let missing = names.iter().find(|name| !text.contains(&format!("fn {name}")));
    assert!(names.len() > 8 && missing.is_none(), "core/EVIDENCE.md: there is no test {missing:?}");
}

#[test]
fn what_cargo_refuses_is_noticed() {
    let packages = packages();
    for (command, why) in [
        ("cargo test -p smr-none", "no package"),
        ("cargo test -p smr-core --features refined", "no feature"),
        ("cargo test -p smr-core --test powers", "no test powers"),
        ("cargo test -p smr-core most_works", "is called most_works"),
        ("cargo test -p smr-core one two", "one filter too many"),
        ("host-sim eval --covert", "--covert"),
        (".ci/nothing", "no such script"),
    ] {
        let refused = refusal(command, &packages).unwrap_err();
        assert!(refused.contains(why), "{command}: {refused}");
    }
}
