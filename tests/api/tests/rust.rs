//! Compares the public interface of smr-core with `smr-core.txt`, item by item.
//!
//! Record it with `SMR_RECORD=1 cargo test -p smr-api`.

#[path = "../../missing.rs"]
mod missing;

use missing::skipped;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The Rust version whose JSON output of rustdoc the library `public-api` reads.
const COMPILER: &str = "1.95";

fn compiler_is_read() -> bool {
    let Ok(version) = Command::new("rustc").arg("--version").output() else { return false };
    String::from_utf8_lossy(&version.stdout).starts_with(&format!("rustc {COMPILER}."))
}

fn listed() -> String {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("api");
    let said = Command::new(env!("CARGO"))
        .args(["rustdoc", "-p", "smr-core", "--lib", "--all-features", "--locked", "--quiet", "--target-dir"])
        .arg(&target)
        .args(["--", "-Zunstable-options", "--output-format", "json"])
        // The JSON output is unstable: this variable allows it on a stable compiler.
        .env("RUSTC_BOOTSTRAP", "1")
        .output()
        .expect("cargo");
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    let api = public_api::Builder::from_rustdoc_json(target.join("doc/smr_core.json"))
        .omit_blanket_impls(true)
        .omit_auto_trait_impls(true)
        .omit_auto_derived_impls(true)
        .build()
        .expect("the description of a crate");
    api.to_string()
}

#[test]
fn smr_core_has_the_interface_that_is_listed() {
    if !compiler_is_read() {
        return skipped("smr_core_has_the_interface_that_is_listed", format_args!("Rust {COMPILER} lists it"));
    }
    let (file, now) = (Path::new(env!("CARGO_MANIFEST_DIR")).join("smr-core.txt"), listed());
    if std::env::var_os("SMR_RECORD").is_some() {
        fs::write(&file, &now).expect("a file of the project");
    }
    let before = fs::read_to_string(&file).expect("it is recorded: SMR_RECORD=1");
    let only = |these: &str, those: &str, sign: &str| -> Vec<String> {
        these
            .lines()
            .filter(|line| !those.lines().any(|other| other == *line))
            .map(|line| format!("{sign} {line}"))
            .collect()
    };
    let changes = [only(&before, &now, "-"), only(&now, &before, "+")].concat();
    assert!(
        changes.is_empty(),
        "the interface of smr-core has changed; if that is meant: SMR_RECORD=1 cargo test -p smr-api\n{}",
        changes.join("\n")
    );
}
