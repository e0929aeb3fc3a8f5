// The `main` of firmware built for a host: prints how to run it.
fn main() {
    let program = concat!("-p smr-examples --bin ", env!("CARGO_BIN_NAME"));
    eprintln!("this is firmware: cargo run --target thumbv7em-none-eabihf {program}");
}
