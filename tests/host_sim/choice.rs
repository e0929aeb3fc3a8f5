//! Runs `host-sim eval --chip`, and checks its JSON and the lines of code that it prints.

use crate::missing::has_c_compiler;
use crate::program::{host_sim, utf8};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

fn text<'a>(row: &'a Value, key: &str) -> &'a str {
    row[key].as_str().unwrap_or_else(|| panic!("{key}: {row}"))
}

#[test]
fn the_lines_in_c_compile_and_the_choice_is_one_of_the_candidates() {
    let said =
        host_sim(&["eval", "synthetic", "--frames", "..40", "--chip", "stm32h743", "--fault", "black:3", "--json"]);
    let json = said.json();
    let (candidates, choice) = (json["candidates"].as_array().unwrap(), &json["choice"][0]);
    assert_eq!((candidates.len(), json["choice"].as_array().unwrap().len()), (8, 1));
    let keys = |row: &Value| row.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert!(candidates.iter().all(|row| keys(row) == keys(&candidates[0]) && row["black:3"].is_f64()), "{json}");
    let chosen: Vec<_> = candidates.iter().filter(|row| row["tracker"] == choice["tracker"]).collect();
    assert_eq!((chosen.len(), text(chosen[0], "fit")), (1, "fits"));
    assert!(text(choice, "sentence").starts_with(text(choice, "tracker")), "{choice}");
    assert_eq!((&choice["clock_mhz"], &choice["wanted_frames_per_second"]), (&480.into(), &30.into()));

    if !has_c_compiler("the_lines_in_c_compile_and_the_choice_is_one_of_the_candidates") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("lines.c");
    let line = |(at, row): (usize, &Value)| format!("void f{at}(void) {{ smr_config config; {} }}\n", text(row, "c"));
    let lines: String = candidates.iter().enumerate().map(line).collect();
    fs::write(&file, format!("#include \"smr.h\"\n{lines}")).unwrap();
    let include = Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/c/include");
    let mut compiler = Command::new("cc");
    let compiler = compiler.args(["-std=c99", "-Wall", "-Werror", "-fsyntax-only", "-I", utf8(&include)]).arg(&file);
    let said = compiler.output().unwrap();
    assert!(said.status.success(), "{lines}{}", String::from_utf8_lossy(&said.stderr));
}

/// `track` takes the options that are printed for host-sim.
#[test]
fn the_options_of_host_sim_are_options() {
    let json = host_sim(&["eval", "synthetic", "--frames", "..3", "--chip", "rp2040", "--json"]).json();
    for row in json["candidates"].as_array().unwrap() {
        let options = text(row, "options").split(' ');
        let arguments: Vec<&str> = ["track", "synthetic", "--frames", "..3"].into_iter().chain(options).collect();
        assert_eq!(host_sim(&arguments).code, Some(0), "{arguments:?}");
    }
}
