//! Files that appear only when they are whole.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: check that its folder exists, is writable and has space", path.display())]
pub struct OutputError {
    /// The file.
    pub path: PathBuf,
    /// What the system said.
    pub source: io::Error,
}

/// Writes a file beside its place and moves it there at the end, so that an old file of that name
/// stays until the new one is whole.
///
/// # Errors
/// If the folder or the file cannot be written, or the old file is write-protected, which is then untouched.
pub fn replace_file(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> Result<(), OutputError> {
    let attempt = || {
        if path.is_dir() {
            return Err(io::ErrorKind::IsADirectory.into());
        }
        if is_protected(path) {
            return Err(io::ErrorKind::PermissionDenied.into());
        }
        let file = temporary_beside(path)?;
        let mut writer = BufWriter::new(file.as_file());
        write(&mut writer)?;
        writer.flush()?;
        drop(writer);
        file.persist(path).map_err(|fault| fault.error)?;
        Ok(())
    };
    attempt().map_err(|source| failed(path, source))
}

/// Whether a file is there that may not be written to. A folder that may be written to would let it be replaced all
/// the same, and root may write to anything: so its mode counts, too.
pub fn is_protected(path: &Path) -> bool {
    let refused = |fault: io::Error| fault.kind() == io::ErrorKind::PermissionDenied;
    path.metadata().is_ok_and(|there| {
        let open = || File::options().append(true).open(path);
        there.is_file() && (there.permissions().readonly() || open().is_err_and(refused))
    })
}

/// What it is that a file could not be written.
pub(super) fn failed(path: &Path, source: io::Error) -> OutputError {
    OutputError {
        path: path.to_owned(),
        source,
    }
}

/// The folder that a file is in.
fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// A new file without a name, where `path` will be: gone when closed, however the program ends.
///
/// # Errors
/// If no file can be made there.
pub(super) fn nameless_beside(path: &Path) -> io::Result<File> {
    let made = tempfile::tempfile_in(folder(path));
    // As below.
    made.map_err(|fault| fault.kind().into())
}

/// A new file in the folder of `path`, gone when dropped; as readable as any other file.
///
/// # Errors
/// If no file can be made there.
fn temporary_beside(path: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    // Temporary files are private by default; here the user's umask decides.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // The library's message has the name of the temporary file, which nobody asked for.
    let made = builder.prefix(".squeakscope-").tempfile_in(folder(path));
    made.map_err(|fault| fault.kind().into())
}

/// Whether a file can be made in the folder of `path`. It is tried with one that has no name, so that nothing is
/// left behind even if the program ends right then.
///
/// # Errors
/// If no file can be made there.
pub fn try_folder_of(path: &Path) -> io::Result<()> {
    let made = tempfile::tempfile_in(folder(path));
    made.map(drop).map_err(|fault| fault.kind().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_folder_is_told_without_the_name_of_a_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("absent/out");
        let made = temporary_beside(&path).map(drop);
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
            Err(io::Error::other("disk full"))
        });
        assert!(fault.unwrap_err().to_string().contains("result.json"));
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(
            std::fs::read_dir(folder.path()).unwrap().count(),
            1,
            "nothing left beside"
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
    fn a_folder_is_not_a_file() {
        let folder = tempfile::tempdir().unwrap();
        assert!(replace_file(folder.path(), |_| Ok(())).is_err());
        assert!(replace_file(&folder.path().join("no/such"), |_| Ok(())).is_err());
    }
}
