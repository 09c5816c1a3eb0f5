//! A file that takes its name only when it is whole.

use std::{
    fs::File,
    io::ErrorKind,
    path::{Path, PathBuf},
};

use tempfile::TempPath;

use super::error::RecordError;
use crate::export::is_protected;

/// The most parts that may lie beside one recording.
const MOST_PARTS: u32 = 99;

/// A recording being written beside the place where it will stand: `name.rrd.part`.
///
/// Whatever stood at the final place stays untouched until [`PartFile::keep`]. A part that is
/// not kept is left in place: it can be opened in the viewer, and its error names it.
#[derive(Debug)]
pub struct PartFile {
    path: PathBuf,
    part: PathBuf,
    /// Whether it takes the place of a file that is there.
    replaces: bool,
}

impl PartFile {
    /// Makes sure that a file can be written beside `path` and that `path` can be replaced.
    ///
    /// # Errors
    /// [`RecordError::Create`] when it cannot.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let fault = |source| RecordError::Create {
            path: path.to_owned(),
            source,
        };
        if path.is_dir() {
            return Err(fault(std::io::ErrorKind::IsADirectory.into()));
        }
        if is_protected(path) {
            return Err(fault(ErrorKind::PermissionDenied.into()));
        }
        let Some(name) = path.file_name() else {
            return Err(fault(std::io::ErrorKind::InvalidFilename.into()));
        };
        // A part that is there belongs to another run, or is all that is left of one: it is kept.
        let mut taken = 0;
        loop {
            let mut part_name = name.to_owned();
            if taken > 0 {
                part_name.push(format!(".{taken}"));
            }
            part_name.push(".part");
            let part = path.with_file_name(part_name);
            match File::create_new(&part) {
                Ok(_) => {
                    return Ok(Self {
                        path: path.to_owned(),
                        part,
                        replaces: true,
                    });
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists && taken < MOST_PARTS => {
                    taken += 1;
                }
                Err(error) => return Err(fault(error)),
            }
        }
    }

    /// Reserves the first of some names that nobody has: no other run is given it, and a file that appears
    /// there meanwhile is not replaced.
    ///
    /// # Errors
    /// [`RecordError::Create`] when no file can be made there.
    pub fn reserve(names: impl IntoIterator<Item = PathBuf>) -> Result<Self, RecordError> {
        let mut last = PathBuf::new();
        for path in names {
            let mut part = path.clone().into_os_string();
            part.push(".part");
            match File::create_new(&part) {
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                    last = path;
                    continue;
                }
                Err(source) => return Err(RecordError::Create { path, source }),
            }
            let file = Self {
                path,
                part: part.into(),
                replaces: false,
            };
            // Asked only now: whoever had the part may just have given its file this name.
            if file.path.symlink_metadata().is_err() {
                return Ok(file);
            }
            last = file.discard();
        }
        Err(RecordError::Create {
            path: last,
            source: ErrorKind::AlreadyExists.into(),
        })
    }

    /// Gives up what has not been begun; the name that it would have had.
    pub fn discard(self) -> PathBuf {
        // An empty file that stays is no loss.
        let _ = std::fs::remove_file(&self.part);
        self.path
    }

    /// Where the recording will stand.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where the recording is being written.
    pub fn part(&self) -> &Path {
        &self.part
    }

    /// Not even a beginning can be written: takes the empty part away.
    pub fn refused(&self, source: std::io::Error) -> RecordError {
        // Whoever asks for the recording is told of the first fault.
        let _ = std::fs::remove_file(&self.part);
        RecordError::Create {
            path: self.path.clone(),
            source,
        }
    }

    /// Nobody can write it: takes the empty part away.
    pub fn without_thread(&self, source: std::io::Error) -> RecordError {
        let _ = std::fs::remove_file(&self.part);
        RecordError::Thread {
            path: self.path.clone(),
            source,
        }
    }

    /// Makes sure that what is being written still has a name: without one it would end with the
    /// program, and nothing that is written would tell.
    ///
    /// # Errors
    /// [`RecordError::Gone`].
    pub fn still_there(&self) -> Result<(), RecordError> {
        let there = self.part.symlink_metadata();
        there.map(drop).map_err(|source| RecordError::Gone {
            path: self.path.clone(),
            part: self.part.clone(),
            source,
        })
    }

    /// Writing has failed.
    pub fn write_error(&self, reason: String) -> RecordError {
        if let Err(gone) = self.still_there() {
            return gone;
        }
        RecordError::Write {
            path: self.path.clone(),
            part: self.part.clone(),
            reason,
        }
    }

    /// Puts the whole recording in its place, on stable storage first.
    ///
    /// # Errors
    /// [`RecordError::Write`] or [`RecordError::Rename`]; the part is left.
    pub fn keep(&self) -> Result<(), RecordError> {
        let synced = File::open(&self.part).and_then(|file| file.sync_all());
        synced.map_err(|error| self.write_error(error.to_string()))?;
        let protected = is_protected(&self.path);
        let moved = match self.replaces {
            // It may have been protected since.
            true if protected => Err(ErrorKind::PermissionDenied.into()),
            true => std::fs::rename(&self.part, &self.path),
            false => self.move_to_free_name(),
        };
        moved.map_err(|source| RecordError::Rename {
            path: self.path.clone(),
            part: self.part.clone(),
            source,
        })
    }

    fn move_to_free_name(&self) -> std::io::Result<()> {
        let part = TempPath::try_from_path(&self.part)?;
        part.persist_noclobber(&self.path).map_err(|fault| {
            // It would be removed with its handle.
            let _ = fault.path.keep();
            fault.error
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file without write permission is not replaced, whenever it lost it.
    #[test]
    fn a_protected_recording_stays() {
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
        let refused = part.keep().unwrap_err();
        assert!(matches!(refused, RecordError::Rename { .. }), "{refused}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read(part.part()).unwrap(), b"new");
    }

    /// Names that are reserved belong to one run, and what appears there in spite of that is not replaced.
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
        std::fs::write(first.path(), "somebody else's").unwrap();
        let refused = first.keep().unwrap_err();
        assert!(matches!(refused, RecordError::Rename { .. }), "{refused}");
        assert_eq!(std::fs::read(first.path()).unwrap(), b"somebody else's");
        assert_eq!(std::fs::read(first.part()).unwrap(), b"first");
        second.keep().unwrap();
        assert!(second.path().exists() && !second.part().exists());
    }

    /// Two runs to one place have a part each; what another run left is not touched.
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
        first.keep().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"first");
        second.keep().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        let left = std::fs::read(folder.path().join("run.rrd.part")).unwrap();
        assert_eq!(left, b"left by another");
    }
}
