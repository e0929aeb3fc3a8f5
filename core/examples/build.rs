//! Gives the linker scripts of the firmware to the linker.
//!
//! They are not in `.cargo/config.toml`, because its flags apply to all firmware in this repository.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=../../memory.x");
    let is = |key: &str, value: &str| std::env::var(key).is_ok_and(|found| found == value);
    if is("CARGO_CFG_TARGET_ARCH", "arm") && is("CARGO_CFG_TARGET_OS", "none") {
        // The script of cortex-m-rt includes memory.x. The linker finds it in its working folder, which is the folder
        // of the workspace.
        println!("cargo::rustc-link-arg-bins=-Tlink.x");
        // `kernels` prints text.
        for program in ["cycles", "footprint", "minimal", "record", "replay"] {
            println!("cargo::rustc-link-arg-bin={program}=-Tdefmt.x");
        }
    }
    if is("CARGO_CFG_TARGET_ARCH", "riscv32") && is("CARGO_CFG_TARGET_OS", "none") {
        // Only these programs run on RISC-V. The footprint is linked without start-up code.
        let memory = concat!(env!("CARGO_MANIFEST_DIR"), "/replay/riscv.x");
        println!("cargo::rerun-if-changed=replay/riscv.x");
        for program in ["kernels", "replay"] {
            println!("cargo::rustc-link-arg-bin={program}=-T{memory}");
            println!("cargo::rustc-link-arg-bin={program}=-Tlink.x");
        }
    }
}
