//! Options and output of figures.

use std::fmt::Display;
use std::io::Write as _;
use std::path::Path;

use clap::Args as Arguments;

use super::document::WrittenFile;
use super::error::CliError;
use super::output::{OutputError, OutputFile};
use crate::plot::{Figure, FigureOptions, Format, Size, Style};

/// Most panels of a figure: the sensitivities of all modes.
const MOST_PANELS: u32 = 24;

/// Style, formats and size of figures.
#[derive(Clone, Debug, Default, Arguments)]
#[command(next_help_heading = "Figures")]
pub struct FigureArgs {
    /// Style of the figures. For slides each panel is a file of its own, such as bifurcation-1.png.
    #[arg(long, value_enum, default_value_t = Style::Screen)]
    pub style: Style,
    /// File formats, separated by commas [default: svg,png; for analyse and lyapunov: png].
    #[arg(long, value_enum, value_name = "FORMAT", value_delimiter = ',')]
    pub format: Vec<Format>,
    /// Width and height of each figure in mm, such as 180x120 [default: 254x143 for slides, else depends on the
    /// figure].
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
}

impl FigureArgs {
    /// The selected formats, or the defaults of the command.
    pub fn formats<'a>(&'a self, default: &'a [Format]) -> &'a [Format] {
        match &self.format[..] {
            [] => default,
            given => given,
        }
    }

    /// File names that figures with the given stems can have.
    pub fn names<S: Display>(
        &self,
        stems: impl IntoIterator<Item = S>,
        default: &[Format],
    ) -> Vec<String> {
        let panels = match self.style {
            Style::Slides => MOST_PANELS,
            Style::Paper | Style::Screen => 0,
        };
        let mut names = Vec::new();
        for stem in stems {
            for ending in self.formats(default).iter().map(|format| format.ending()) {
                names.push(format!("{stem}.{ending}"));
                names.extend((1..=panels).map(|number| format!("{stem}-{number}.{ending}")));
            }
        }
        names
    }

    /// The figures as they are written: for slides each panel is a figure of its own.
    pub fn arrange(&self, figures: &[Figure]) -> Vec<Figure> {
        match self.style {
            Style::Slides => figures.iter().flat_map(Figure::panels).collect(),
            Style::Paper | Style::Screen => figures.to_vec(),
        }
    }

    /// Refuses a size at which texts have no room.
    pub fn check(&self, figures: &[Figure]) -> Result<(), CliError> {
        match self.look().needed_size(figures) {
            Some(least) => Err(CliError::Input(format!(
                "--size is too small for all texts of the figures; give --size {least} or more"
            ))),
            None => Ok(()),
        }
    }

    /// Style and size for the plot module.
    pub fn look(&self) -> FigureOptions {
        FigureOptions {
            style: self.style,
            size: self.size,
        }
    }
}

/// Default formats of studies.
pub const STUDY: [Format; 2] = [Format::Svg, Format::Png];
/// Default formats of figures that consist of pixels.
pub const PIXELS: [Format; 1] = [Format::Png];

/// Writes the figures of a study to the directory `--figures`, if it is given, and adds the files to `written`.
pub fn draw(
    directory: Option<&Path>,
    figures: impl FnOnce() -> Vec<Figure>,
    drawn: (&FigureArgs, &[Format]),
    written: &mut Vec<WrittenFile>,
) -> Result<(), CliError> {
    if let Some(directory) = directory {
        written.extend(write_figures(directory, "--figures", &figures(), drawn)?);
    }
    Ok(())
}

/// Writes figures to a directory and creates it if needed. Messages name `option`.
pub fn write_figures(
    directory: &Path,
    option: &'static str,
    figures: &[Figure],
    (args, default): (&FigureArgs, &[Format]),
) -> Result<Vec<WrittenFile>, CliError> {
    let figures = args.arrange(figures);
    args.check(&figures)?;
    std::fs::create_dir_all(directory).map_err(|source| OutputError::NotWritable {
        path: directory.to_owned(),
        option,
        source,
    })?;
    let mut written = Vec::new();
    for figure in &figures {
        for format in args.formats(default) {
            let path = directory.join(format!("{}.{}", figure.name, format.ending()));
            let file = OutputFile::check(&path, option)?;
            written.push(write_figure(&file, figure, args, *format)?);
        }
    }
    Ok(written)
}

/// Writes a figure to a file.
pub fn write_figure(
    file: &OutputFile,
    figure: &Figure,
    args: &FigureArgs,
    format: Format,
) -> Result<WrittenFile, CliError> {
    let content = figure.file(&args.look(), format);
    let content = content.map_err(CliError::during("drawing"))?;
    file.write(|out| out.write_all(&content))?;
    Ok(WrittenFile::of(file)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::output::Overwrite;
    use crate::plot::{Axis, Panel};

    fn two_panels() -> Figure {
        let axis = |name| Axis::linear(name, [0.0, 1.0]);
        let panel = Panel::new("a panel", axis("time, ms"), axis("signal, µm"), Vec::new());
        Figure::new(
            "waveform",
            "Waveform",
            90.0,
            vec![vec![panel.clone()], vec![panel]],
        )
    }

    #[test]
    fn too_small_a_size_is_refused_with_one_that_suffices() {
        for style in [Style::Paper, Style::Screen, Style::Slides] {
            let folder = tempfile::tempdir().expect("temporary folder");
            let mut args = FigureArgs {
                style,
                size: Some("36x20".parse().expect("a size")),
                ..FigureArgs::default()
            };
            let write = |args: &FigureArgs| {
                write_figures(folder.path(), "--figures", &[two_panels()], (args, &PIXELS))
            };
            let refused = write(&args).expect_err("too small");
            assert_eq!(refused.exit_code(), 2);
            let message = refused.to_string();
            args.size = message.split(' ').find_map(|word| word.parse().ok());
            assert!(args.size.is_some(), "{message}");
            write(&args).expect("the named size suffices");
        }
    }

    #[test]
    fn panels_of_slides_are_files_that_are_not_replaced() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let args = FigureArgs {
            style: Style::Slides,
            ..FigureArgs::default()
        };
        let check = |overwrite: Overwrite| {
            let names = args.names(["waveform"], &PIXELS);
            overwrite.check_directory(folder.path(), "--figures", &names)
        };
        check(Overwrite::default()).expect("nothing is written yet");
        let drawn = (&args, &PIXELS[..]);
        write_figures(folder.path(), "--figures", &[two_panels()], drawn).expect("drawn");
        for name in ["waveform-1.png", "waveform-2.png"] {
            assert!(folder.path().join(name).exists(), "{name}");
        }
        check(Overwrite::default()).expect_err("exists");
        check(Overwrite::ALLOWED).expect("forced");
    }

    #[test]
    fn a_failure_while_drawing_has_exit_code_1() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let flat = [Figure::new("flat", "", 0.0, Vec::new())];
        let drawn = (&FigureArgs::default(), &PIXELS[..]);
        let error = write_figures(folder.path(), "--figures", &flat, drawn).expect_err("failed");
        assert_eq!(error.exit_code(), 1);
    }
}
