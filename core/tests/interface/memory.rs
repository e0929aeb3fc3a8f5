//! Tests that the table of memory in the README is that of this library.

use smr_core::{Paper, Robust, paper, robust};

/// The bytes of target and workspace in the row of the README that begins with `beginning`.
fn row(beginning: &str) -> (usize, usize) {
    let readme = include_str!("../../README.md");
    let row = readme.lines().find(|line| line.starts_with(beginning)).unwrap_or_else(|| panic!("no row {beginning}"));
    let mut cells = row.split('|').skip(2).map(|cell| cell.trim().replace(',', "").parse().expect("a number"));
    (cells.next().expect("the target"), cells.next().expect("the workspace"))
}

fn paper<const PIXELS: usize, const SPAN: usize>() {
    let sizes = (size_of::<Paper<PIXELS, SPAN>>(), size_of::<paper::Workspace<PIXELS, SPAN>>());
    assert_eq!(sizes, row(&format!("| `Paper<{PIXELS}, {SPAN}>`")));
}

#[cfg(target_pointer_width = "64")]
#[test]
fn the_readme_states_the_memory() {
    paper::<1024, 33>();
    paper::<4096, 33>();
    paper::<4096, 161>();
    let robust = if cfg!(feature = "refiner") { "| `Robust` with the feature `refiner` |" } else { "| `Robust` |" };
    assert_eq!((size_of::<Robust>(), size_of::<robust::Workspace>()), row(robust));
}
