//! Tests of `smr_init`: it takes little stack, even in debug builds, because it constructs the tracker in its storage.
//! Tests of the presets `robust` and `refined`, in builds with and without the refiner.

#![allow(unsafe_code)] // calls the C interface, and reads the stack

use smr::{
    PAPER_TARGET_SIZE, PAPER_WORKSPACE_SIZE, ROBUST_SMALL_TARGET_SIZE, ROBUST_SMALL_WORKSPACE_SIZE, ROBUST_TARGET_SIZE,
    ROBUST_WORKSPACE_SIZE, smr_config, smr_config_camera, smr_config_refined, smr_config_robust, smr_config_small,
    smr_config_small_refined, smr_init, smr_set, smr_setting, smr_setting_at, smr_status,
};
use std::hint::black_box;
use std::mem::MaybeUninit;
use std::ptr;

/// The largest measurable use of stack, in bytes.
const DEPTH: usize = 512 << 10;
const PAINT: u8 = 0xA5;
const LINE: usize = 64;

/// If `paint`, fills `DEPTH` bytes of stack below the caller with `PAINT`; else returns the number used after that.
///
/// The second call leaves its array uninitialised, so that it contains what the code between the calls has left. A
/// function with a large frame writes a word to each page: a line is used only if more than one word has changed.
#[inline(never)]
fn below(paint: bool) -> usize {
    let mut area = MaybeUninit::<[u8; DEPTH]>::uninit();
    let bytes: *mut u8 = black_box(area.as_mut_ptr()).cast();
    // SAFETY: a volatile read within the array; any byte is a u8.
    let at = |index: usize| unsafe { bytes.add(index).read_volatile() };
    if paint {
        for index in 0..DEPTH {
            // SAFETY: within the array.
            unsafe { bytes.add(index).write_volatile(PAINT) };
        }
        return 0;
    }
    let used = |line: usize| (0..LINE).filter(|&index| at(line * LINE + index) != PAINT).count() > 8;
    (0..DEPTH / LINE).position(used).map_or(0, |first| DEPTH - first * LINE)
}

fn stack_of<R: Send + 'static>(work: impl FnOnce() -> R + Send + 'static) -> (R, usize) {
    let measure = || {
        below(true);
        (work(), below(false))
    };
    std::thread::Builder::new().stack_size(2 * DEPTH).spawn(measure).unwrap().join().unwrap()
}

#[repr(align(16))]
struct Storage<const SIZE: usize>([u8; SIZE]);

#[test]
fn the_measurement_is_right() {
    #[inline(never)]
    fn takes<const BYTES: usize>() {
        black_box(&mut [7u8; BYTES]);
    }
    let [little, much] = [takes::<64>, takes::<100_000>].map(|takes| stack_of(takes).1);
    assert!((0..2000).contains(&little) && (99_000..102_000).contains(&much), "{little}, {much}");
}

fn filled(fill: unsafe extern "C" fn(*mut smr_config) -> smr_status) -> smr_config {
    let mut config = MaybeUninit::uninit();
    // SAFETY: there is memory for the configuration, and it is written before it is read.
    unsafe {
        assert_eq!(fill(config.as_mut_ptr()), smr_status::SMR_OK);
        config.assume_init()
    }
}

/// Calls `fill`, then `smr_init`. Returns the latter's status, and the maximum stack use during both calls in bytes.
fn init<const TARGET: usize, const WORKSPACE: usize>(
    fill: unsafe extern "C" fn(*mut smr_config) -> smr_status,
) -> (smr_status, usize) {
    let (mut storage, mut workspace) = (Box::new(Storage([0; TARGET])), Box::new(Storage([0; WORKSPACE])));
    stack_of(move || {
        let (config, mut tracker) = (filled(fill), ptr::null_mut());
        let (storage, workspace) = (storage.0.as_mut_ptr().cast(), workspace.0.as_mut_ptr().cast());
        // SAFETY: only this call uses the memory.
        unsafe { smr_init(storage, TARGET, workspace, WORKSPACE, &raw const config, &raw mut tracker) }
    })
}

#[test]
fn trackers_are_made_in_their_memory() {
    let (made, paper) = init::<PAPER_TARGET_SIZE, PAPER_WORKSPACE_SIZE>(smr_config_camera);
    let (also_made, robust) = init::<ROBUST_TARGET_SIZE, ROBUST_WORKSPACE_SIZE>(smr_config_robust);
    let (small_made, small) = init::<ROBUST_SMALL_TARGET_SIZE, ROBUST_SMALL_WORKSPACE_SIZE>(smr_config_small);
    println!("smr_init: {paper}, robust {robust}, small {small}");
    assert!(small < 4096, "smr_init takes {small} bytes of stack for a small tracker");
    assert!(paper < 4096 && robust < 4096, "smr_init takes {paper} bytes of stack, for a robust tracker {robust}");
    assert_eq!([made, also_made, small_made], [smr_status::SMR_OK; 3]);
    // Expects the refiner if smr-core has it: another package in the same build may have enabled it.
    let mut config = smr_core::robust::Config::robust();
    config.refiner = true;
    let expected = match config.check() {
        Ok(()) => smr_status::SMR_OK,
        Err(_) => smr_status::SMR_ERROR_REFINER_NOT_BUILT_IN,
    };
    assert_eq!(init::<ROBUST_TARGET_SIZE, ROBUST_WORKSPACE_SIZE>(smr_config_refined).0, expected);
    let small = init::<ROBUST_SMALL_TARGET_SIZE, ROBUST_SMALL_WORKSPACE_SIZE>(smr_config_small_refined).0;
    assert_eq!(small, expected);
}

#[test]
fn the_presets_differ_in_the_refiner_alone() {
    let (robust, mut refined) = (filled(smr_config_robust), filled(smr_config_refined));
    assert_eq!((robust.robust.refiner, refined.robust.refiner), (0, 1));
    refined.robust.refiner = 0;
    assert_eq!(format!("{robust:?}"), format!("{refined:?}"));
    let (small, mut refined) = (filled(smr_config_small), filled(smr_config_small_refined));
    assert_eq!((small.robust.refiner, refined.robust.refiner), (0, 1));
    refined.robust.refiner = 0;
    assert_eq!(format!("{small:?}"), format!("{refined:?}"));
    assert_eq!((robust.robust.reach, small.robust.reach), (8, 7));
}

#[test]
fn a_small_tracker_does_not_take_a_large_reach_or_a_large_tracker_its_memory() {
    /// # Safety
    /// There is memory for the configuration.
    unsafe extern "C" fn far(config: *mut smr_config) -> smr_status {
        // SAFETY: there is memory for the configuration.
        unsafe {
            let filled = smr_config_small(config);
            (*config).robust.reach = 8;
            filled
        }
    }
    let small = init::<ROBUST_SMALL_TARGET_SIZE, ROBUST_SMALL_WORKSPACE_SIZE>(far).0;
    assert_eq!(small, smr_status::SMR_ERROR_CONFIG_OUT_OF_RANGE);
    for (preset, most) in [(filled(smr_config_small_refined), 7), (filled(smr_config_refined), 8)] {
        let (mut config, mut reach) = (preset, MaybeUninit::<smr_setting>::uninit());
        // SAFETY: the configuration is filled, there is memory for a setting, and the name ends with a zero.
        let (highest, set) = unsafe {
            assert_eq!(smr_setting_at(&raw const config, 2, reach.as_mut_ptr()), smr_status::SMR_OK);
            let set = |value: u16| smr_set(&raw mut config, c"reach".as_ptr(), &raw const value, 1);
            (reach.assume_init().highest, [most, most + 1].map(set))
        };
        assert_eq!((highest, set), (most, [smr_status::SMR_OK, smr_status::SMR_ERROR_CONFIG_OUT_OF_RANGE]));
    }
    let robust = init::<ROBUST_SMALL_TARGET_SIZE, ROBUST_WORKSPACE_SIZE>(smr_config_robust).0;
    assert_eq!(robust, smr_status::SMR_ERROR_STORAGE_TOO_SMALL);
    let without = init::<{ ROBUST_TARGET_SIZE - 1056 }, ROBUST_WORKSPACE_SIZE>(smr_config_robust).0;
    assert_eq!(without, smr_status::SMR_ERROR_STORAGE_TOO_SMALL, "storage without this library's refiner");
    let robust = init::<ROBUST_TARGET_SIZE, ROBUST_SMALL_WORKSPACE_SIZE>(smr_config_robust).0;
    assert_eq!(robust, smr_status::SMR_ERROR_WORKSPACE_TOO_SMALL);
}
