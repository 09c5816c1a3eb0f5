//! Output files: checked before work starts, replaced only by a complete file.

use std::ffi::OsStr;
use std::path::{Component, Path, PathBuf};
use std::{fs, io};

use clap::Args as Arguments;
use thiserror::Error;

use crate::export::{is_protected, try_folder_of};

/// Longest suffix of a temporary name: a recording, if other recordings of that name are being written.
const LONGEST_SUFFIX: &str = ".99.part";

/// Whether outputs overwrite existing files.
#[derive(Clone, Copy, Debug, Default, Arguments)]
pub struct Overwrite {
    /// Replace outputs that exist.
    #[arg(long, help_heading = "Output")]
    pub force: bool,
}

/// Kind of an output file.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Endings of its name, without the dot.
    endings: &'static [&'static str],
    existing: Existing,
}

/// What a command does with an existing output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Existing {
    /// Replace it with `--force` only.
    Keep,
    /// As `Keep`; the command can also continue it with `--resume`.
    Resume,
    /// Replace it.
    Replace,
}

impl Kind {
    /// A recording for the Rerun viewer.
    pub const RECORDING: Self = Self::of(&["rrd"]);
    /// A JSON document.
    pub const JSON: Self = Self::of(&["json"]);
    /// NumPy arrays.
    pub const ARRAYS: Self = Self::of(&["npz"]);
    /// A sound file.
    pub const SOUND: Self = Self::of(&["wav"]);
    /// A text table.
    pub const CSV: Self = Self::of(&["csv"]);
    /// A table.
    pub const TABLE: Self = Self::of(&["arrow", "parquet", "csv"]);
    /// The table of a study that can be resumed.
    pub const STUDY_TABLE: Self = Self {
        existing: Existing::Resume,
        ..Self::TABLE
    };
    /// A table that grows during a study.
    pub const GROWING_TABLE: Self = Self {
        existing: Existing::Resume,
        ..Self::of(&["arrows"])
    };
    /// A scene file.
    pub const SCENE: Self = Self::of(&["toml"]);
    /// Labels of an audio editor.
    pub const LABELS: Self = Self::of(&["txt"]);
    /// A figure.
    pub const FIGURE: Self = Self::of(&["png", "svg", "pdf"]);

    const fn of(endings: &'static [&'static str]) -> Self {
        Self {
            endings,
            existing: Existing::Keep,
        }
    }

    /// The same kind of file, which is replaced without `--force`: a default output.
    pub const fn replaced(self) -> Self {
        Self {
            existing: Existing::Replace,
            ..self
        }
    }

    /// Whether this is a recording, which takes memory while it is written.
    pub fn is_recording(self) -> bool {
        self.endings == Self::RECORDING.endings
    }

    /// Checks the ending of a name.
    fn check_ending(self, path: &Path, option: &'static str) -> Result<(), OutputError> {
        let ending = path.extension().unwrap_or_default();
        let mut endings = self.endings.iter();
        if endings.any(|fits| ending.eq_ignore_ascii_case(fits)) {
            return Ok(());
        }
        let fault = format!(
            "has the wrong ending for this output; give a name that ends in .{}",
            self.endings.join(" or .")
        );
        Err(OutputError::refused(path, option, &fault))
    }
}

/// Reason why an output cannot be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// A path that does not fit its output: which, why, and the remedy.
    #[error("{0}")]
    Refused(String),
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
    /// The standard output cannot be written.
    #[error("cannot write to the standard output; check its destination and the free space")]
    Terminal(#[source] io::Error),
}

impl OutputError {
    fn refused(path: &Path, option: &str, fault: &str) -> Self {
        Self::Refused(format!("`{}` ({option}) {fault}", path.display()))
    }

    /// One path for two outputs.
    pub fn twice(path: &Path, option: &str, other: &str) -> Self {
        Self::Refused(format!(
            "`{}` is used for two outputs ({option}, {other}); choose different paths",
            path.display()
        ))
    }

    /// Whether the path is invalid input (exit code 2), in contrast to a failure while writing (exit code 1).
    pub fn is_bad_input(&self) -> bool {
        !matches!(self, Self::Terminal(_))
    }
}

/// Checks that a file can be created at `path`, without changing an existing file, and returns the path with resolved
/// links. Messages name `option`.
///
/// # Errors
/// If the path is a directory, a device or write-protected, its name is too long, or no file can be created in its
/// directory.
pub fn check_file(path: &Path, option: &'static str) -> Result<PathBuf, OutputError> {
    // Writing through a link replaces its target and keeps the link.
    let target = resolved(path);
    let is_file_name = target.file_name().is_some() && !ends_in_separator(path);
    if !is_file_name || fs::metadata(&target).is_ok_and(|metadata| !metadata.is_file()) {
        let fault = "is not a regular file; choose another path";
        return Err(OutputError::refused(path, option, fault));
    }
    check_name(path, option)?;
    if is_protected(&target) {
        let fault = "is write-protected; make it writable or choose another path";
        return Err(OutputError::refused(path, option, fault));
    }
    check_folder(&target, path, option)?;
    Ok(target)
}

/// Checks that a file can be created in the folder of `target`. Messages name `path`.
fn check_folder(target: &Path, path: &Path, option: &'static str) -> Result<(), OutputError> {
    try_folder_of(target).map_err(|source| OutputError::NotWritable {
        path: path.to_owned(),
        option,
        source,
    })
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
            let fault = format!(
                "with `{LONGEST_SUFFIX}` while it is written is too long for the file system; choose a shorter name"
            );
            Err(OutputError::refused(path, option, &fault))
        }
        _ => Ok(()),
    }
}

/// Checks that no output file has the path of a directory that will be created.
///
/// # Errors
/// If an output file has the path of the directory or of one of its ancestors.
pub fn check_apart(
    directory: &Path,
    option: &'static str,
    files: &[(&'static str, PathBuf)],
) -> Result<(), OutputError> {
    let is_above = |file: &PathBuf| directory.ancestors().any(|a| *file == resolved(a));
    match files.iter().find(|(_, file)| is_above(file)) {
        Some((other, _)) => Err(OutputError::twice(directory, option, other)),
        None => Ok(()),
    }
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

impl Overwrite {
    /// Replaces existing files.
    pub const ALLOWED: Self = Self { force: true };

    /// Also replaces existing files if this holds: the outputs of a study that is resumed.
    pub fn or(self, resume: bool) -> Self {
        Self {
            force: self.force || resume,
        }
    }

    /// Checks each output of a command: that its ending fits, that no two have the same path, that none exists
    /// unless it may be replaced, and that none replaces the `input`: the name or path of a scene, or the path of a
    /// signal.
    ///
    /// # Errors
    /// The first output that cannot be written, exists, is used twice, or is the input.
    pub fn check_all(
        self,
        input: Option<&OsStr>,
        wanted: &[(&'static str, Kind, PathBuf)],
    ) -> Result<Vec<(&'static str, PathBuf)>, OutputError> {
        let input = input.and_then(|name| fs::canonicalize(name).ok());
        let mut files: Vec<(&'static str, PathBuf)> = Vec::new();
        for (option, kind, path) in wanted {
            if input.is_some() && input.as_deref() == Some(&resolved(path)) {
                let fault = "is the input; choose another path for the output";
                return Err(OutputError::refused(path, option, fault));
            }
            kind.check_ending(path, option)?;
            let file = check_file(path, option)?;
            if let Some((other, _)) = files.iter().find(|(_, other)| *other == file) {
                return Err(OutputError::twice(path, option, other));
            }
            self.check_free(path, option, kind.existing)?;
            files.push((option, file));
        }
        Ok(files)
    }

    /// Checks that the files `names` can be created in a directory. The directory need not exist and is not created.
    ///
    /// # Errors
    /// If the path is not a directory and cannot become one, or one of the files exists or cannot be written.
    pub fn check_directory<N: AsRef<Path>>(
        self,
        path: &Path,
        option: &'static str,
        names: &[N],
    ) -> Result<(), OutputError> {
        // The nearest existing ancestor.
        let existing = path.ancestors().find(|a| fs::symlink_metadata(a).is_ok());
        // `new/..` leads nowhere before `new` is created.
        let mut created = path
            .components()
            .skip(existing.map_or(0, |folder| folder.components().count()));
        let ancestor = existing.unwrap_or(Path::new("."));
        let is_found = ancestor.is_dir() && !created.any(|part| part == Component::ParentDir);
        if path.as_os_str().is_empty() || !is_found {
            let fault = "is not a directory and cannot be created; choose another path";
            return Err(OutputError::refused(path, option, fault));
        }
        if !path.is_dir() && Kind::FIGURE.check_ending(path, option).is_ok() {
            let fault = "is to be a directory, but has the ending of a figure; give the name of a directory, and the \
                         kind of file with --format";
            return Err(OutputError::refused(path, option, fault));
        }
        check_folder(&ancestor.join("figure"), path, option)?;
        for name in names {
            let file = path.join(name);
            if path.is_dir() {
                check_file(&file, option)?;
            } else {
                check_name(&file, option)?;
            }
            self.check_free(&file, option, Existing::Keep)?;
        }
        Ok(())
    }

    /// Refuses a file that exists and may not be replaced.
    fn check_free(
        self,
        path: &Path,
        option: &'static str,
        existing: Existing,
    ) -> Result<(), OutputError> {
        let remedy = match existing {
            Existing::Keep => "replace it with --force",
            Existing::Resume => "continue it with --resume, replace it with --force",
            Existing::Replace => return Ok(()),
        };
        if self.force || !path.exists() {
            return Ok(());
        }
        let fault = format!("exists; {remedy}, or choose another name");
        Err(OutputError::refused(path, option, &fault))
    }
}

#[cfg(test)]
#[path = "output_tests.rs"]
mod tests;
