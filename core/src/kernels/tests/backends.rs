//! Runs the same tests for every backend, by one macro.

/// Defines a module of tests for each backend; `$test` is a function that takes it. A backend that the machine does not
/// have is skipped by name.
macro_rules! for_each_backend {
    ($($test:ident),*) => {
        for_each_backend! { @modules ($($test),*) scalar_loop: Scalar, sse2: Sse2, avx2: Avx2, neon: Neon, simd128: Simd128, swar: Swar }
    };
    (@modules $tests:tt $($module:ident: $backend:ident),*) => {$(
        mod $module {
            use super::*;
            for_each_backend! { @tests $backend $tests }
        }
    )*};
    (@tests $backend:ident ($($test:ident),*)) => {$(
        #[test]
        fn $test() {
            let backend = $crate::kernels::backend::Backend::$backend;
            if backend.is_available() {
                super::$test(backend);
            } else {
                let test = std::format!("{}::{}", module_path!(), stringify!($test));
                crate::missing::skipped(&test, std::format_args!("no {backend:?} here"));
            }
        }
    )*};
}

pub(super) use for_each_backend;
