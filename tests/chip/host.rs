// The `main` of firmware built for a host: prints how to run it.
fn main() {
    let program = concat!("-p smr-chip --bin ", env!("CARGO_BIN_NAME"));
    let features = if cfg!(feature = "refiner") { " --features refiner" } else { "" };
    eprintln!("this is firmware: cargo run --target thumbv7em-none-eabihf {program}{features}");
}
