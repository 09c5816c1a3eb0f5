//! How every command that has a result runs: check the outputs, work with progress until it is done or interrupted,
//! write the files, and print the report or the JSON.

use std::ffi::OsStr;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args as Arguments;
use indicatif::{ProgressBar, ProgressStyle};
use schemars::JsonSchema;
use serde::Serialize;

use super::console::{print, print_warning};
use super::error::CliError;
use super::figures::{FigureArgs, FigureStyle};
use super::output::{Kind, OutputError, Overwrite, is_stdout};
use super::{interrupt, resources};
use crate::export;
use crate::number::size;
use crate::plot::{Figure, Format};
use crate::report::{Report, terminal};
use crate::study::Stopped;
use crate::{VERSION, escape};

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

/// The outputs of a command, each with the option that names it.
pub(super) struct Outputs<'a> {
    input: Option<&'a OsStr>,
    overwrite: Overwrite,
    json: Option<&'a Path>,
    files: Vec<(&'static str, Kind, PathBuf)>,
    figures: Option<Figures<'a>>,
}

/// The option of figures.
const FIGURES: &str = "--figures";

/// Where and how figures are drawn.
struct Figures<'a> {
    path: &'a Path,
    drawn: FigureStyle,
    stems: Vec<String>,
}

impl Figures<'_> {
    /// The format, if the path is that of a file: a single figure can be written to one.
    fn single(&self) -> Option<Format> {
        Format::of(self.path).filter(|_| self.stems.len() == 1 && !self.path.is_dir())
    }
}

impl<'a> Outputs<'a> {
    /// The JSON document; no output may replace `input`, the name or path of a scene, or the path of a signal.
    pub fn new(input: Option<&'a OsStr>, args: &'a OutputArgs) -> Self {
        Self {
            input,
            overwrite: args.overwrite,
            json: args.json.as_deref(),
            files: Vec::new(),
            figures: None,
        }
    }

    /// Also replaces existing files if this holds: the outputs of a study that is resumed.
    pub fn resumed(self, resume: bool) -> Self {
        Self {
            overwrite: self.overwrite.or(resume),
            ..self
        }
    }

    /// A file, if it is requested.
    pub fn file(
        mut self,
        option: &'static str,
        kind: Kind,
        path: Option<impl Into<PathBuf>>,
    ) -> Self {
        let path = path.map(Into::into);
        self.files.extend(path.map(|path| (option, kind, path)));
        self
    }

    /// The figures of these stems, if they are requested.
    pub fn figures<S: Into<String>>(
        self,
        args: &'a FigureArgs,
        formats: &'static [Format],
        stems: impl IntoIterator<Item = S>,
    ) -> Self {
        let stems = stems.into_iter().map(Into::into).collect();
        let drawn = args.drawn.or_formats(formats);
        let figures = args
            .path
            .as_deref()
            .map(|path| Figures { path, drawn, stems });
        Self { figures, ..self }
    }

    /// Checks all outputs without changing a file.
    ///
    /// # Errors
    /// The first output that cannot be written, exists, is used twice, or is the input.
    pub fn check(mut self) -> Result<Files<'a>, CliError> {
        let is_recorded = self.files.iter().any(|(_, kind, _)| kind.is_recording());
        if let Some(json) = self.json.filter(|path| !is_stdout(path)) {
            self.files.push(("--json", Kind::JSON, json.to_owned()));
        }
        let figures = self.figures.as_ref();
        let (file, folder) = match figures {
            Some(figures) if figures.single().is_some() => (Some(figures), None),
            figures => (None, figures),
        };
        let file = file.map(|figures| (FIGURES, Kind::FIGURE, figures.path.to_owned()));
        self.files.extend(file);
        let files = self.overwrite.check_all(self.input, &self.files)?;
        if let Some(figures) = folder {
            let names = figures.drawn.names(&figures.stems);
            self.overwrite
                .check_directory(figures.path, FIGURES, &names)?;
            super::output::check_apart(figures.path, FIGURES, &files)?;
        }
        if is_recorded {
            resources::check_memory()?;
        }
        Ok(Files {
            printed: if self.json.is_some_and(is_stdout) {
                Printed::Json
            } else {
                Printed::Report
            },
            files,
            figures: self.figures,
            written: Vec::new(),
        })
    }
}

/// A written file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct WrittenFile {
    /// Path of the file.
    pub path: PathBuf,
    /// Size of the file, bytes.
    pub bytes: u64,
}

/// What is printed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Printed {
    Report,
    Json,
    Nothing,
}

/// Outputs that have passed their checks.
pub(super) struct Files<'a> {
    printed: Printed,
    files: Vec<(&'static str, PathBuf)>,
    figures: Option<Figures<'a>>,
    written: Vec<WrittenFile>,
}

impl Files<'_> {
    /// Does not print the report, if this holds: the command prints something else.
    pub fn without_report(self, replaced: bool) -> Self {
        let printed = if replaced {
            Printed::Nothing
        } else {
            self.printed
        };
        Self { printed, ..self }
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
        let file = fs::metadata(path).map_err(|source| export::OutputError {
            path: path.to_owned(),
            source,
        })?;
        self.written.push(WrittenFile {
            path: path.to_owned(),
            bytes: file.len(),
        });
        Ok(())
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
        let single = wanted.single();
        let paths = wanted
            .drawn
            .write(wanted.path, FIGURES, &figures(), single)?;
        paths.iter().try_for_each(|path| Ok(self.add(path)?))
    }

    /// Ends a command: clears the progress bar, writes the files of the result and delivers it. The report is printed even
    /// if a file cannot be written.
    ///
    /// # Errors
    /// Those of `write`, and [`CliError::Interrupted`] for a part of a result.
    pub fn finish<R: Report>(
        mut self,
        watch: Watch<'_>,
        scene: Option<&str>,
        result: &R,
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
    pub fn deliver<R: Report>(&self, scene: Option<&str>, result: &R) -> Result<(), CliError> {
        let document = Document {
            version: VERSION.to_owned(),
            scene: scene.map(str::to_owned),
            result,
            files: self.written.clone(),
        };
        if self.printed == Printed::Json {
            let json = serde_json::to_string_pretty(&document);
            let json = json.map_err(|fault| OutputError::Terminal(fault.into()))?;
            return Ok(print(&format!("{json}\n"))?);
        }
        let written = match self.path("--json") {
            Some(path) => export::replace_file(&path, |out| {
                serde_json::to_writer_pretty(&mut *out, &document)?;
                writeln!(out)
            }),
            None => Ok(()),
        };
        if self.printed == Printed::Report {
            let report = terminal(&result.blocks(scene.unwrap_or_default()));
            print(&format!("{report}{}", list(&self.written)))?;
        }
        Ok(written?)
    }
}

/// Files with their sizes, one per line.
fn list(files: &[WrittenFile]) -> String {
    let line = |file: &WrittenFile| {
        let path = escape::path(&file.path);
        format!("  {path} ({})\n", size(file.bytes))
    };
    files.iter().map(line).collect()
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

/// Prints a warning above the progress bar, from any thread.
pub(super) type Notifier = Arc<dyn Fn(&str) + Send + Sync>;

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
        self.check()
    }

    /// Returns a function that prints warnings above the progress bar.
    pub fn notifier(&self) -> Notifier {
        let bar = self.bar.clone();
        Arc::new(move |message| bar.suspend(|| print_warning(message)))
    }

    /// Checks for an interrupt.
    ///
    /// # Errors
    /// If the user has interrupted the work.
    pub fn check(&self) -> Result<(), Stopped> {
        interrupt::check(self.stop)
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
        let example = Example {
            value_m: 0.1 + 0.2,
            rate_per_s: f64::NAN,
            stopped,
        };
        let (stop, files) = (AtomicBool::new(false), outputs.check().expect("writable"));
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
    fn a_part_and_a_failed_file_are_still_reported() {
        for (stopped, failed, code) in [(true, false, 130), (false, true, 1)] {
            let (json, found) = run(stopped, failed);
            assert_eq!(found, code);
            assert_eq!(json["scene"], "made");
        }
    }
}
