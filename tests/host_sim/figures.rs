//! Runs `host-sim report --figures` and checks the files that it writes.

use crate::program::{host_sim, utf8};
use serde_json::json;
use std::fs;
use std::path::Path;

/// `report synthetic --figures DIR` writes the pictures `host-sim/assets/synthetic-*`, named without `synthetic-`.
#[test]
fn the_documentation_shows_all_five_as_the_command_draws_them() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/folder");
    let said = host_sim(&["report", "synthetic", "--figures", utf8(&out), "--json"]).json();
    assert_eq!((&said["recordings"], &said["left_out"]), (&json!([]), &json!([])));
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    assert_eq!((said["files"].as_array().unwrap().len(), fs::read_dir(&out).unwrap().count()), (5, 5));
    for file in said["files"].as_array().unwrap() {
        let path = Path::new(file["file"].as_str().unwrap());
        let made = fs::read_to_string(path).unwrap();
        assert_eq!(file["bytes"], made.len());
        // Each figure shows both methods. Frames are JPEG; patches are PNG.
        let has = |words: &str| made.contains(words);
        assert!(has("rgb(255,64,64)") && has("rgb(64,140,255)") && !has("NaN"), "{file}");
        let frames = if path.ends_with("2-differences.svg") { 0 } else { file["frames"].as_array().unwrap().len() };
        assert_eq!(made.matches("data:image/jpeg").count(), frames, "{file}");
        let asset = assets.join(format!("synthetic-{}", path.file_name().unwrap().to_str().unwrap()));
        assert!(made == fs::read_to_string(&asset).unwrap(), "{} is another picture: make it anew", asset.display());
    }
    let size: u64 = fs::read_dir(assets).unwrap().map(|file| file.unwrap().metadata().unwrap().len()).sum();
    assert!(size < 600_000, "{size} bytes of pictures");
}
