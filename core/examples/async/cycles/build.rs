//! Chooses the board by the target, and passes its memory map and the log's linker script to the linker.

fn main() {
    let is_rp2350 = std::env::var("TARGET").is_ok_and(|target| target.starts_with("thumbv8m"));
    let folder = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo::rustc-check-cfg=cfg(rp2350)");
    if is_rp2350 {
        println!("cargo::rustc-cfg=rp2350");
    }
    println!("cargo::rustc-link-search={folder}/{}", if is_rp2350 { "../embassy-rp2350" } else { "" });
    println!("cargo::rustc-link-arg-bins=--nmagic");
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rustc-link-arg-bins=-Tdefmt.x");
    println!("cargo::rerun-if-changed=memory.x");
    println!("cargo::rerun-if-changed=../embassy-rp2350/memory.x");
}
