//! Output files: checked before work starts, replaced only by a complete file.

use std::path::{Component, Path, PathBuf};
use std::{fs, io};

use clap::Args as Arguments;

use super::error::CliError;
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
    pub const RECORDING: Self = Self::of(&["rrd"], Existing::Keep);
    /// The recording of a command without another output, which is replaced.
    pub const DEFAULT_RECORDING: Self = Self::of(&["rrd"], Existing::Replace);
    /// A JSON document.
    pub const JSON: Self = Self::of(&["json"], Existing::Keep);
    /// NumPy arrays.
    pub const ARRAYS: Self = Self::of(&["npz"], Existing::Keep);
    /// A sound file.
    pub const SOUND: Self = Self::of(&["wav"], Existing::Keep);
    /// A text table.
    pub const CSV: Self = Self::of(&["csv"], Existing::Keep);
    /// A table.
    pub const TABLE: Self = Self::of(&["arrow", "parquet", "csv"], Existing::Keep);
    /// The table of a study that can be resumed.
    pub const STUDY_TABLE: Self = Self::of(Self::TABLE.endings, Existing::Resume);
    /// A table that grows during a study.
    pub const GROWING_TABLE: Self = Self::of(&["arrows"], Existing::Resume);
    /// A scene file.
    pub const SCENE: Self = Self::of(&["toml"], Existing::Keep);
    /// Labels of an audio editor.
    pub const LABELS: Self = Self::of(&["txt"], Existing::Keep);
    /// A figure.
    pub const FIGURE: Self = Self::of(&["png", "svg", "pdf"], Existing::Keep);

    const fn of(endings: &'static [&'static str], existing: Existing) -> Self {
        Self { endings, existing }
    }

    /// Whether the ending of a name is one of this kind.
    fn has_ending_of(self, path: &Path) -> bool {
        let ending = path.extension().unwrap_or_default();
        let mut endings = self.endings.iter();
        endings.any(|fits| ending.eq_ignore_ascii_case(fits))
    }

    /// Checks that the ending of a path fits, that a file can be created there, and that none exists unless it may be
    /// replaced. Returns the path with resolved links.
    ///
    /// # Errors
    /// Bad input if one of these does not hold.
    pub fn check(self, path: &Path, option: &str, force: bool) -> Result<PathBuf, CliError> {
        if !self.has_ending_of(path) {
            let fault = format!(
                "has the wrong ending for this output; give a name that ends in .{}",
                self.endings.join(" or .")
            );
            return Err(refused(path, option, &fault));
        }
        let file = check_file(path, option)?;
        check_free(path, option, self.existing, force)?;
        Ok(file)
    }
}

/// A path that does not fit its output, why, and the remedy.
pub fn refused(path: &Path, option: &str, fault: &str) -> CliError {
    CliError::Input(format!("`{}` ({option}) {fault}", path.display()))
}

/// One path for two outputs.
pub fn used_twice(path: &Path, option: &str, other: &str) -> CliError {
    CliError::Input(format!(
        "`{}` is used for two outputs ({option}, {other}); choose different paths",
        path.display()
    ))
}

/// The error of the operating system for a directory that does not exist or cannot be written to.
pub fn not_writable(path: &Path, option: &str) -> impl FnOnce(io::Error) -> CliError {
    move |source| {
        CliError::Input(format!(
            "cannot write `{}` ({option}): no file can be created in its directory; create the directory or choose \
             another path: {source}",
            path.display()
        ))
    }
}

/// Checks that a file can be created at `path`, without changing an existing file, and returns the path with resolved
/// links. Messages name `option`.
///
/// # Errors
/// If the path is a directory, a device or write-protected, its name is too long, or no file can be created in its
/// directory.
pub fn check_file(path: &Path, option: &str) -> Result<PathBuf, CliError> {
    // Writing through a link replaces its target and keeps the link.
    let target = resolved(path);
    let is_directory = path.to_string_lossy().ends_with(std::path::is_separator);
    let is_file_name = target.file_name().is_some() && !is_directory;
    if !is_file_name || fs::metadata(&target).is_ok_and(|metadata| !metadata.is_file()) {
        let fault = "is not a regular file; choose another path";
        return Err(refused(path, option, fault));
    }
    check_name(path, option)?;
    if is_protected(&target) {
        let fault = "is write-protected; make it writable or choose another path";
        return Err(refused(path, option, fault));
    }
    try_folder_of(&target).map_err(not_writable(path, option))?;
    Ok(target)
}

/// Whether a path stands for the standard output: `-`.
pub fn is_stdout(path: &Path) -> bool {
    path == Path::new("-")
}

/// Checks that the file system accepts the temporary name of a file.
fn check_name(path: &Path, option: &str) -> Result<(), CliError> {
    let mut longest = path.as_os_str().to_owned();
    longest.push(LONGEST_SUFFIX);
    match fs::symlink_metadata(longest) {
        Err(fault) if fault.kind() == io::ErrorKind::InvalidFilename => {
            let fault = format!(
                "with `{LONGEST_SUFFIX}` while it is written is too long for the file system; choose a shorter name"
            );
            Err(refused(path, option, &fault))
        }
        _ => Ok(()),
    }
}

/// Resolves the links of a path, or those of its directory if the file does not exist.
pub fn resolved(path: &Path) -> PathBuf {
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

/// Checks that the files `names` can be created in a directory. The directory need not exist and is not created.
///
/// # Errors
/// If the path is not a directory and cannot become one, or one of the files cannot be written, or exists and `force` is
/// not set.
pub fn check_directory(
    path: &Path,
    option: &str,
    names: &[impl AsRef<Path>],
    force: bool,
) -> Result<(), CliError> {
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
        return Err(refused(path, option, fault));
    }
    if !path.is_dir() && Kind::FIGURE.has_ending_of(path) {
        let fault = "is to be a directory, but has the ending of a figure; give the name of a directory, and the kind \
                     of file with --format";
        return Err(refused(path, option, fault));
    }
    try_folder_of(&ancestor.join("figure")).map_err(not_writable(path, option))?;
    for name in names {
        let file = path.join(name);
        if path.is_dir() {
            check_file(&file, option)?;
        } else {
            check_name(&file, option)?;
        }
        check_free(&file, option, Existing::Keep, force)?;
    }
    Ok(())
}

/// Refuses a file that exists and may not be replaced.
fn check_free(path: &Path, option: &str, existing: Existing, force: bool) -> Result<(), CliError> {
    let remedy = match existing {
        Existing::Keep => "replace it with --force",
        Existing::Resume => "continue it with --resume, replace it with --force",
        Existing::Replace => return Ok(()),
    };
    if force || !path.exists() {
        return Ok(());
    }
    let fault = format!("exists; {remedy}, or choose another name");
    Err(refused(path, option, &fault))
}

#[cfg(test)]
#[path = "output_tests.rs"]
mod tests;
