//! Options and output of figures.

use std::fmt::Display;
use std::io::Write as _;
use std::path::Path;

use clap::Args as Arguments;

use super::document::WrittenFile;
use super::error::CliError;
use super::output::OutputFile;
use crate::plot::{Figure, FigureOptions, Format, Size, Style};

/// Style, formats and size of figures.
#[derive(Clone, Debug, Default, Arguments)]
#[command(next_help_heading = "Figures")]
pub struct FigureArgs {
    /// Style of the figures.
    #[arg(long, value_enum, default_value_t = Style::Screen)]
    pub style: Style,
    /// File formats, separated by commas [default: svg,png; for analyse and lyapunov: png].
    #[arg(long, value_enum, value_name = "FORMAT", value_delimiter = ',')]
    pub format: Vec<Format>,
    /// Width and height of each figure in mm, such as 180x120 [default: depends on the figure].
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

    /// File names of figures with the given stems.
    pub fn names<S: Display>(
        &self,
        stems: impl IntoIterator<Item = S>,
        default: &[Format],
    ) -> Vec<String> {
        let name = |stem: &S, format: &Format| format!("{stem}.{}", format.ending());
        let names = |stem| {
            self.formats(default)
                .iter()
                .map(move |format| name(&stem, format))
        };
        stems.into_iter().flat_map(names).collect()
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

/// Writes figures to a directory and creates it if needed. Messages name `option`.
pub fn write_figures(
    directory: &Path,
    option: &'static str,
    figures: &[Figure],
    (args, default): (&FigureArgs, &[Format]),
) -> Result<Vec<WrittenFile>, CliError> {
    std::fs::create_dir_all(directory).map_err(|source| drawing(source.into()))?;
    let mut written = Vec::new();
    for figure in figures {
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
    let content = content.map_err(|error| drawing(error.into()))?;
    file.write(|out| out.write_all(&content))?;
    Ok(WrittenFile::of(file)?)
}

/// A failure while drawing.
pub fn drawing(source: super::error::Cause) -> CliError {
    CliError::Run {
        task: "drawing",
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_while_drawing_has_exit_code_1() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let flat = [Figure::new("flat", "", 0.0, Vec::new())];
        let drawn = (&FigureArgs::default(), &PIXELS[..]);
        let error = write_figures(folder.path(), "--figures", &flat, drawn).expect_err("failed");
        assert_eq!(error.exit_code(), 1);
    }
}
