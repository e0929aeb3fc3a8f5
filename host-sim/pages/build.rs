//! Finds the folder of the front end and lists its JavaScript modules. In a clone it is `core/web/page`; in a published
//! package it is a copy made by `.ci/release`, because a package contains only its own folder.

use std::path::Path;
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let copy = here.join("front-end");
    let folder = if copy.is_dir() { copy } else { here.join("../../core/web/page") };
    println!("cargo::rustc-env=SMR_FRONT_END={}", folder.display());
    println!("cargo::rerun-if-changed=build.rs");
    let lists = [modules(&folder, "window.js")?, modules(&folder, "report.js")?];
    fs::write(
        Path::new(&env::var_os("OUT_DIR").unwrap_or_default()).join("modules.rs"),
        format!("[{}]", lists.join(",")),
    )
}

/// Returns Rust source for a slice of (name, text): the module `first`, and all that it imports, directly or not.
fn modules(folder: &Path, first: &str) -> io::Result<String> {
    let (mut names, mut list) = (vec![first.to_owned()], String::new());
    while let Some(name) = names.get(list.lines().count()) {
        let file = folder.join(name);
        println!("cargo::rerun-if-changed={}", file.display());
        list += &format!("({name:?}, include_str!({file:?})),\n");
        let text =
            fs::read_to_string(&file).map_err(|error| io::Error::other(format!("{}: {error}", file.display())))?;
        for import in text.lines().filter_map(|line| line.split_once("from \"./")?.1.split('"').next()) {
            if names.iter().all(|name| name != import) {
                names.push(import.to_owned());
            }
        }
    }
    Ok(format!("&[{list}]"))
}
