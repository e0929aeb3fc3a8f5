//! Chooses the fastest instructions of a 32-bit processor or RISC-V and sets their cfg: `smr_helium`, `smr_dsp`, or
//! else `smr_swar`. Other 64-bit processors and WebAssembly with SIMD need no cfg. On bare metal and in WebAssembly,
//! where every byte of code counts, cfg `smr_small` selects smaller code: functions with several callers are not
//! inlined.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(smr_dsp, smr_helium, smr_small, smr_swar)");
    let is = |key: &str, value: &str| variable(key) == value;
    let processor = Processor::read();
    let is_cortex_m = is("CARGO_CFG_TARGET_ARCH", "arm") && is("CARGO_CFG_TARGET_OS", "none");
    if is_cortex_m && processor.has_helium() {
        println!("cargo::rustc-cfg=smr_helium");
    } else if is_cortex_m && processor.has_dsp() {
        println!("cargo::rustc-cfg=smr_dsp");
    } else if (is("CARGO_CFG_TARGET_POINTER_WIDTH", "32") || is("CARGO_CFG_TARGET_ARCH", "riscv64"))
        && !processor.features.iter().any(|feature| feature == "simd128")
    {
        println!("cargo::rustc-cfg=smr_swar");
    }
    if is("CARGO_CFG_TARGET_OS", "none") || is("CARGO_CFG_TARGET_ARCH", "wasm32") {
        println!("cargo::rustc-cfg=smr_small");
    }
}

/// The processor that the crate is compiled for. A stable compiler does not report features that it considers unstable,
/// so they are recognised by the name of the processor or of the target, unless a flag of rustc names them.
struct Processor {
    target: String,
    flags: Vec<String>,
    features: Vec<String>,
}

impl Processor {
    fn read() -> Self {
        let list = |text: String, separator: char| text.split(separator).map(str::to_owned).collect();
        Self {
            target: variable("TARGET"),
            flags: list(variable("CARGO_ENCODED_RUSTFLAGS"), '\x1f'),
            features: list(variable("CARGO_CFG_TARGET_FEATURE"), ','),
        }
    }

    /// True if the processor has the DSP extension of Armv7E-M and Armv8-M.
    fn has_dsp(&self) -> bool {
        let known = self.target.starts_with("thumbv7em") || self.features.iter().any(|feature| feature == "dsp");
        let named = self.is_one_of(&["cortex-m33", "cortex-m35p", "cortex-m52", "cortex-m55", "cortex-m85"]);
        self.switched("dsp").unwrap_or(known || named)
    }

    /// True if the processor has the integer vectors of Armv8.1-M (MVE).
    fn has_helium(&self) -> bool {
        let named = self.is_one_of(&["cortex-m52", "cortex-m55", "cortex-m85"]);
        self.switched("mve").or(self.switched("mve.fp")).unwrap_or(named)
    }

    fn is_one_of(&self, names: &[&str]) -> bool {
        self.flags.iter().filter_map(|flag| flag.rsplit_once("target-cpu=")).any(|(_, name)| names.contains(&name))
    }

    /// True if the last `-C target-feature` that names `feature` enables it; `None` if no flag names it.
    fn switched(&self, feature: &str) -> Option<bool> {
        let lists = self.flags.iter().filter_map(|flag| flag.rsplit_once("target-feature="));
        let switches = lists.flat_map(|(_, list)| list.split(','));
        switches
            .filter_map(|switch| Some((switch.chars().next()?, switch.get(1..)?)))
            .rfind(|&(_, name)| name == feature)
            .map(|(sign, _)| sign == '+')
    }
}

fn variable(key: &str) -> String {
    std::env::var(key).unwrap_or_default()
}
