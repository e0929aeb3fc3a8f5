//! Runs one fuzz target under libFuzzer; the environment names the target: `SMR_FUZZ=paper`.

#![no_main]

use std::sync::LazyLock;

static TARGET: LazyLock<smr_fuzz::Run> = LazyLock::new(|| {
    let name = std::env::var("SMR_FUZZ").unwrap_or_default();
    let Some(target) = smr_fuzz::target(&name) else {
        let names: Vec<_> = smr_fuzz::TARGETS.iter().map(|(name, _)| *name).collect();
        eprintln!("SMR_FUZZ={name}: expected one of {}", names.join(", "));
        std::process::exit(2);
    };
    target
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| TARGET(bytes));
