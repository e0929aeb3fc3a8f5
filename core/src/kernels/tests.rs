//! Runs the comparisons of `check` for each backend of the host, at the edge of inaccessible memory.

use super::backend::Backend;
use super::check;
use super::plain::gradients::{mean_by_parts, root};
use super::scorer::Scorer;
use crate::image::Image;
use memory::Guarded;

/// Three memory areas with inaccessible pages before and after each (on Unix); plain allocations on other systems, and
/// under Miri, which checks every access itself.
#[cfg(all(unix, not(miri)))]
mod memory {
    use crate::kernels::check::{Areas, ROOM};
    use core::{ptr, slice};

    pub(super) struct Guarded(*mut u8);

    impl Guarded {
        pub(super) fn new() -> Self {
            // SAFETY: these calls touch nothing but the new mapping. Three of its seven parts are made accessible.
            unsafe {
                let flags = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS;
                let all = libc::mmap(ptr::null_mut(), 7 * ROOM, libc::PROT_NONE, flags, -1, 0);
                assert_ne!(all, libc::MAP_FAILED);
                for part in [1, 3, 5] {
                    assert_eq!(libc::mprotect(all.add(part * ROOM), ROOM, libc::PROT_READ | libc::PROT_WRITE), 0);
                }
                Self(all.cast())
            }
        }

        pub(super) fn areas(&mut self) -> Areas<'_> {
            // SAFETY: the bytes are initialised (zero), do not overlap, and are borrowed as this is.
            let part = |part| unsafe { slice::from_raw_parts_mut(self.0.add(part * ROOM), ROOM) };
            Areas { end: part(1), other_end: part(3), start: part(5) }
        }
    }

    impl Drop for Guarded {
        fn drop(&mut self) {
            // SAFETY: the mapping is unchanged, and nothing borrows it any more.
            unsafe { libc::munmap(self.0.cast(), 7 * ROOM) };
        }
    }
}

#[cfg(not(all(unix, not(miri))))]
mod memory {
    use crate::kernels::check::{Areas, ROOM};
    use std::vec::Vec;

    pub(super) struct Guarded([Vec<u8>; 3]);

    impl Guarded {
        pub(super) fn new() -> Self {
            Self([(); 3].map(|()| std::vec![0; ROOM]))
        }

        pub(super) fn areas(&mut self) -> Areas<'_> {
            let [end, other_end, start] = &mut self.0;
            Areas { end, other_end, start }
        }
    }
}

/// Pictures of more than 65,537 pixels have neither a score nor a distance.
fn too_large(backend: Backend) {
    let pixels = std::vec![255; 2 * 65_535];
    let table = check::cut(2, 256);
    let scorer = Scorer::new(backend, &table);
    for (width, height) in [(257, 256), (65_535, 2), (32_769, 2), (2, 65_535)] {
        let large = Image::new(&pixels, width, height).unwrap();
        assert_eq!(scorer.score(large, large), None);
        assert_eq!(scorer.score_at_least(large, large, 1), None);
        assert_eq!(scorer.distance(large, large, u32::MAX), None);
    }
}

#[test]
fn native() {
    check::native(&mut Guarded::new().areas());
}

#[test]
fn a_root_is_rounded_down() {
    for root_of in 0..=46_341 {
        let square: u32 = root_of * root_of;
        for number in [square.saturating_sub(1), square, square + 1, square + root_of] {
            assert_eq!(root(number), number.isqrt(), "{number}");
        }
    }
    for number in (0..(u32::MAX - (1 << 17))).step_by(997) {
        assert_eq!(root(number), number.isqrt(), "{number}");
    }
}

#[test]
fn means_are_exact() {
    for cells in 1..=9 {
        // Energies below `cells << 10` give the last of the three steps every remainder of the step before, with every
        // value of the next ten bits. `large` adds some of up to 30 bits.
        let large = (0..30).flat_map(|places| [(1 << places) - 1, (1 << places) + cells / 2, (cells << 26) - 1]);
        for energy in (0..cells << 10).chain(large) {
            assert_eq!(mean_by_parts(energy, cells), energy / cells, "{energy} / {cells}");
        }
    }
}

/// Defines a module of tests for each backend. Without support by the machine, a test reports that it is skipped.
macro_rules! for_each_backend {
    ($($module:ident: $backend:ident),*; $tests:tt) => {$(
        mod $module {
            for_each_backend! { @tests $backend $tests }
        }
    )*};
    (@tests $backend:ident { $($(#[$if:meta])? $test:ident: $run:expr),* }) => {$(
        $(#[$if])?
        #[test]
        fn $test() {
            use super::*;
            let backend = Backend::$backend;
            if backend.is_available() {
                let run: fn(Backend) = $run;
                run(backend);
            } else {
                let test = std::format!("{}::{}", module_path!(), stringify!($test));
                crate::missing::skipped(&test, std::format_args!("no {backend:?} here"));
            }
        }
    )*};
}

for_each_backend! {
    scalar_loop: Scalar, ssse3: Ssse3, avx2: Avx2, neon: Neon, simd128: Simd128, swar: Swar;
    {
        scores: |backend| check::scores(backend, &mut Guarded::new().areas()),
        candidates: |backend| check::candidates(backend, &mut Guarded::new().areas()),
        ranges: |backend| check::ranges(backend, &mut Guarded::new().areas()),
        groups: |backend| check::groups(backend, &mut Guarded::new().areas()),
        products: |backend| check::products(backend, &mut Guarded::new().areas()),
        #[cfg(feature = "refiner")]
        dense: |backend| check::dense(backend, &mut Guarded::new().areas()),
        too_large: too_large
    }
}
