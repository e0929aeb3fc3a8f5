//! The linker scripts of the firmware in `examples/`. For whoever only uses the crate this does nothing.
//!
//! Not in `.cargo/config.toml`: its flags would be those of every other firmware in this repository, too.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let is = |key: &str, value: &str| std::env::var(key).is_ok_and(|actual| actual == value);
    if is("CARGO_CFG_TARGET_ARCH", "arm") && is("CARGO_CFG_TARGET_OS", "none") {
        // cortex-m-rt's, which takes memory.x from the workspace's folder, where the linker starts; and defmt's.
        println!("cargo::rustc-link-arg-examples=-Tlink.x");
        println!("cargo::rustc-link-arg-examples=-Tdefmt.x");
    }
}
