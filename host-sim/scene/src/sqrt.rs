//! Square root: that of `std`, and in WebAssembly, which is without `std`, that of JavaScript.

#[cfg(not(target_family = "wasm"))]
pub fn sqrt(of: f64) -> f64 {
    of.sqrt()
}

// SAFETY: JavaScript's `Math.sqrt` takes any number.
#[cfg(target_family = "wasm")]
#[allow(unsafe_code)] // the boundary to JavaScript
#[link(wasm_import_module = "Math")]
unsafe extern "C" {
    pub safe fn sqrt(of: f64) -> f64;
}
