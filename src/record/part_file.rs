//! A file that appears under its name only when it is complete.

use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use tempfile::TempPath;

use super::error::RecordError;
use crate::export::is_protected;

/// Maximum number of part files next to one recording.
const MOST_PARTS: u32 = 99;

/// A recording that is being written next to its final path, as `name.rrd.part`.
///
/// An existing file at the final path is unchanged until [`PartFile::commit`]. A part file that is not
/// committed remains: the viewer can open it, and the error message names it.
#[derive(Debug)]
pub struct PartFile {
    path: PathBuf,
    part: PathBuf,
    /// Whether it may replace an existing file.
    replaces: bool,
}

impl PartFile {
    /// Creates a part file next to `path`, and checks that `path` can be replaced.
    ///
    /// # Errors
    /// [`RecordError::Create`] if either is not possible.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let fault = |kind: ErrorKind| RecordError::Create(path.to_owned(), kind.into());
        if path.is_dir() {
            return Err(fault(ErrorKind::IsADirectory));
        }
        if is_protected(path) {
            return Err(fault(ErrorKind::PermissionDenied));
        }
        let name = path.file_name();
        let name = name.ok_or_else(|| fault(ErrorKind::InvalidFilename))?;
        // An existing part file belongs to another run or is the remainder of one: it is not overwritten.
        let parts = (0..=MOST_PARTS).map(|taken| {
            let mut part = name.to_owned();
            if taken > 0 {
                part.push(format!(".{taken}"));
            }
            part.push(".part");
            (path.to_owned(), path.with_file_name(part))
        });
        Self::claim(parts, true)
    }

    /// Reserves the first unused name. No other run gets the same name, and a file that appears there in the
    /// meantime is not replaced.
    ///
    /// # Errors
    /// [`RecordError::Create`] if no file can be created.
    pub fn reserve(names: impl IntoIterator<Item = PathBuf>) -> Result<Self, RecordError> {
        let parts = names.into_iter().map(|path| {
            let mut part = path.clone().into_os_string();
            part.push(".part");
            (path, part.into())
        });
        Self::claim(parts, false)
    }

    /// Creates the first part file that does not exist, of pairs of final path and part.
    fn claim(
        pairs: impl Iterator<Item = (PathBuf, PathBuf)>,
        replaces: bool,
    ) -> Result<Self, RecordError> {
        let mut last = PathBuf::new();
        for (path, part) in pairs {
            match File::create_new(&part) {
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                    last = path;
                    continue;
                }
                Err(error) => return Err(RecordError::Create(path, error)),
            }
            let file = Self {
                path,
                part,
                replaces,
            };
            // Checked only now: the previous owner of the part file may just have committed it.
            if replaces || file.path.symlink_metadata().is_err() {
                return Ok(file);
            }
            last = file.abandon();
        }
        let taken = ErrorKind::AlreadyExists.into();
        Err(RecordError::Create(last, taken))
    }

    /// Final path of the recording.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Path of the part file.
    pub fn part(&self) -> &Path {
        &self.part
    }

    /// Removes the part file, which is empty, and returns the final path.
    pub fn abandon(&self) -> PathBuf {
        // A remaining empty file does no harm.
        let _ = std::fs::remove_file(&self.part);
        self.path.clone()
    }

    /// Checks that the part file still exists. Data written to a removed file are lost without an error when
    /// the program ends.
    ///
    /// # Errors
    /// [`RecordError::Removed`] if it does not.
    pub fn check_exists(&self) -> Result<(), RecordError> {
        let (path, part) = self.paths();
        let file = self.part.symlink_metadata().map(drop);
        file.map_err(|source| RecordError::Removed { path, part, source })
    }

    /// The error of a failed write.
    pub fn write_error(&self, reason: String) -> RecordError {
        let (path, part) = self.paths();
        let removed = self.check_exists().err();
        removed.unwrap_or(RecordError::Write { path, part, reason })
    }

    /// The final path and that of the part file.
    fn paths(&self) -> (PathBuf, PathBuf) {
        (self.path.clone(), self.part.clone())
    }

    /// Syncs the complete recording to storage and moves it to its final path.
    ///
    /// # Errors
    /// [`RecordError::Write`] or [`RecordError::Rename`]; the part file remains.
    pub fn commit(&self) -> Result<(), RecordError> {
        let synced = File::open(&self.part).and_then(|file| file.sync_all());
        synced.map_err(|error| self.write_error(error.to_string()))?;
        let protected = is_protected(&self.path);
        let moved = match self.replaces {
            // The existing file may have become write-protected during the run.
            true if protected => Err(ErrorKind::PermissionDenied.into()),
            true => std::fs::rename(&self.part, &self.path),
            false => self.move_to_free_name(),
        };
        let (path, part) = self.paths();
        moved.map_err(|source| RecordError::Rename { path, part, source })
    }

    fn move_to_free_name(&self) -> std::io::Result<()> {
        let part = TempPath::try_from_path(&self.part)?;
        part.persist_noclobber(&self.path).map_err(|fault| {
            // Keeps the part file, which the dropped handle would remove.
            let _ = fault.path.keep();
            fault.error
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A write-protected file is not replaced, regardless of when it became protected.
    #[test]
    fn a_protected_recording_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.rrd");
        let part = PartFile::create(&path).unwrap();
        std::fs::write(part.part(), "new").unwrap();
        std::fs::write(&path, "old").unwrap();
        let mut permissions = path.metadata().unwrap().permissions();
        permissions.set_readonly(true);
        std::fs::set_permissions(&path, permissions).unwrap();
        let refused = PartFile::create(&path).unwrap_err();
        assert!(matches!(refused, RecordError::Create { .. }), "{refused}");
        let refused = part.commit().unwrap_err();
        assert!(matches!(refused, RecordError::Rename { .. }), "{refused}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read(part.part()).unwrap(), b"new");
    }

    /// Reserved names belong to one run; a file that nevertheless appears there is not replaced.
    #[test]
    fn reserved_names_are_neither_shared_nor_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name);
        let names = || (1..=4).map(|k| file(&format!("live-{k}.rrd")));
        std::fs::write(file("live-1.rrd"), "there").unwrap();
        std::fs::write(file("live-2.rrd.part"), "begun").unwrap();
        let first = PartFile::reserve(names()).unwrap();
        let second = PartFile::reserve(names()).unwrap();
        assert_eq!(first.path(), file("live-3.rrd"));
        assert_eq!(second.path(), file("live-4.rrd"));
        let none = PartFile::reserve(names()).unwrap_err();
        assert!(matches!(none, RecordError::Create { .. }), "{none}");

        std::fs::write(first.part(), "first").unwrap();
        std::fs::write(first.path(), "another file").unwrap();
        let refused = first.commit().unwrap_err();
        assert!(matches!(refused, RecordError::Rename { .. }), "{refused}");
        assert_eq!(std::fs::read(first.path()).unwrap(), b"another file");
        assert_eq!(std::fs::read(first.part()).unwrap(), b"first");
        second.commit().unwrap();
        assert!(second.path().exists() && !second.part().exists());
    }

    /// Two runs with the same path have different part files; a remaining part file of another run is
    /// unchanged.
    #[test]
    fn parts_are_not_shared() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.rrd");
        std::fs::write(folder.path().join("run.rrd.part"), "left by another").unwrap();
        let (first, second) = (
            PartFile::create(&path).unwrap(),
            PartFile::create(&path).unwrap(),
        );
        assert_ne!(first.part(), second.part());
        std::fs::write(first.part(), "first").unwrap();
        std::fs::write(second.part(), "second").unwrap();
        first.commit().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"first");
        second.commit().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        let left = std::fs::read(folder.path().join("run.rrd.part")).unwrap();
        assert_eq!(left, b"left by another");
    }
}
