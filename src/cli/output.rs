//! Output files: checked before work starts, replaced only by a complete file.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::export::{is_protected, replace_file, try_folder_of};

/// Longest suffix of a temporary name: a recording, if other recordings of that name are being written.
const LONGEST_SUFFIX: &str = ".99.part";

/// A path that has passed the checks of [`OutputFile::check`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFile {
    path: PathBuf,
}

/// Reason why an output cannot be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The path is a directory, a device or another special file.
    #[error("cannot write `{path}` ({option}): it is not a regular file; choose another path")]
    NotAFile {
        /// Path of the output.
        path: PathBuf,
        /// Option that names the output.
        option: &'static str,
    },
    /// Two outputs have the same path.
    #[error("`{path}` is used for two outputs ({option}, {other}); choose different paths")]
    Twice {
        /// Path of the output.
        path: PathBuf,
        /// Option that names the output.
        option: &'static str,
        /// Other option with the same path.
        other: &'static str,
    },
    /// The output would replace the input: the scene or the signal.
    #[error("`{path}` ({option}) is the input; choose another path for the output")]
    IsInput {
        /// Path of the output.
        path: PathBuf,
        /// Option that names the output.
        option: &'static str,
    },
    /// The path is not a directory, and a directory cannot be created there.
    #[error(
        "cannot write to `{path}` ({option}): it is not a directory and cannot be created; choose \
         another path"
    )]
    NotADirectory {
        /// Path of the output.
        path: PathBuf,
        /// Option that names the output.
        option: &'static str,
    },
    /// The directory does not exist or cannot be written to.
    #[error(
        "cannot write `{path}` ({option}): no file can be created in its directory; create the directory or \
         choose another path"
    )]
    NotWritable {
        /// Path of the output.
        path: PathBuf,
        /// Option that names the output.
        option: &'static str,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The existing file is write-protected.
    #[error(
        "cannot replace `{path}` ({option}): it is write-protected; make it writable or choose another path"
    )]
    Protected {
        /// Path of the output.
        path: PathBuf,
        /// Option that names the output.
        option: &'static str,
    },
    /// The name or the path is too long for the file system.
    #[error(
        "cannot write `{path}` ({option}): its name, with `{LONGEST_SUFFIX}` while it is written, is too \
         long for the file system; choose a shorter name"
    )]
    NameTooLong {
        /// Path of the output.
        path: PathBuf,
        /// Option that names the output.
        option: &'static str,
    },
    /// The standard output cannot be written.
    #[error("cannot write to the standard output; check its destination and the free space")]
    Terminal(#[source] io::Error),
    /// Writing failed after the checks had passed.
    #[error("cannot write `{path}`; a file that existed before is unchanged")]
    Failed {
        /// Path of the output.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
}

impl OutputError {
    /// Whether the path is invalid input (exit code 2), in contrast to a failure while writing (exit code 1).
    pub fn is_bad_input(&self) -> bool {
        !matches!(self, Self::Failed { .. } | Self::Terminal(_))
    }
}

impl OutputFile {
    /// Checks that a file can be created at `path`, without changing an existing file. Messages name
    /// `option`.
    ///
    /// # Errors
    /// If the path is a directory, a device or write-protected, its name is too long, or no file can be
    /// created in its directory.
    pub fn check(path: &Path, option: &'static str) -> Result<Self, OutputError> {
        // Writing through a link replaces its target and keeps the link.
        let target = resolved(path);
        let is_file_name = target.file_name().is_some() && !ends_in_separator(path);
        if !is_file_name || fs::metadata(&target).is_ok_and(|there| !there.is_file()) {
            return Err(OutputError::NotAFile {
                path: path.to_owned(),
                option,
            });
        }
        check_name(path, option)?;
        if is_protected(&target) {
            let path = path.to_owned();
            return Err(OutputError::Protected { path, option });
        }
        let file = Self { path: target };
        try_folder_of(&file.path).map_err(|source| OutputError::NotWritable {
            path: path.to_owned(),
            option,
            source,
        })?;
        Ok(file)
    }

    /// The path with resolved links.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Size of the written file, bytes.
    ///
    /// # Errors
    /// If the file does not exist.
    pub fn size(&self) -> Result<u64, OutputError> {
        let there = fs::metadata(&self.path).map_err(|source| OutputError::Failed {
            path: self.path.clone(),
            source,
        })?;
        Ok(there.len())
    }

    /// Writes a temporary file in the same directory, then renames it: the file is always complete.
    ///
    /// # Errors
    /// If writing or renaming fails; an existing file is then unchanged.
    pub fn write(
        &self,
        content: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        replace_file(&self.path, content).map_err(|fault| OutputError::Failed {
            path: fault.path,
            source: fault.source,
        })
    }
}

/// Whether a path stands for the standard output: `-`.
pub fn is_stdout(path: &Path) -> bool {
    path == Path::new("-")
}

/// Checks that the file system accepts the temporary name of a file.
fn check_name(path: &Path, option: &'static str) -> Result<(), OutputError> {
    let mut longest = path.as_os_str().to_owned();
    longest.push(LONGEST_SUFFIX);
    match fs::symlink_metadata(longest) {
        Err(fault) if fault.kind() == io::ErrorKind::InvalidFilename => {
            let path = path.to_owned();
            Err(OutputError::NameTooLong { path, option })
        }
        _ => Ok(()),
    }
}

/// Checks that the files `names` can be created in a directory. The directory need not exist and is not
/// created.
///
/// # Errors
/// If the path is not a directory and cannot become one, or one of the files cannot be written.
pub fn check_directory<N: AsRef<Path>>(
    path: &Path,
    option: &'static str,
    names: &[N],
) -> Result<(), OutputError> {
    let refused = || OutputError::NotADirectory {
        path: path.to_owned(),
        option,
    };
    // The nearest existing ancestor.
    let there = path.ancestors().find(|a| fs::symlink_metadata(a).is_ok());
    let there = there.unwrap_or(Path::new("."));
    if path.as_os_str().is_empty() || !there.is_dir() {
        return Err(refused());
    }
    try_folder_of(&there.join("figure")).map_err(|source| OutputError::NotWritable {
        path: path.to_owned(),
        option,
        source,
    })?;
    for name in names {
        let file = path.join(name);
        match path.is_dir() {
            true => drop(OutputFile::check(&file, option)?),
            false => check_name(&file, option)?,
        }
    }
    Ok(())
}

/// Checks that no output file has the path of a directory that will be created.
///
/// # Errors
/// If an output file has the path of the directory or of one of its ancestors.
pub fn check_apart(
    directory: &Path,
    option: &'static str,
    others: &[(&'static str, Option<&OutputFile>)],
) -> Result<(), OutputError> {
    for (other, file) in others {
        let is_file = |a: &Path| file.is_some_and(|file| file.path() == resolved(a));
        if directory.ancestors().any(is_file) {
            return Err(OutputError::Twice {
                path: directory.to_owned(),
                option,
                other,
            });
        }
    }
    Ok(())
}

/// Checks that no other output has the path of one of the files `names` in a directory.
///
/// # Errors
/// If two outputs have the same path.
pub fn check_distinct(
    directory: &Path,
    option: &'static str,
    names: &[String],
    others: &[(&'static str, Option<&OutputFile>)],
) -> Result<(), OutputError> {
    let places: Vec<PathBuf> = names
        .iter()
        .map(|name| resolved(&directory.join(name)))
        .collect();
    for (other, file) in others {
        if let Some(file) = file.filter(|file| places.iter().any(|place| file.path() == place)) {
            return Err(OutputError::Twice {
                path: file.path().to_owned(),
                option: other,
                other: option,
            });
        }
    }
    Ok(())
}

/// Resolves the links of a path, or those of its directory if the file does not exist.
fn resolved(path: &Path) -> PathBuf {
    let of_directory = || {
        let parent = path.parent().filter(|parent| *parent != Path::new(""));
        let directory = fs::canonicalize(parent.unwrap_or(Path::new("."))).ok()?;
        Some(directory.join(path.file_name()?))
    };
    fs::canonicalize(path)
        .ok()
        .or_else(of_directory)
        .unwrap_or_else(|| path.to_owned())
}

/// Whether a path ends in a separator, as the path of a directory.
fn ends_in_separator(path: &Path) -> bool {
    path.as_os_str()
        .to_string_lossy()
        .ends_with(std::path::is_separator)
}

/// Checks each output of a command, that no two have the same path, and that none replaces the `input`: the
/// name or path of a scene, or the path of a signal.
///
/// # Errors
/// The first output that cannot be written, is used twice, or is the input.
pub fn check_all<const N: usize>(
    input: Option<&OsStr>,
    wanted: [(&'static str, Option<&Path>); N],
) -> Result<[Option<OutputFile>; N], OutputError> {
    let input = input.and_then(|name| fs::canonicalize(name).ok());
    let mut files: [Option<OutputFile>; N] = [const { None }; N];
    for k in 0..N {
        let (option, Some(path)) = wanted[k] else {
            continue;
        };
        let file = OutputFile::check(path, option)?;
        if input.as_deref() == Some(file.path()) {
            let path = path.to_owned();
            return Err(OutputError::IsInput { path, option });
        }
        let same = (0..k).find(|&j| files[j].as_ref() == Some(&file));
        if let Some(j) = same {
            return Err(OutputError::Twice {
                path: path.to_owned(),
                option,
                other: wanted[j].0,
            });
        }
        files[k] = Some(file);
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn names_in(folder: &Path) -> usize {
        fs::read_dir(folder).expect("a folder").count()
    }

    #[test]
    fn checks_change_nothing_and_writing_replaces_complete_files() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("out.json");
        let file = OutputFile::check(&path, "--json").expect("writable");
        assert_eq!(names_in(folder.path()), 0);
        file.write(|out| out.write_all(b"first")).expect("written");
        let failed = file.write(|out| {
            out.write_all(b"half")?;
            Err(io::Error::other("disk full"))
        });
        assert!(!failed.expect_err("failed").is_bad_input());
        assert_eq!(fs::read(&path).expect("there"), b"first");
        file.write(|out| out.write_all(b"second")).expect("written");
        assert_eq!(fs::read(&path).expect("there"), b"second");
        assert_eq!(names_in(folder.path()), 1);
    }

    #[test]
    fn paths_that_cannot_be_files_are_refused() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let check = |path: &Path| OutputFile::check(path, "--save");
        assert!(matches!(
            check(folder.path()),
            Err(OutputError::NotAFile { .. })
        ));
        for path in ["absent/", ".."] {
            let path = folder.path().join(path);
            assert!(matches!(check(&path), Err(OutputError::NotAFile { .. })));
        }
        assert!(matches!(
            check(Path::new("")),
            Err(OutputError::NotAFile { .. })
        ));
        let lost = check(&folder.path().join("absent/out.rrd")).expect_err("no such folder");
        assert!(matches!(lost, OutputError::NotWritable { .. }));
        assert!(lost.is_bad_input());
        assert!(lost.to_string().contains("(--save)"));
        #[cfg(unix)]
        assert!(matches!(
            check(Path::new("/dev/null")),
            Err(OutputError::NotAFile { .. })
        ));
    }

    #[test]
    fn directories_may_exist_but_files_of_that_name_are_refused() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let file = folder.path().join("file");
        fs::write(&file, "x").expect("written");
        let check = |path: &Path| check_directory(path, "--png", &["figure.png"]);
        check(folder.path()).expect("there");
        check(&folder.path().join("new/figures")).expect("can be made");
        for path in [&file, &file.join("figures"), Path::new("")] {
            let error = check(path).expect_err("no directory");
            assert!(matches!(error, OutputError::NotADirectory { .. }));
        }
        assert_eq!(names_in(folder.path()), 1);
    }

    #[test]
    fn a_new_directory_and_a_file_cannot_share_a_path() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let [new, below] = ["new", "new/figures"].map(|name| folder.path().join(name));
        let file = OutputFile::check(&new, "--csv").expect("writable");
        for directory in [&new, &below] {
            let clash = check_apart(directory, "--png", &[("--csv", Some(&file))]);
            assert!(matches!(clash, Err(OutputError::Twice { .. })));
            check_apart(directory, "--png", &[("--csv", None)]).expect("no file");
        }
        let other = folder.path().join("other");
        check_apart(&other, "--png", &[("--csv", Some(&file))]).expect("apart");
    }

    #[test]
    fn protected_files_and_long_names_are_refused_in_directories_too() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("kept.png");
        fs::write(&path, "old").expect("written");
        let mut permissions = path.metadata().expect("there").permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).expect("protected");
        for refused in [
            OutputFile::check(&path, "--png").map(drop),
            check_directory(folder.path(), "--png", &["new.png", "kept.png"]),
        ] {
            let refused = refused.expect_err("protected");
            assert!(
                matches!(refused, OutputError::Protected { .. }),
                "{refused}"
            );
            assert!(refused.is_bad_input());
        }
        check_directory(folder.path(), "--png", &["new.png"]).expect("free");
        let long = folder.path().join("x".repeat(255));
        let longer = folder.path().join("x".repeat(256));
        for refused in [
            OutputFile::check(&long, "--png").map(drop),
            check_directory(&longer, "--png", &["new.png"]),
            check_directory(&longer.join("new"), "--png", &["new.png"]),
        ] {
            let refused = refused.expect_err("too long");
            assert!(
                matches!(refused, OutputError::NameTooLong { .. }),
                "{refused}"
            );
        }
        OutputFile::check(&folder.path().join("x".repeat(247)), "--png").expect("fits");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_and_its_target_is_replaced() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "old").expect("written");
        std::os::unix::fs::symlink(&file, &link).expect("linked");
        let output = OutputFile::check(&link, "--json").expect("writable");
        output.write(|out| out.write_all(b"new")).expect("written");
        assert_eq!(fs::read(&file).expect("there"), b"new");
        assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
    }

    #[test]
    fn two_outputs_cannot_share_a_path() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("out");
        let twice = check_all(
            None,
            [
                ("--save", Some(&*path)),
                ("--npz", None),
                ("--json", Some(&*path)),
            ],
        );
        let missing = folder.path().join("new");
        let detour = folder.path().join(".").join("new");
        let two_names = [("--save", Some(&*missing)), ("--json", Some(&*detour))];
        let error = check_all(None, two_names).expect_err("the same file, not there yet");
        assert!(matches!(error, OutputError::Twice { .. }));
        fs::write(&missing, "a scene").expect("written");
        let onto_scene = [("--save", Some(&*detour))];
        let error = check_all(Some(missing.as_os_str()), onto_scene).expect_err("the scene");
        assert!(matches!(error, OutputError::IsInput { .. }));
        let message = twice.expect_err("refused").to_string();
        assert!(
            message.contains("two outputs (--json, --save)"),
            "{message}"
        );
    }
}
