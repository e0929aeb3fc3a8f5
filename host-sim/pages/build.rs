//! Finds the folder of the front end, lists its JavaScript modules, and reads its colors. In a clone it is `core/web/page`; in a published
//! package it is a copy made by `.ci/release`, because a package contains only its own folder.

use std::collections::BTreeMap;
use std::path::Path;
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let copy = here.join("front-end");
    let folder = if copy.is_dir() { copy } else { here.join("../../core/web/page") };
    println!("cargo::rustc-env=SMR_FRONT_END={}", folder.display());
    println!("cargo::rerun-if-changed=build.rs");
    let out = env::var_os("OUT_DIR").unwrap_or_default();
    fs::write(Path::new(&out).join("colors.rs"), colors(&folder.join("colors.css"))?)?;
    let lists = [modules(&folder, "viewer.js")?, modules(&folder, "report.js")?];
    fs::write(Path::new(&out).join("modules.rs"), format!("[{}]", lists.join(",")))
}

/// Returns Rust source for the colors in `file`: a constant for each, such as `--truth`, and a slice for numbered ones, such
/// as `--target1`. A line is `--NAME: #rrggbb;` or `--NAME: light-dark(#rrggbb, #rrggbb);`. Others are not read.
fn colors(file: &Path) -> io::Result<String> {
    println!("cargo::rerun-if-changed={}", file.display());
    let text = fs::read_to_string(file).map_err(|error| io::Error::other(format!("{}: {error}", file.display())))?;
    let (mut single, mut numbered) = (String::new(), BTreeMap::<String, String>::new());
    for (name, value) in text.lines().filter_map(|line| line.trim().strip_prefix("--")?.split_once(": ")) {
        let parts: Vec<&str> =
            value.split('#').skip(1).map(|part| part.trim_end_matches([')', ',', ';', ' '])).collect();
        let (Some(light), Some(dark)) = (parts.first(), parts.last()) else { continue };
        if light.len() != 6 || dark.len() != 6 {
            continue;
        }
        let rgb = |hex: &str| format!("[0x{}, 0x{}, 0x{}]", &hex[..2], &hex[2..4], &hex[4..]);
        let color = format!("Shades {{ name: {name:?}, light: {}, dark: {} }}", rgb(light), rgb(dark));
        let plain = name.trim_end_matches(|letter: char| letter.is_ascii_digit());
        if plain == name {
            single += &format!("pub const {}: Shades = {color};\n", name.to_uppercase());
        } else {
            *numbered.entry(plain.to_uppercase()).or_default() += &format!("    {color},\n");
        }
    }
    let slices = numbered.iter().map(|(name, all)| format!("pub const {name}S: &[Shades] = &[\n{all}];\n"));
    Ok(single + &slices.collect::<String>())
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
