//! Clean-up before this program ends on a signal: kills child processes, and removes unfinished files and folders.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::{fs, io};

enum Resource {
    Path(PathBuf),
    Process(Arc<Mutex<Child>>),
}

/// All registered files, folders and child processes, by the id in their [`Kept`].
static RESOURCES: Mutex<BTreeMap<u64, Resource>> = Mutex::new(BTreeMap::new());

/// Locks a mutex even if a thread panicked while holding it, because registered files must still be removed.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Registration of a file, folder or child process for clean-up on a signal. A drop unregisters the resource.
pub(crate) struct Kept(u64);

impl Drop for Kept {
    fn drop(&mut self) {
        locked(&RESOURCES).remove(&self.0);
    }
}

/// Creates a file, folder or process and registers it; no signal is handled in between.
fn keep<T>(make: impl FnOnce() -> io::Result<T>, resource: impl FnOnce(&T) -> Resource) -> io::Result<(T, Kept)> {
    let mut resources = locked(&RESOURCES);
    let made = make()?;
    let number = resources.last_key_value().map_or(0, |(last, _)| last + 1);
    resources.insert(number, resource(&made));
    Ok((made, Kept(number)))
}

pub(crate) fn keep_path<T: AsRef<Path>>(make: impl FnOnce() -> io::Result<T>) -> io::Result<(T, Kept)> {
    keep(make, |made| Resource::Path(made.as_ref().to_owned()))
}

pub(crate) fn keep_process(command: &mut Command) -> io::Result<(Arc<Mutex<Child>>, Kept)> {
    keep(|| Ok(Arc::new(Mutex::new(command.spawn()?))), |child| Resource::Process(Arc::clone(child)))
}

/// Runs `act` without interruption: a signal that arrives meanwhile ends this program afterwards.
pub(crate) fn undisturbed<T>(act: impl FnOnce() -> T) -> T {
    let _resources = locked(&RESOURCES);
    act()
}

pub(crate) fn end(child: &Mutex<Child>) {
    let mut child = locked(child);
    // `kill` and `wait` fail only if the process has ended and been reaped.
    let _ = child.kill();
    let _ = child.wait();
}

/// Kills all registered processes, removes all registered files and folders, and ends this program. It holds the lock
/// until then, so that nothing new is registered.
pub(crate) fn exit(code: i32) -> ! {
    let resources = locked(&RESOURCES);
    // Kills processes first, because they write into the files.
    for resource in resources.values() {
        if let Resource::Process(child) = resource {
            end(child);
        }
    }
    for resource in resources.values() {
        if let Resource::Path(path) = resource {
            // The path may have been renamed by now, or be gone.
            let _ = remove(path);
        }
    }
    std::process::exit(code)
}

/// Removes a file or a folder. A folder is renamed first, so that threads that still write do not find it.
fn remove(path: &Path) -> io::Result<()> {
    if path.is_file() {
        return fs::remove_file(path);
    }
    let gone = path.with_extension("gone");
    fs::rename(path, &gone).and_then(|()| fs::remove_dir_all(gone)).or_else(|_| fs::remove_dir_all(path))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    // Windows renames no folder in which a file is open.
    #[cfg(unix)]
    #[test]
    fn a_folder_goes_while_files_are_written_into_it() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join(".smr-files");
        fs::create_dir(&folder).unwrap();
        let write = |number: u32| fs::write(folder.join(number.to_string()), "a file");
        (0..100).try_for_each(write).unwrap();
        thread::scope(|scope| {
            let writer = scope.spawn(|| (100..50_000).try_for_each(write));
            remove(&folder).unwrap();
            assert!(writer.join().unwrap().is_err());
        });
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 0);
    }
}
