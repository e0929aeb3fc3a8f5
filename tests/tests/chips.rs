//! Compares the chips of `host-sim eval --chip` with the measured table of chips and boards, `tests/results/chips.json`.

use serde_json::Value;
use smr_evaluation::choice::{CHIPS, CYCLES, Chip, Processor, Tracker};
use std::fs;
use std::path::Path;

fn results() -> Value {
    serde_json::from_str(include_str!("../results/chips.json")).unwrap()
}

fn rows(name: &str) -> Vec<String> {
    let results = results();
    let rows = results["rows"][name].as_array().unwrap();
    rows.iter().map(|row| row.as_str().unwrap().to_owned()).collect()
}

/// Cycles are written once, where they are measured; the program has a copy, because a crate contains only its own files.
#[test]
fn figures_of_cycles_are_those_that_were_measured() {
    let results = results();
    let ratios = ["riscv", "xtensa"].map(|name| format!("{name} | {}", results["figures"][name].as_str().unwrap()));
    let measured = [rows("cycles"), ratios.to_vec()].concat().join("\n") + "\n";
    if std::env::var_os("SMR_RECORD").is_some() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host-sim/evaluation/src/choice/cycles.txt");
        fs::write(file, measured).unwrap();
    } else {
        assert_eq!(CYCLES, measured, "SMR_RECORD=1 cargo test -p smr-tests --test crates figures");
    }
}

fn letters(name: &str) -> String {
    name.chars().filter(char::is_ascii_alphanumeric).map(|letter| letter.to_ascii_lowercase()).collect()
}

/// The chip of a board, such as `Kendryte K210` in the library `riscv64imafc`.
fn chip(name: &str, library: &str) -> Chip {
    let is_its = |chip: &&Chip| {
        let own = letters(chip.name.trim_end_matches("-riscv"));
        letters(name).ends_with(&own) && (chip.processor == Processor::RiscV) == library.starts_with("riscv")
    };
    *CHIPS.iter().filter(is_its).max_by_key(|chip| chip.name.len()).unwrap_or_else(|| panic!("{name} is missing"))
}

/// Returns the updates a second of each tracker: the cycles have two decimals, and the table two digits.
fn check_rates(chip: Chip, cells: &[&str]) {
    for (tracker, cell) in [Tracker::Paper, Tracker::Robust, Tracker::Refined].into_iter().zip(cells) {
        let Ok(rate) = cell.split([' ', '*']).find(|part| !part.is_empty()).unwrap_or("-").parse::<f64>() else {
            continue;
        };
        let own = f64::from(chip.clock_mhz) * 1e6 / chip.processor.cycles(tracker).unwrap()[0];
        assert!((rate - own).abs() < 0.08 * rate + 0.5, "{}, {tracker:?}: {own}, and {rate} in the table", chip.name);
    }
}

#[test]
fn chips_are_those_of_the_table_of_boards() {
    for row in rows("boards").iter().filter(|row| !row.contains("Linux")) {
        let cells: Vec<&str> = row.split(" | ").collect();
        let [_, chip_and_clock, ram, library, rates @ ..] = &cells[..] else { panic!("{row}") };
        let (name, clock) = chip_and_clock.split_once(", ").unwrap();
        let chip = chip(name, library.trim_matches('`'));
        assert_eq!(clock, format!("{} MHz", chip.clock_mhz), "{row}");
        let (amount, unit) = ram.trim_end_matches(", PSRAM").split_once(' ').unwrap();
        let kb = amount.parse::<f64>().unwrap() * if unit == "MB" { 1024.0 } else { 1.0 };
        assert!((kb - f64::from(chip.ram_kb)).abs() < 1.0, "{row}");
        check_rates(chip, &rates[..3]);
    }
    for row in rows("rates") {
        let cells: Vec<&str> = row.split(" | ").collect();
        let [name, clock, rates @ ..] = &cells[..] else { panic!("{row}") };
        // The table of rates also has chips that are on no board of the other table.
        let Some(chip) = CHIPS.iter().find(|chip| letters(chip.name) == letters(name)) else { continue };
        assert_eq!(*clock, format!("{} MHz", chip.clock_mhz), "{row}");
        check_rates(*chip, rates);
    }
}
