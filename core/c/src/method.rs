//! What the calls of the header do on the tracker of one method. Only a configuration names a method, so that a program
//! links those that it uses.

use crate::answer::smr_answer;
use crate::capacity::PaperTarget;
use crate::config::smr_config;
use crate::frame::smr_image;
use crate::pointer::{self, Out};
use crate::status::{
    SMR_ERROR_BUFFER_TOO_SMALL, SMR_ERROR_NOT_INITIALISED, SMR_ERROR_NOT_LOCKED, SMR_ERROR_OTHER_METHOD, smr_status,
};
use crate::tracker::smr_tracker;
use core::ffi::c_void;
use core::mem::offset_of;
use core::ops::Range;
use core::ptr;
use smr_core::{FineRect, Frame, LockError, Quality, Rect, Robust, State, Target};

/// The code of a tracker.
pub struct smr_method {
    pub(crate) target_size: usize,
    pub(crate) workspace_size: usize,
    /// Makes a tracker, and its workspace; nothing is written if it fails.
    ///
    /// # Safety
    /// The first two point to memory of these sizes and of alignment `ALIGNMENT`; as for [`Method::configuration`].
    pub(crate) make: unsafe fn(*mut c_void, *mut c_void, &smr_config) -> Result<(), smr_status>,
}

/// One of the two trackers.
pub(crate) trait Method: Target + 'static {
    const METHOD: smr_method;

    /// # Safety
    /// As for `table::given`, of the table of the paper's configuration.
    unsafe fn configuration(config: &smr_config) -> Result<Self::Config, smr_status>;

    fn template(&self) -> Result<Option<smr_image>, smr_status> {
        Err(SMR_ERROR_OTHER_METHOD)
    }

    fn alpha(&self) -> Result<u16, smr_status> {
        Err(SMR_ERROR_OTHER_METHOD)
    }

    /// # Safety
    /// There is memory for `size` bytes at `pixels`.
    unsafe fn early_template(&self, _pixels: *mut u8, _size: usize) -> Result<smr_image, smr_status> {
        Err(SMR_ERROR_OTHER_METHOD)
    }
}

impl smr_method {
    pub(crate) fn of<T: Method>() -> *const Self {
        &raw const *const { &T::METHOD }
    }
}

impl Method for PaperTarget {
    const METHOD: smr_method = smr_method {
        target_size: crate::capacity::PAPER_TARGET_SIZE,
        workspace_size: crate::capacity::PAPER_WORKSPACE_SIZE,
        make: make::<Self>,
    };

    unsafe fn configuration(config: &smr_config) -> Result<Self::Config, smr_status> {
        // SAFETY: as the caller says.
        unsafe { config.paper() }
    }

    fn template(&self) -> Result<Option<smr_image>, smr_status> {
        let image = |image: smr_core::Image<'_>| {
            let pixels = image.rows().next().map_or(ptr::null(), <[u8]>::as_ptr);
            smr_image { pixels, width: image.width(), height: image.height() }
        };
        Ok(PaperTarget::template(self).map(image))
    }

    fn alpha(&self) -> Result<u16, smr_status> {
        Ok(PaperTarget::alpha(self))
    }
}

impl Method for Robust {
    const METHOD: smr_method = smr_method {
        target_size: crate::capacity::ROBUST_TARGET_SIZE,
        workspace_size: crate::capacity::ROBUST_WORKSPACE_SIZE,
        make: make::<Self>,
    };

    unsafe fn configuration(config: &smr_config) -> Result<Self::Config, smr_status> {
        Ok(config.robust())
    }

    unsafe fn early_template(&self, pixels: *mut u8, size: usize) -> Result<smr_image, smr_status> {
        let (Some(grid), Some(template)) = (self.grid(), Robust::early_template(self)) else {
            return Err(SMR_ERROR_NOT_LOCKED);
        };
        if size < template.len() {
            return Err(SMR_ERROR_BUFFER_TOO_SMALL);
        }
        for (at, pixel) in template.enumerate() {
            // SAFETY: the caller says that there is memory for `size` pixels, which are not fewer.
            unsafe { pixels.add(at).write(pixel) }
        }
        Ok(smr_image { pixels, width: grid.columns, height: grid.rows })
    }
}

/// What lies in the storage of a tracker.
#[repr(C)] // the handle first: it is where the storage is
pub(crate) struct Stored<T: Method> {
    handle: smr_tracker,
    held: Held<T>,
}

/// A target, and where its workspace is.
pub(crate) struct Held<T: Method> {
    workspace: *mut Scratch<T>,
    target: T,
}

/// What lies in a workspace.
#[repr(C)] // the mark first: whoever uses the memory for the other method's trackers writes over it
pub(crate) struct Scratch<T: Method> {
    /// [`Scratch::mark_of`] its own address, so that other memory is not taken for a workspace.
    mark: usize,
    workspace: T::Workspace,
}

impl<T: Method> Scratch<T> {
    /// Another one for each method.
    fn mark_of(address: *const Self) -> usize {
        address.addr() ^ 0x534D_5257 ^ T::METHOD.target_size // "SMRW"
    }
}

/// As `make` of [`smr_method`].
unsafe fn make<T: Method>(storage: *mut c_void, workspace: *mut c_void, config: &smr_config) -> Result<(), smr_status> {
    let (storage, workspace) = (storage.cast::<Stored<T>>(), workspace.cast::<Scratch<T>>());
    // SAFETY: as the caller says.
    let config = unsafe { T::configuration(config)? };
    let target = T::new(config)?;
    // SAFETY: the caller says that there is memory for both; each field is written where it is.
    unsafe {
        (&raw mut (*storage).held.target).write(target);
        (&raw mut (*storage).held.workspace).write(workspace);
        (&raw mut (*storage).handle).write(smr_tracker::new(storage.cast(), &raw mut (*storage).held));
        (&raw mut (*workspace).workspace).write(T::Workspace::default());
        (&raw mut (*workspace).mark).write(Scratch::mark_of(workspace));
    }
    Ok(())
}

/// A tracker, whichever method it has.
pub(crate) trait Tracked {
    /// The addresses of the storage and of the workspace.
    fn memory(&self) -> [Range<usize>; 2];
    fn lock_window(&self, bounds: Rect, target: Rect) -> Rect;
    fn begin_lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<(), smr_status>;
    fn finish_lock(&mut self, frame: &Frame<'_>) -> Result<(), smr_status>;
    fn quality(&self) -> Option<Quality>;
    fn begin(&mut self, frame: &Frame<'_>) -> Result<(), smr_status>;
    fn step(&mut self, frame: &Frame<'_>, work: u32) -> Result<bool, smr_status>;
    /// Writes the answer where it goes: returned, it would be on the stack twice.
    fn finish(&mut self, frame: &Frame<'_>, out: Out<smr_answer>) -> Result<(), smr_status>;
    fn window(&self) -> Option<Rect>;
    fn sweep_window(&self) -> Option<Rect>;
    fn last(&self) -> Option<(FineRect, State)>;
    fn moved(&mut self, right: i32, down: i32);
    fn most_saved_size(&self) -> usize;
    fn saved_size(&self) -> Result<usize, smr_status>;
    fn save(&self, bytes: &mut [u8]) -> Result<usize, smr_status>;
    fn restore(&mut self, bytes: &[u8]) -> Result<(), smr_status>;
    fn template(&self) -> Result<Option<smr_image>, smr_status>;
    fn alpha(&self) -> Result<u16, smr_status>;
    /// # Safety
    /// As for [`Method::early_template`].
    unsafe fn early_template(&self, pixels: *mut u8, size: usize) -> Result<smr_image, smr_status>;
}

impl<T: Method> Held<T> {
    /// Target and workspace; the latter may be in use by another tracker.
    fn parts(&mut self) -> Result<(&mut T, &mut T::Workspace), smr_status> {
        let workspace = self.workspace;
        // SAFETY: `make` has put it there; only the mark is read, and every usize is one.
        if unsafe { (&raw const (*workspace).mark).read() } != Scratch::mark_of(workspace) {
            return Err(SMR_ERROR_NOT_INITIALISED);
        }
        // SAFETY: the mark says that a whole workspace is there, and the caller of each call that it is used alone.
        Ok((&mut self.target, unsafe { &mut (*workspace).workspace }))
    }
}

impl<T: Method> Tracked for Held<T> {
    fn memory(&self) -> [Range<usize>; 2] {
        let smr_method { target_size, workspace_size, .. } = T::METHOD;
        let storage = ptr::from_ref(self).addr() - offset_of!(Stored<T>, held);
        [storage..storage + target_size, pointer::range(self.workspace, workspace_size)]
    }

    fn lock_window(&self, bounds: Rect, target: Rect) -> Rect {
        self.target.lock_window(bounds, target)
    }

    fn begin_lock(&mut self, frame: &Frame<'_>, rect: Rect) -> Result<(), smr_status> {
        let (target, workspace) = self.parts()?;
        target.begin_lock(workspace, frame, rect)?;
        Ok(())
    }

    fn finish_lock(&mut self, frame: &Frame<'_>) -> Result<(), smr_status> {
        let (target, workspace) = self.parts()?;
        target.resume_lock(workspace, frame)?.finish();
        Ok(())
    }

    fn begin(&mut self, frame: &Frame<'_>) -> Result<(), smr_status> {
        let (target, workspace) = self.parts()?;
        target.begin(workspace, frame)?;
        Ok(())
    }

    fn step(&mut self, frame: &Frame<'_>, work: u32) -> Result<bool, smr_status> {
        let (target, workspace) = self.parts()?;
        match target.resume_lock(workspace, frame) {
            Ok(mut lock) => return Ok(lock.step(work)),
            Err(LockError::NotBegun) => {}
            Err(error) => return Err(error.into()),
        }
        Ok(target.resume(workspace, frame)?.step(work))
    }

    fn finish(&mut self, frame: &Frame<'_>, out: Out<smr_answer>) -> Result<(), smr_status> {
        let (target, workspace) = self.parts()?;
        out.write(target.resume(workspace, frame)?.finish().into());
        Ok(())
    }

    fn window(&self) -> Option<Rect> {
        self.target.window()
    }

    fn sweep_window(&self) -> Option<Rect> {
        self.target.sweep_window()
    }

    fn quality(&self) -> Option<Quality> {
        self.target.quality()
    }

    fn last(&self) -> Option<(FineRect, State)> {
        self.target.bbox().zip(self.target.state())
    }

    fn moved(&mut self, right: i32, down: i32) {
        self.target.moved(right, down);
    }

    fn most_saved_size(&self) -> usize {
        T::SAVED_SIZE
    }

    fn saved_size(&self) -> Result<usize, smr_status> {
        Ok(self.target.saved_size()?)
    }

    fn save(&self, bytes: &mut [u8]) -> Result<usize, smr_status> {
        Ok(self.target.save(bytes)?)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), smr_status> {
        Ok(self.target.restore(bytes)?)
    }

    fn template(&self) -> Result<Option<smr_image>, smr_status> {
        Method::template(&self.target)
    }

    fn alpha(&self) -> Result<u16, smr_status> {
        Method::alpha(&self.target)
    }

    unsafe fn early_template(&self, pixels: *mut u8, size: usize) -> Result<smr_image, smr_status> {
        // SAFETY: as the caller says.
        unsafe { Method::early_template(&self.target, pixels, size) }
    }
}
