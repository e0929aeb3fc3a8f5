//! Finds the front end. In a clone it is `core/web/page`. A package of this crate holds a copy, because it can hold only its own folder:
//! `.ci/release` puts it there.

use std::path::Path;

fn main() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let copy = here.join("front-end");
    let folder = if copy.is_dir() { copy } else { here.join("../../core/web/page") };
    println!("cargo::rustc-env=SMR_FRONT_END={}", folder.display());
    println!("cargo::rerun-if-changed=build.rs");
}
