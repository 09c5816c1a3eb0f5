//! How every command that has a result runs: check the outputs, work with progress until it is done or interrupted,
//! write the files, and print the report or the JSON.

use std::ffi::OsStr;
use std::fmt::Display;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use clap::Args as Arguments;
use indicatif::{ProgressBar, ProgressStyle};
use schemars::JsonSchema;
use serde::Serialize;

use super::console::{print, print_warning};
use super::error::CliError;
use super::figures::{FigureArgs, FigureStyle};
use super::output::{Kind, Overwrite, check_directory, is_stdout, refused, resolved, used_twice};
use super::{interrupt, resources};
use crate::export;
use crate::number::size;
use crate::plot::{Figure, Format};
use crate::report::{Report, terminal};
use crate::study::Stopped;
use crate::{VERSION, escape};

/// Number of written files up to which each has a line.
const MOST_LISTED: usize = 20;

/// The JSON of the result, and whether outputs replace files.
#[derive(Clone, Debug, Default, Arguments)]
#[command(next_help_heading = "Output")]
pub struct OutputArgs {
    /// Also write the result as JSON; `-` prints it instead of the report.
    #[arg(long, value_name = "FILE|-")]
    pub json: Option<PathBuf>,
    #[command(flatten)]
    pub overwrite: Overwrite,
}

impl OutputArgs {
    /// Whether the standard output carries the JSON, and nothing else.
    pub fn prints_json(&self) -> bool {
        self.json.as_deref().is_some_and(is_stdout)
    }
}

/// The outputs of a command, each with the option that names it: checked before the work, written and listed after it.
pub(super) struct Outputs<'a> {
    /// The name or path of a scene, or the path of a signal, which no output may replace.
    input: Option<PathBuf>,
    /// Whether existing files are replaced.
    pub force: bool,
    /// Whether the report is printed, unless the JSON is: the command may print something else.
    pub prints_report: bool,
    json: Option<&'a Path>,
    files: Vec<(&'static str, PathBuf)>,
    figures: Option<Figures<'a>>,
    written: Vec<WrittenFile>,
}

/// The option of figures.
const FIGURES: &str = "--figures";

/// Where and how figures are drawn: to a directory, or a single one to a file of this format.
struct Figures<'a> {
    path: &'a Path,
    drawn: FigureStyle,
    single: Option<Format>,
}

/// A written file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct WrittenFile {
    /// Path of the file.
    pub path: PathBuf,
    /// Size of the file, bytes.
    pub bytes: u64,
}

impl<'a> Outputs<'a> {
    /// No file yet; no output may replace `input`, the name or path of a scene, or the path of a signal.
    pub fn new(input: Option<&OsStr>, args: &'a OutputArgs) -> Self {
        Self {
            input: input.and_then(|name| fs::canonicalize(name).ok()),
            force: args.overwrite.force,
            prints_report: true,
            json: args.json.as_deref(),
            files: Vec::new(),
            figures: None,
            written: Vec::new(),
        }
    }

    /// Adds a file, if it is requested, and checks it without changing a file.
    ///
    /// # Errors
    /// If it cannot be written, exists, is used twice, or is the input.
    pub fn file(
        mut self,
        option: &'static str,
        kind: Kind,
        path: Option<impl AsRef<Path>>,
    ) -> Result<Self, CliError> {
        let Some(path) = path.as_ref().map(AsRef::<Path>::as_ref) else {
            return Ok(self);
        };
        if self.input.is_some() && self.input == Some(resolved(path)) {
            let fault = "is the input; choose another path for the output";
            return Err(refused(path, option, fault));
        }
        let file = kind.check(path, option, self.force)?;
        if let Some((other, _)) = self.files.iter().find(|(_, other)| *other == file) {
            return Err(used_twice(path, option, other));
        }
        self.files.push((option, file));
        Ok(self)
    }

    /// Adds the JSON document, after all other files.
    ///
    /// # Errors
    /// As [`Outputs::file`], and if there is no memory for a recording.
    pub fn check(self) -> Result<Self, CliError> {
        let json = self.json.filter(|path| !is_stdout(path));
        let checked = self.file("--json", Kind::JSON, json)?;
        if checked.path("--save").is_some() {
            resources::check_memory()?;
        }
        Ok(checked)
    }

    /// Adds the JSON document, and the figures of these stems, if they are requested.
    ///
    /// # Errors
    /// As [`Outputs::check`].
    pub fn figures<S: Display>(
        self,
        args: &'a FigureArgs,
        formats: &'static [Format],
        stems: impl IntoIterator<Item = S>,
    ) -> Result<Self, CliError> {
        let mut checked = self.check()?;
        let Some(path) = args.path.as_deref() else {
            return Ok(checked);
        };
        let drawn = args.drawn.or_formats(formats);
        let stems: Vec<S> = stems.into_iter().collect();
        let is_single = stems.len() == 1 && !path.is_dir();
        let single = Format::of(path).filter(|_| is_single);
        if single.is_some() {
            checked = checked.file(FIGURES, Kind::FIGURE, Some(path))?;
        } else {
            check_directory(path, FIGURES, &drawn.names(&stems), checked.force)?;
            // No file may have the path of the directory or of one above it.
            let is_above = |file: &PathBuf| path.ancestors().any(|a| *file == resolved(a));
            if let Some((other, _)) = checked.files.iter().find(|(_, file)| is_above(file)) {
                return Err(used_twice(path, FIGURES, other));
            }
        }
        checked.figures = Some(Figures {
            path,
            drawn,
            single,
        });
        Ok(checked)
    }

    /// The path of an option, if its file is requested.
    pub fn path(&self, option: &str) -> Option<PathBuf> {
        let file = self.files.iter().find(|(name, _)| *name == option);
        file.map(|(_, path)| path.clone())
    }

    /// Lists a file that has been written.
    ///
    /// # Errors
    /// If the file does not exist.
    pub fn add(&mut self, path: &Path) -> Result<(), export::OutputError> {
        let path = path.to_owned();
        match fs::metadata(&path) {
            Ok(file) => {
                let bytes = file.len();
                self.written.push(WrittenFile { path, bytes });
                Ok(())
            }
            Err(source) => Err(export::OutputError { path, source }),
        }
    }

    /// Writes the file of an option, if it is requested, and lists it.
    ///
    /// # Errors
    /// Those of `write`.
    pub fn write<E>(
        &mut self,
        option: &str,
        write: impl FnOnce(&Path) -> Result<(), E>,
    ) -> Result<(), CliError>
    where
        CliError: From<E>,
    {
        if let Some(path) = self.path(option) {
            write(&path)?;
            self.add(&path)?;
        }
        Ok(())
    }

    /// Draws the figures, if they are requested, and lists their files.
    ///
    /// # Errors
    /// A size at which texts have no room; failure while drawing or writing.
    pub fn draw(&mut self, figures: impl FnOnce() -> Vec<Figure>) -> Result<(), CliError> {
        let Some(wanted) = &self.figures else {
            return Ok(());
        };
        let (drawn, single) = (&wanted.drawn, wanted.single);
        let paths = drawn.write(wanted.path, FIGURES, &figures(), single)?;
        paths.iter().try_for_each(|path| Ok(self.add(path)?))
    }

    /// Ends a command: clears the progress bar, writes the files of the result and delivers it. The report is printed even
    /// if a file cannot be written.
    ///
    /// # Errors
    /// Those of `write`, and [`CliError::Interrupted`] for a part of a result.
    pub fn finish(
        mut self,
        watch: Watch<'_>,
        scene: Option<&str>,
        result: &dyn Report,
        write: impl FnOnce(&mut Self) -> Result<(), CliError>,
    ) -> Result<(), CliError> {
        let written = write(&mut self);
        drop(watch);
        self.deliver(scene, result)?;
        written?;
        if result.is_interrupted() {
            return Err(CliError::Interrupted);
        }
        Ok(())
    }

    /// Prints the report and the list of files, or the JSON if it is requested on the standard output; writes the JSON
    /// file.
    ///
    /// # Errors
    /// If the JSON file or the standard output cannot be written.
    pub fn deliver(&self, scene: Option<&str>, result: &dyn Report) -> Result<(), CliError> {
        let document = Document {
            version: VERSION.to_owned(),
            scene: scene.map(str::to_owned),
            result,
            files: self.written.clone(),
        };
        let json = || -> io::Result<String> { Ok(serde_json::to_string_pretty(&document)? + "\n") };
        if self.json.is_some_and(is_stdout) {
            return print(&json().map_err(CliError::Terminal)?);
        }
        let written = match self.path("--json") {
            Some(path) => export::replace_file(&path, |out| out.write_all(json()?.as_bytes())),
            None => Ok(()),
        };
        if self.prints_report {
            let report = terminal(&result.blocks(scene.unwrap_or_default()));
            print(&format!("{report}{}", list(&self.written)))?;
        }
        Ok(written?)
    }
}

/// Files with their sizes, one per line; of many files, those of one directory.
fn list(files: &[WrittenFile]) -> String {
    let line = |group: &[WrittenFile]| match group {
        [file] => format!("  {} ({})\n", escape::path(&file.path), size(file.bytes)),
        _ => {
            let directory = group[0].path.with_file_name("");
            let directory = escape::path(&directory);
            let bytes = group.iter().map(|file| file.bytes).sum();
            format!("  {directory} ({} files, {})\n", group.len(), size(bytes))
        }
    };
    // Files of the current directory have no directory to name.
    let is_together = |a: &WrittenFile, b: &WrittenFile| {
        let directory = a.path.parent().filter(|path| *path != Path::new(""));
        files.len() > MOST_LISTED && directory.is_some() && directory == b.path.parent()
    };
    files.chunk_by(is_together).map(line).collect()
}

/// A result as JSON, with the version of the program, the scene and the written files.
///
/// Later versions may add fields, but do not change the meaning of a field. The unit of a number is the suffix of its
/// field name. Non-finite numbers are `null`.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Document<R> {
    /// Version of squeakscope.
    version: String,
    /// Name of the scene; absent in a result without a scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    scene: Option<String>,
    #[serde(flatten)]
    result: R,
    /// Written files.
    files: Vec<WrittenFile>,
}

/// Progress of the work, and whether the user has interrupted it.
pub(super) struct Watch<'a> {
    bar: ProgressBar,
    stop: &'a AtomicBool,
}

impl<'a> Watch<'a> {
    /// Shows a progress bar with an estimate of the remaining time on a terminal.
    pub fn new(stop: &'a AtomicBool) -> Self {
        let template = "{elapsed} [{bar:30}] {percent:>3} %, about {eta} left: {msg}";
        let style = ProgressStyle::with_template(template)
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("=> ");
        let bar = ProgressBar::new(1_000_000).with_style(style);
        Self { bar, stop }
    }

    /// Shows the completed share, 0 to 1, and the task.
    pub fn show(&self, share: f64, task: &str) {
        self.bar.set_message(task.to_owned());
        // The bar counts in integers.
        self.bar.set_position((share * 1e6).round() as u64);
    }

    /// Shows the completed share and the task. From the first call on, an interrupt does not end the program, but this
    /// work.
    ///
    /// # Errors
    /// If the user has interrupted the work.
    pub fn update(&self, share: f64, task: &str) -> Result<(), Stopped> {
        self.show(share, task);
        interrupt::check(self.stop)
    }

    /// The progress of a study: [`Watch::update`].
    pub fn progress(&self) -> impl FnMut(f64, &str) -> Result<(), Stopped> {
        |share, task| self.update(share, task)
    }

    /// Returns a function that prints warnings above the progress bar, from any thread.
    pub fn notifier(&self) -> impl Fn(&str) + Clone + Send + use<> {
        let bar = self.bar.clone();
        move |message| bar.suspend(|| print_warning(message))
    }
}

impl Drop for Watch<'_> {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Block;

    #[derive(Serialize)]
    struct Example {
        value_m: f64,
        rate_per_s: f64,
        stopped: bool,
    }

    impl Report for Example {
        fn blocks(&self, name: &str) -> Vec<Block> {
            vec![Block::heading(name, "")]
        }

        fn is_interrupted(&self) -> bool {
            self.stopped
        }
    }

    /// The JSON of a command that writes two bytes, and its exit code.
    fn run(stopped: bool, failed: bool) -> (serde_json::Value, u8) {
        let folder = tempfile::tempdir().expect("temporary folder");
        let [json, csv] = ["a.json", "a.csv"].map(|name| folder.path().join(name));
        let args = OutputArgs {
            json: Some(json.clone()),
            ..OutputArgs::default()
        };
        let outputs = Outputs::new(None, &args).file("--csv", Kind::CSV, Some(csv));
        let files = outputs.and_then(Outputs::check).expect("writable");
        let example = Example {
            value_m: 0.1 + 0.2,
            rate_per_s: f64::NAN,
            stopped,
        };
        let stop = AtomicBool::new(false);
        let ended = files.finish(Watch::new(&stop), Some("made"), &example, |files| {
            files.write("--csv", |path| {
                fs::write(path, "x\n").map_err(CliError::during("writing"))
            })?;
            if failed {
                Err(CliError::Failed("full".to_owned()))
            } else {
                Ok(())
            }
        });
        let json = serde_json::from_slice(&fs::read(json).expect("written")).expect("JSON");
        (json, ended.map_or_else(|error| error.exit_code(), |()| 0))
    }

    #[test]
    fn a_document_has_the_result_version_scene_and_files() {
        let (json, code) = run(false, false);
        assert_eq!(code, 0);
        assert_eq!(json["version"], VERSION);
        assert_eq!(json["scene"], "made");
        assert_eq!(json["value_m"], 0.1 + 0.2);
        assert!(json["rate_per_s"].is_null());
        assert_eq!(json["files"][0]["bytes"], 2);
    }

    #[test]
    fn many_files_are_listed_by_directory() {
        let file = |path: String| WrittenFile {
            path: path.into(),
            bytes: 500,
        };
        let of = |recording: u32| (0..13).map(move |k| format!("figures/{recording}/{k}.png"));
        let figures: Vec<_> = (0..2).flat_map(of).map(file).collect();
        let words = ["  figures/0/ (13 files, ", "  figures/1/ (13 files, "];
        let text = list(&figures);
        assert_eq!(text.lines().count(), 2, "{text}");
        for (line, start) in text.lines().zip(words) {
            assert!(line.starts_with(start), "{text}");
        }
        assert_eq!(list(&figures[..13]).lines().count(), 13);
        let beside = (0..26).map(|k| file(format!("{k}.png")));
        assert_eq!(list(&Vec::from_iter(beside)).lines().count(), 26);
    }

    #[test]
    fn a_part_and_a_failed_file_are_still_reported() {
        for (stopped, failed, code) in [(true, false, 130), (false, true, 1)] {
            let (json, found) = run(stopped, failed);
            assert_eq!(found, code);
            assert_eq!(json["scene"], "made");
        }
    }
}
