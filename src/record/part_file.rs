//! A file that takes its name only when it is whole.

use std::{
    fs::File,
    io::ErrorKind,
    path::{Path, PathBuf},
};

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
            part_name.push(match taken {
                0 => ".part".to_owned(),
                n => format!(".{n}.part"),
            });
            let part = path.with_file_name(part_name);
            match File::create_new(&part) {
                Ok(_) => {
                    return Ok(Self {
                        path: path.to_owned(),
                        part,
                    });
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists && taken < MOST_PARTS => {
                    taken += 1;
                }
                Err(error) => return Err(fault(error)),
            }
        }
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
        // It may have been protected since.
        let free = match is_protected(&self.path) {
            true => Err(ErrorKind::PermissionDenied.into()),
            false => Ok(()),
        };
        let moved = free.and_then(|()| std::fs::rename(&self.part, &self.path));
        moved.map_err(|source| RecordError::Rename {
            path: self.path.clone(),
            part: self.part.clone(),
            source,
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
