//! Extracts the Rust examples from the READMEs, so that `tests/documents/examples.rs` compiles and runs them unchanged.
//!
//! The examples of a README become the files `FOLDER-1.rs`, `FOLDER-2.rs` and so on. An example without `fn` becomes a
//! block, and the test around it defines the names that it uses.

#[path = "markdown.rs"]
mod markdown;

use std::path::Path;
use std::{env, fs};

fn main() {
    let out = env::var("OUT_DIR").expect("cargo sets it");
    println!("cargo::rerun-if-changed=markdown.rs");
    for (name, readme) in [("smr", "README.md"), ("core", "core/README.md")] {
        let readme = Path::new("..").join(readme);
        println!("cargo::rerun-if-changed={}", readme.display());
        let text = fs::read_to_string(&readme).expect("the README can be read");
        for (number, example) in (1..).zip(markdown::blocks(&text, "rust")) {
            let example = if example.contains("\nfn ") { example } else { format!("{{\n{example}}}\n") };
            let file = Path::new(&out).join(format!("{name}-{number}.rs"));
            fs::write(file, example).expect("the example can be written");
        }
    }
}
