//! Files that appear only when they are complete.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: check that its folder exists, is writable and has space", path.display())]
pub struct OutputError {
    /// The file.
    pub path: PathBuf,
    /// Error of the operating system.
    pub source: io::Error,
}

/// Writes a temporary file in the same folder and renames it at the end. An existing file of that name stays
/// until the new one is complete. Returns what `write` does.
///
/// # Errors
/// If the folder or the file cannot be written, or the existing file is write-protected; it is then
/// unchanged.
pub fn replace_file<T>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<T>,
) -> Result<T, OutputError> {
    let attempt = || {
        if path.is_dir() {
            return Err(io::ErrorKind::IsADirectory.into());
        }
        if is_protected(path) {
            return Err(io::ErrorKind::PermissionDenied.into());
        }
        let file = temporary_file_near(path)?;
        let mut writer = BufWriter::new(file.as_file());
        let written = write(&mut writer)?;
        writer.flush()?;
        drop(writer);
        file.persist(path).map_err(|fault| fault.error)?;
        Ok(written)
    };
    attempt().map_err(|source| output_error(path, source))
}

/// Whether a write-protected file exists. A writable folder would permit replacing it, and root may write to
/// any file: the file mode therefore counts, too.
pub fn is_protected(path: &Path) -> bool {
    let refused = |fault: io::Error| fault.kind() == io::ErrorKind::PermissionDenied;
    path.metadata().is_ok_and(|metadata| {
        let open = || File::options().append(true).open(path);
        metadata.is_file() && (metadata.permissions().readonly() || open().is_err_and(refused))
    })
}

/// Converts an error of the operating system.
pub(super) fn output_error(path: &Path, source: io::Error) -> OutputError {
    OutputError {
        path: path.to_owned(),
        source,
    }
}

/// The folder of a file.
fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Creates an unnamed file in the folder of `path`. It is deleted when closed, however the program ends.
///
/// # Errors
/// If no file can be created in the folder.
pub(super) fn unnamed_file_near(path: &Path) -> io::Result<File> {
    let made = tempfile::tempfile_in(folder(path));
    // See `temporary_file_near`.
    made.map_err(|fault| fault.kind().into())
}

/// Creates a temporary file in the folder of `path`, with the usual permissions. It is deleted when dropped.
///
/// # Errors
/// If no file can be created in the folder.
fn temporary_file_near(path: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    // Temporary files are private by default; here the user's umask applies.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // The message of the library contains the name of the temporary file, which the user does not know.
    let made = builder.prefix(".squeakscope-").tempfile_in(folder(path));
    made.map_err(|fault| fault.kind().into())
}

/// Checks that a file can be created in the folder of `path`. The test file has no name: nothing remains even
/// if the program is killed.
///
/// # Errors
/// If no file can be created in the folder.
pub fn try_folder_of(path: &Path) -> io::Result<()> {
    unnamed_file_near(path).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_folder_is_reported_without_the_name_of_a_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("absent/out");
        let made = temporary_file_near(&path).map(drop);
        for fault in [made, try_folder_of(&path)].map(Result::unwrap_err) {
            assert_eq!(fault.kind(), io::ErrorKind::NotFound);
            assert!(!fault.to_string().contains("squeakscope-"), "{fault}");
        }
    }

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("result.json");
        replace_file(&path, |f| f.write_all(b"old")).unwrap();
        let fault = replace_file(&path, |f| {
            f.write_all(b"half of the new")?;
            Err::<(), _>(io::Error::other("disk full"))
        });
        assert!(fault.unwrap_err().to_string().contains("result.json"));
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(
            std::fs::read_dir(folder.path()).unwrap().count(),
            1,
            "the temporary file is deleted"
        );
        replace_file(&path, |f| f.write_all(b"new")).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
    }

    #[test]
    fn a_protected_file_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("kept.json");
        assert!(!is_protected(&path));
        std::fs::write(&path, "old").unwrap();
        assert!(!is_protected(&path));
        let mut permissions = path.metadata().unwrap().permissions();
        permissions.set_readonly(true);
        std::fs::set_permissions(&path, permissions).unwrap();
        assert!(is_protected(&path));
        let fault = replace_file(&path, |f| f.write_all(b"new")).unwrap_err();
        assert_eq!(fault.source.kind(), io::ErrorKind::PermissionDenied);
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
    }

    #[test]
    fn a_folder_cannot_be_written_as_a_file() {
        let folder = tempfile::tempdir().unwrap();
        assert!(replace_file(folder.path(), |_| Ok(())).is_err());
        assert!(replace_file(&folder.path().join("no/such"), |_| Ok(())).is_err());
    }
}
