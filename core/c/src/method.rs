//! The trackers behind the handle: their layout in the caller's memory, their construction, and their calls.
//!
//! Only the presets refer to a tracker's code, so that a program links only the trackers whose presets it calls.

use crate::answer::smr_answer;
use crate::capacity::{
    ALIGNMENT, PAPER_TARGET_SIZE, PAPER_WORKSPACE_SIZE, PaperTarget, ROBUST_SMALL_TARGET_SIZE,
    ROBUST_SMALL_WORKSPACE_SIZE, ROBUST_TARGET_SIZE, ROBUST_WORKSPACE_SIZE, SIGNED_DIFFERENCES, SmallTarget,
};
use crate::config::{smr_config, smr_method};
use crate::pointer::{self, Out};
#[cfg(feature = "unstable")]
use crate::status::SMR_ERROR_OTHER_METHOD;
use crate::status::{SMR_ERROR_NOT_INITIALISED, SMR_UNDER_WAY, smr_status};
#[cfg(feature = "unstable")]
use crate::tracker::ResponseMap;
use crate::tracker::{Call, Known, Tracked, smr_tracker};
use core::ffi::c_void;
use core::mem::offset_of;
use core::ops::Range;
use core::ptr::{self, NonNull};
use smr_core::calls::{self, Checked};
use smr_core::robust::{Size, Small, Standard};
use smr_core::{Frame, Rect, Robust, Target, Windows, robust};

/// A tracker of `smr-core`, with what C needs to construct it.
pub(crate) trait Method: Target + 'static {
    const METHOD: smr_method;

    fn configuration(config: &smr_config) -> Self::Config;

    fn known(&mut self) -> Known<'_>;

    #[cfg(feature = "unstable")]
    fn response_map(&self, _: &mut Self::Workspace, _: &Frame<'_>) -> Result<ResponseMap, smr_status> {
        Err(SMR_ERROR_OTHER_METHOD)
    }
}

/// The value of `smr_config::method` for the tracker `T`.
pub(crate) fn method_of<T: Method>() -> *const smr_method {
    &raw const *const { &T::METHOD }
}

impl Method for PaperTarget {
    const METHOD: smr_method = smr_method {
        robust: None,
        target_size: PAPER_TARGET_SIZE,
        workspace_size: PAPER_WORKSPACE_SIZE,
        make: make::<Self>,
    };

    fn configuration(config: &smr_config) -> Self::Config {
        config.paper()
    }

    fn known(&mut self) -> Known<'_> {
        Known::Paper(self)
    }
}

/// A size of the robust tracker, with its memory and its preset without the refiner.
pub(crate) trait SizeInC: Size + Sized {
    const PRESET: robust::Config = robust::Config::robust().within::<Self>();
    const TARGET_SIZE: usize;
    const WORKSPACE_SIZE: usize;

    fn known(target: &mut Robust<Self>) -> Known<'_>;
}

impl SizeInC for Standard {
    const TARGET_SIZE: usize = ROBUST_TARGET_SIZE;
    const WORKSPACE_SIZE: usize = ROBUST_WORKSPACE_SIZE;

    fn known(target: &mut Robust<Self>) -> Known<'_> {
        Known::Robust(target)
    }
}

impl SizeInC for Small {
    const TARGET_SIZE: usize = ROBUST_SMALL_TARGET_SIZE;
    const WORKSPACE_SIZE: usize = ROBUST_SMALL_WORKSPACE_SIZE;

    fn known(target: &mut Robust<Self>) -> Known<'_> {
        Known::Small(target)
    }
}

impl<S: SizeInC> Method for Robust<S> {
    const METHOD: smr_method = smr_method {
        robust: Some(S::PRESET),
        target_size: S::TARGET_SIZE,
        workspace_size: S::WORKSPACE_SIZE,
        make: make::<Self>,
    };

    fn configuration(config: &smr_config) -> Self::Config {
        config.robust(&S::PRESET)
    }

    fn known(&mut self) -> Known<'_> {
        S::known(self)
    }

    #[cfg(feature = "unstable")]
    fn response_map(&self, workspace: &mut Self::Workspace, frame: &Frame<'_>) -> Result<ResponseMap, smr_status> {
        Ok(smr_core::unstable::response_map(self, workspace, frame)?)
    }
}

/// The contents of a tracker's storage.
#[repr(C)] // the handle comes first: its address is that of the storage
struct Stored<T: Method> {
    handle: smr_tracker,
    own: OwnTracker<T>,
}

struct OwnTracker<T: Method> {
    workspace: *mut Scratch<T>,
    target: T,
}

/// The contents of a workspace.
#[repr(C)] // the mark comes first: a tracker of another method that takes the memory overwrites it
struct Scratch<T: Method> {
    /// Result of [`Scratch::mark_of`] for the workspace's address. Any other value shows that the memory is not a
    /// workspace for this type of tracker.
    mark: usize,
    workspace: T::Workspace,
}

impl<T: Method> Scratch<T> {
    /// The mark of a workspace at `address`. It differs between the trackers.
    fn mark_of(address: *const Self) -> usize {
        address.addr() ^ 0x534D_5257 ^ T::METHOD.target_size // "SMRW"
    }
}

const _: () = assert!(
    fits::<Stored<PaperTarget>>(PAPER_TARGET_SIZE, 0)
        && fits::<Scratch<PaperTarget>>(PAPER_WORKSPACE_SIZE, SIGNED_DIFFERENCES)
        && fits::<Stored<Robust>>(ROBUST_TARGET_SIZE, 0)
        && fits::<Scratch<Robust>>(ROBUST_WORKSPACE_SIZE, SIGNED_DIFFERENCES)
        && fits::<Stored<SmallTarget>>(ROBUST_SMALL_TARGET_SIZE, 0)
        && fits::<Scratch<SmallTarget>>(ROBUST_SMALL_WORKSPACE_SIZE, SIGNED_DIFFERENCES)
);

/// True if `size` is a multiple of `ALIGNMENT` that holds an aligned `T` with 0 to 64 bytes to spare, or with
/// `optional` to `optional` + 64 bytes, because some builds omit fields of `optional` bytes from `T`.
const fn fits<T>(size: usize, optional: usize) -> bool {
    let Some(spare) = size.checked_sub(size_of::<T>()) else { return false };
    let aligned = align_of::<T>() <= ALIGNMENT && size.is_multiple_of(ALIGNMENT);
    aligned && (spare <= 64 || optional <= spare && spare <= optional + 64)
}

/// # Safety
/// `T::METHOD.target_size` bytes at `storage` and `T::METHOD.workspace_size` bytes at `workspace` can be written, and both
/// are aligned to `ALIGNMENT`. As long as the tracker is used, only its calls use the former, and only calls on trackers
/// that share it the latter.
unsafe fn make<T: Method>(storage: *mut c_void, workspace: *mut c_void, config: &smr_config) -> Result<(), smr_status> {
    let (storage, workspace) = (storage.cast::<Stored<T>>(), workspace.cast::<Scratch<T>>());
    let config = T::configuration(config);
    T::check_config(&config)?;
    // SAFETY: both have the bytes that the method states, enough for the types (`fits`), and are aligned. Each field is
    // written in place.
    unsafe {
        (&raw mut (*storage).own.target).write(T::UNLOCKED);
        (*storage).own.target.set_config(config);
        (&raw mut (*storage).own.workspace).write(workspace);
        (&raw mut (*storage).handle).write(smr_tracker::new(storage.cast(), &raw mut (*storage).own));
        (&raw mut (*workspace).workspace).write(T::UNUSED);
        (&raw mut (*workspace).mark).write(Scratch::mark_of(workspace));
    }
    Ok(())
}

impl<T: Method> OwnTracker<T> {
    /// The workspace; `None` if its memory was overwritten.
    fn workspace(&self) -> Option<NonNull<Scratch<T>>> {
        let workspace = self.workspace;
        // SAFETY: `make` wrote this address, and by the header of `smr_init` the memory stays. Only the mark is read:
        // any bytes are a usize.
        if unsafe { (&raw const (*workspace).mark).read() } != Scratch::mark_of(workspace) {
            return None;
        }
        NonNull::new(workspace)
    }

    /// The target and its workspace, for a call that has passed its checks.
    #[inline(never)] // one copy in flash
    fn parts(&mut self) -> Result<(&mut T, &mut T::Workspace), smr_status> {
        let mut scratch = self.workspace().ok_or(SMR_ERROR_NOT_INITIALISED)?;
        // SAFETY: the mark shows that a workspace of this type is there. By the header, calls on trackers that share it
        // do not overlap, so nobody else uses it.
        let Scratch { workspace, .. } = unsafe { scratch.as_mut() };
        Ok((&mut self.target, workspace))
    }
}

#[inline(never)] // keeps its stack out of that of a step
fn conclude<T: Method>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>, out: &Out<smr_answer>) {
    out.write(calls::commit(target, workspace, frame).into());
}

impl<T: Method> Tracked for OwnTracker<T> {
    fn known(&mut self) -> Known<'_> {
        self.target.known()
    }

    fn memory(&self) -> [Range<usize>; 2] {
        let smr_method { target_size, workspace_size, .. } = T::METHOD;
        let storage = ptr::from_ref(self).addr() - offset_of!(Stored<T>, own);
        [storage..storage + target_size, pointer::range(self.workspace, workspace_size)]
    }

    fn lock_window(&self, bounds: Rect, target: Rect) -> Rect {
        self.target.lock_window(bounds, target)
    }

    fn begin(&mut self, frame: &Frame<'_>, call: &Call, work: Option<u32>) -> Result<bool, smr_status> {
        let checked = match call {
            Call::Lock(bbox) => Checked::lock(&self.target, frame, *bbox)?,
            Call::Update(_) => Checked::update(&self.target, frame)?,
        };
        let (target, workspace) = self.parts()?;
        Ok(checked.begin(target, workspace, work))
    }

    fn step(&mut self, frame: &Frame<'_>, call: &Call, work: Option<u32>) -> Result<(), smr_status> {
        let (target, workspace) = self.parts()?;
        if !calls::step(target, workspace, frame, work) {
            return Err(SMR_UNDER_WAY);
        }
        match call {
            Call::Lock(_) => drop(calls::commit_lock(target, workspace, frame)),
            Call::Update(out) => conclude(target, workspace, frame, out),
        }
        Ok(())
    }

    fn windows(&self) -> Option<Windows> {
        self.target.windows()
    }

    #[cfg(feature = "unstable")]
    fn work(&self) -> Result<u32, smr_status> {
        // SAFETY: the mark shows that a workspace of this type is there, and calls that write it do not overlap this
        // one.
        Ok(T::work(unsafe { &self.workspace().ok_or(SMR_ERROR_NOT_INITIALISED)?.as_ref().workspace }))
    }

    #[cfg(feature = "unstable")]
    fn response_map(&mut self, frame: &Frame<'_>) -> Result<ResponseMap, smr_status> {
        if T::METHOD.robust.is_none() {
            return Err(SMR_ERROR_OTHER_METHOD);
        }
        let _ = Checked::update(&self.target, frame)?;
        let (target, workspace) = self.parts()?;
        Method::response_map(target, workspace, frame)
    }
}
