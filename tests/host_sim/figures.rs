//! `host-sim report --figures` from its user's view.

use crate::program::{host_sim, utf8};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

#[test]
fn all_five_as_png_and_svg() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/folder");
    let said = host_sim(&["report", "synthetic", "--figures", utf8(&out), "--json"]).json();
    assert_eq!((&said["recordings"], &said["left_out"]), (&json!([]), &json!([])));
    for file in said["files"].as_array().unwrap() {
        let bytes = fs::read(file["file"].as_str().unwrap()).unwrap();
        assert_eq!(file["bytes"], bytes.len());
        assert!(bytes.starts_with(b"\x89PNG") || bytes.starts_with(b"<svg"), "{file}");
    }
    assert_eq!(fs::read_dir(&out).unwrap().count(), 10);
}

/// `host-sim/FIGURES.md` shows them. To make them again: `host-sim report synthetic --figures DIR`, then add `synthetic-` before each name.
#[test]
fn the_documentation_shows_what_the_command_draws() {
    let folder = tempfile::tempdir().unwrap();
    let said = host_sim(&["report", "synthetic", "--figures", utf8(folder.path())]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let mut compared = 0;
    let files = fs::read_dir(folder.path()).unwrap().map(Result::unwrap);
    for file in files.filter(|file| file.path().extension().is_some_and(|ending| ending == "png")) {
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
        host_sim(&[&["report", utf8(&film), "--init", "36,24,24,28", "--figures", utf8(&out)], more].concat())
    };
    // Without ground truth only the figure of the boxes is drawn.
    let said = figures(&[]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert_eq!(said.out.matches("left out: blind: no figure ").count(), 4, "{}", said.out);
    assert_eq!(fs::read_dir(&out).unwrap().count(), 2);
    figures(&["--hidden", "5..9"]).refuses(&["no figure 5 (occlusion)", "needs ground truth"]);
    figures(&["--frame", "21"]).refuses(&["frame 21", "expected 2 to 20"]);
    host_sim(&["report", "-", "--figures", utf8(&out)]).refuses(&["standard input", "expected a file"]);
    host_sim(&["report", "border", "noise", "--figures", utf8(&out)]).refuses(&["--figures is of one recording"]);
}

#[test]
fn a_part_of_a_recording_is_counted_from_1_again() {
    let folder = tempfile::tempdir().unwrap();
    let said = host_sim(&[
        "report",
        "synthetic",
        "--figures",
        utf8(folder.path()),
        "--frames",
        "60..120",
        "--frame",
        "11",
        "--hidden",
        "30..60",
        "--json",
    ])
    .json();
    let files = said["files"].as_array().unwrap();
    let frames = |file: &Value| file["frames"].clone();
    assert_eq!((frames(&files[0]), frames(files.last().unwrap())), (json!([11]), json!([20, 30, 60, 61])));
}
