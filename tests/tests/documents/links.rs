//! Checks that links in documents lead to files of the project and to headings in them.

use super::root;
use crate::markdown;
use std::fs;
use std::path::{Path, PathBuf};

/// Returns all documents below `folder`, except those in folders that git does not keep.
fn documents(folder: &Path) -> Vec<PathBuf> {
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    paths
        .flat_map(|path| match path.extension() {
            _ if path.ends_with("target") || path.ends_with("node_modules") || path.ends_with(".git") => Vec::new(),
            _ if path.is_dir() => documents(&path),
            Some(ending) if ending == "md" => vec![path],
            _ => Vec::new(),
        })
        .collect()
}

/// Returns the name that a heading has in links.
fn anchor(heading: &str) -> String {
    let letters = heading.trim().chars().filter(|&letter| letter.is_alphanumeric() || " -_".contains(letter));
    letters.flat_map(char::to_lowercase).map(|letter| if letter == ' ' { '-' } else { letter }).collect()
}

fn has_heading(file: &Path, name: &str) -> bool {
    let text = fs::read_to_string(file).unwrap();
    text.lines().any(|line| line.starts_with('#') && anchor(line.trim_start_matches('#')) == name)
}

#[test]
fn links_lead_to_files_and_headings() {
    let mut count = 0;
    for document in documents(&root()) {
        let text = fs::read_to_string(&document).unwrap();
        for link in markdown::links(&text).filter(|link| !link.contains(':')) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let file = if file.is_empty() { document.clone() } else { document.parent().unwrap().join(file) };
            assert!(file.exists(), "{}: {link}", document.display());
            assert!(heading.is_empty() || has_heading(&file, heading), "{}: {link}", document.display());
            count += 1;
        }
    }
    assert!(count > 50, "{count} links were found");
}
