//! Figures on disk: how they are drawn, and where they go.

use std::fmt::Display;
use std::io::Write as _;
use std::path::Path;

use clap::Args as Arguments;

use super::document::WrittenFile;
use super::error::CliError;
use super::output::OutputFile;
use crate::plot::{Figure, Format, Look, Size, Style};

/// How figures are drawn.
#[derive(Clone, Debug, Default, Arguments)]
#[command(next_help_heading = "Figures")]
pub struct FigureArgs {
    /// Draw figures for this purpose.
    #[arg(long, value_enum, default_value_t = Style::Screen)]
    pub style: Style,
    /// File formats, separated by commas [default: svg,png; analyse and lyapunov: png].
    #[arg(long, value_enum, value_name = "FORMAT", value_delimiter = ',')]
    pub format: Vec<Format>,
    /// Width and height of each figure in mm, such as 180x120 [default: its own].
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
}

impl FigureArgs {
    /// The formats, or what a command draws unless told otherwise.
    pub fn formats<'a>(&'a self, default: &'a [Format]) -> &'a [Format] {
        match &self.format[..] {
            [] => default,
            given => given,
        }
    }

    /// Names of the files of figures, by their stems, of a command that draws some formats unless told
    /// otherwise.
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

    /// What figures look like.
    pub fn look(&self) -> Look {
        Look {
            style: self.style,
            size: self.size,
        }
    }
}

/// The formats of studies, unless told otherwise.
pub const STUDY: [Format; 2] = [Format::Svg, Format::Png];
/// The formats of what has only pixels, unless told otherwise.
pub const PIXELS: [Format; 1] = [Format::Png];

/// Writes figures into a directory, which is made if it is not there; `option` is that which named it.
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

/// Writes one figure as one file.
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

/// A fault while drawing.
pub fn drawing(source: super::error::Cause) -> CliError {
    CliError::Run {
        doing: "drawing",
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_while_drawing_is_no_bad_input() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let flat = [Figure::new("flat", "", 0.0, Vec::new())];
        let drawn = (&FigureArgs::default(), &PIXELS[..]);
        let error = write_figures(folder.path(), "--figures", &flat, drawn).expect_err("failed");
        assert_eq!(error.exit_code(), 1);
    }
}
