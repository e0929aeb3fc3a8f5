//! Gives the memory map and the log's linker script to the linker.

fn main() {
    println!("cargo::rustc-link-search={}/../embassy-rp2350", std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default());
    println!("cargo::rustc-link-arg-bins=--nmagic");
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rustc-link-arg-bins=-Tdefmt.x");
    println!("cargo::rerun-if-changed=../embassy-rp2350/memory.x");
}
