//! `host-sim report --figures` from its user's view.

use crate::program::{host_sim, utf8};
use serde_json::json;
use std::fs;
use std::path::Path;

/// `host-sim/FIGURES.md` shows them. To make them again: `host-sim report synthetic --figures DIR`, then add `synthetic-` before each name.
#[test]
fn the_documentation_shows_all_five_as_the_command_draws_them() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/folder");
    let said = host_sim(&["report", "synthetic", "--figures", utf8(&out), "--json"]).json();
    assert_eq!((&said["recordings"], &said["left_out"]), (&json!([]), &json!([])));
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let files = said["files"].as_array().unwrap();
    assert_eq!((files.len(), fs::read_dir(&out).unwrap().count()), (10, 10));
    for file in files {
        let path = Path::new(file["file"].as_str().unwrap());
        let made = fs::read(path).unwrap();
        assert_eq!(file["bytes"], made.len());
        if path.extension().is_some_and(|ending| ending == "png") {
            let name = format!("synthetic-{}", path.file_name().unwrap().to_str().unwrap());
            assert!(made == fs::read(assets.join(&name)).unwrap(), "assets/{name} is another picture: make it anew");
        } else {
            assert!(made.starts_with(b"<svg"), "{file}");
        }
    }
    let size: u64 = fs::read_dir(assets).unwrap().map(|file| file.unwrap().metadata().unwrap().len()).sum();
    assert!(size < 600_000, "{size} bytes of pictures");
}
