//! Names the linker scripts here, because flags in `.cargo/config.toml` would apply to all firmware in the workspace.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=../../memory.x");
    let is = |key: &str, value: &str| std::env::var(key).is_ok_and(|found| found == value);
    if is("CARGO_CFG_TARGET_ARCH", "arm") && is("CARGO_CFG_TARGET_OS", "none") {
        // link.x of cortex-m-rt includes memory.x, which lies in the workspace's folder, where the linker runs.
        println!("cargo::rustc-link-arg-bins=-Tlink.x");
        // Programs that log with defmt; `kernels` prints plain text instead.
        for program in ["cycles", "footprint", "replay"] {
            println!("cargo::rustc-link-arg-bin={program}=-Tdefmt.x");
        }
    }
    if is("CARGO_CFG_TARGET_ARCH", "riscv32") && is("CARGO_CFG_TARGET_OS", "none") {
        // The programs that run on RISC-V. `footprint` is linked for RISC-V without start-up code, and never run.
        let memory = concat!(env!("CARGO_MANIFEST_DIR"), "/replay/riscv.x");
        println!("cargo::rerun-if-changed=replay/riscv.x");
        for program in ["kernels", "replay"] {
            println!("cargo::rustc-link-arg-bin={program}=-T{memory}");
            println!("cargo::rustc-link-arg-bin={program}=-Tlink.x");
        }
    }
}
