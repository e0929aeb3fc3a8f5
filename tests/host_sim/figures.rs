//! `host-sim figures` from its user's view.

use crate::program::{host_sim, utf8};
use serde_json::json;
use std::fs;
use std::path::Path;

#[test]
fn all_five_as_png_and_svg() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/folder");
    let said = host_sim(&["figures", "synthetic", "--out", utf8(&out), "--json"]).json();
    assert_eq!((&said["sequence"], &said["left_out"]), (&json!("synthetic"), &json!([])));
    let figures = said["figures"].as_array().unwrap();
    let names: Vec<_> = figures.iter().map(|figure| figure["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["boxes", "differences", "leaving", "drift", "occlusion"]);
    for file in figures.iter().flat_map(|figure| figure["files"].as_array().unwrap()) {
        let bytes = fs::read(file["file"].as_str().unwrap()).unwrap();
        assert_eq!(file["bytes"], bytes.len());
        assert!(bytes.starts_with(b"\x89PNG") || bytes.starts_with(b"<svg"), "{file}");
    }
    assert_eq!(fs::read_dir(&out).unwrap().count(), 10);
}

/// `host-sim/FIGURES.md` shows them. To make them again: `host-sim figures synthetic -o DIR --form png`, then add `synthetic-` before each
/// name.
#[test]
fn the_documentation_shows_what_the_command_draws() {
    let folder = tempfile::tempdir().unwrap();
    let said = host_sim(&["figures", "synthetic", "-o", utf8(folder.path()), "--form", "png"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let mut compared = 0;
    for file in fs::read_dir(folder.path()).unwrap().map(Result::unwrap) {
        let name = format!("synthetic-{}", file.file_name().into_string().unwrap());
        let (made, kept) = (fs::read(file.path()).unwrap(), fs::read(assets.join(&name)).unwrap());
        assert!(made == kept, "assets/{name} is another picture: make it anew, see above");
        compared += 1;
    }
    assert_eq!(compared, 5);
    let size: u64 = fs::read_dir(assets).unwrap().map(|file| file.unwrap().metadata().unwrap().len()).sum();
    assert!(size < 600_000, "{size} bytes of pictures");
}

#[test]
fn what_cannot_be_drawn_is_left_out_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (film, out) = (folder.path().join("blind.y4m"), folder.path().join("out"));
    let said = host_sim(&["convert", "synthetic", "-o", utf8(&film), "--frames", "1..20"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let figures = |more: &[&str]| {
        host_sim(&[&["figures", utf8(&film), "--init", "36,24,24,28", "-o", utf8(&out)], more].concat())
    };
    // Without ground truth only the figure of the boxes is drawn.
    let said = figures(&["--form", "svg"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert_eq!(said.out.matches("left out: blind: no figure ").count(), 4, "{}", said.out);
    assert_eq!(fs::read_dir(&out).unwrap().count(), 1);
    figures(&["--figure", "4"]).refuses(&["no figure 4 (drift)", "needs ground truth"]);
    figures(&["--figure", "leaving"]).refuses(&["no figure 3 (leaving)", "never reaches over the border"]);
    figures(&["--frame", "21"]).refuses(&["frame 21", "expected 2 to 20"]);
    assert_eq!(figures(&["--figure", "6"]).code, Some(2));
    host_sim(&["figures", "-", "-o", utf8(&out)]).refuses(&["standard input", "expected a file"]);
}

#[test]
fn a_part_of_a_recording_is_counted_from_1_again() {
    let folder = tempfile::tempdir().unwrap();
    let said = host_sim(&[
        "figures",
        "synthetic",
        "-o",
        utf8(folder.path()),
        "--frames",
        "60..120",
        "--figure",
        "boxes,occlusion",
        "--frame",
        "11",
        "--hidden",
        "30..60",
        "--json",
    ])
    .json();
    assert_eq!(said["figures"][0]["frames"], json!([11]));
    assert_eq!(said["figures"][1]["frames"], json!([20, 30, 60, 61]));
}
