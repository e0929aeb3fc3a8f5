//! Passes the linker script of cortex-m-rt to the linker. The crate lm3s6965 contains the memory map.

fn main() {
    println!("cargo::rustc-link-arg-bins=--nmagic");
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rerun-if-changed=build.rs");
}
