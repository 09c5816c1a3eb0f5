//! Options and output of figures.

use std::fmt::Display;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::slice::from_ref;

use clap::Args as Arguments;

use super::error::CliError;
use super::output::{check_file, not_writable};
use crate::export::replace_file;
use crate::plot::{Figure, FigureOptions, Format, Style, parse_size};

/// Most panels of a figure: the sensitivities of all modes.
const MOST_PANELS: u32 = 24;

/// The figures of a command.
#[derive(Clone, Debug, Default, Arguments)]
#[command(next_help_heading = "Figures")]
pub struct FigureArgs {
    /// Draw the figures to this directory, or a single one to a .png, .svg or .pdf file.
    #[arg(id = "figures", long = "figures", value_name = "DIR|FILE")]
    pub path: Option<PathBuf>,
    #[command(flatten)]
    pub drawn: FigureStyle,
}

/// Style, formats and size of figures.
#[derive(Clone, Debug, Default, Arguments)]
#[command(next_help_heading = "Figures")]
pub struct FigureStyle {
    /// Style of the figures. For slides each panel is a file of its own, such as bifurcation-1.png.
    #[arg(long, value_enum, default_value_t = Style::Screen)]
    pub style: Style,
    /// File formats, separated by commas [default: svg,png; for run, analyse and lyapunov: png].
    #[arg(long, value_enum, value_name = "FORMAT", value_delimiter = ',')]
    pub format: Vec<Format>,
    /// Width and height of each figure in mm, such as 180x120 [default: 254x143 for slides, else depends on the
    /// figure].
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[f64; 2]>,
}

/// Default formats of studies.
pub const STUDY: &[Format] = &[Format::Svg, Format::Png];
/// Default formats of figures that consist of pixels.
pub const PIXELS: &[Format] = &[Format::Png];

impl FigureStyle {
    /// The style with these formats if none is selected.
    pub fn or_formats(&self, formats: &[Format]) -> Self {
        let mut style = self.clone();
        if style.format.is_empty() {
            style.format = formats.to_vec();
        }
        style
    }

    /// File names that figures with the given stems can have.
    pub fn names(&self, stems: &[impl Display]) -> Vec<String> {
        let panels = match self.style {
            Style::Slides => MOST_PANELS,
            Style::Paper | Style::Screen => 0,
        };
        let mut names = Vec::new();
        for stem in stems {
            for ending in self.format.iter().map(|format| format.ending()) {
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

    /// Writes figures to a directory, which is created if needed, or a single one to a file of this format. Returns the
    /// paths; messages name `option`.
    ///
    /// # Errors
    /// A size at which texts have no room; failure while drawing or writing.
    pub fn write(
        &self,
        path: &Path,
        option: &str,
        figures: &[Figure],
        single: Option<Format>,
    ) -> Result<Vec<PathBuf>, CliError> {
        let options = FigureOptions {
            style: self.style,
            size: self.size,
        };
        let figures = match single {
            Some(_) => figures.to_vec(),
            None => self.arrange(figures),
        };
        if let Some([width, height]) = options.needed_size(&figures) {
            return Err(CliError::Input(format!(
                "--size is too small for all texts of the figures; give --size {width}x{height} or more"
            )));
        }
        if single.is_none() {
            std::fs::create_dir_all(path).map_err(not_writable(path, option))?;
        }
        let mut written = Vec::new();
        for figure in &figures {
            for &format in single.as_ref().map_or(&self.format[..], from_ref) {
                let path = match single {
                    Some(_) => path.to_owned(),
                    None => path.join(format!("{}.{}", figure.name, format.ending())),
                };
                let path = check_file(&path, option)?;
                let content = figure.file(&options, format);
                let content = content.map_err(CliError::during("drawing"))?;
                replace_file(&path, |out| out.write_all(&content))?;
                written.push(path);
            }
        }
        Ok(written)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::output::check_directory;
    use crate::plot::{Axis, Panel};

    fn drawn(style: &FigureStyle) -> FigureStyle {
        style.or_formats(PIXELS)
    }

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
            let mut args = FigureStyle {
                style,
                size: Some(parse_size("36x20").expect("a size")),
                ..FigureStyle::default()
            };
            let write = |style: &FigureStyle| {
                drawn(style).write(folder.path(), "--figures", &[two_panels()], None)
            };
            let refused = write(&args).expect_err("too small");
            assert_eq!(refused.exit_code(), 2);
            let message = refused.to_string();
            args.size = message.split(' ').find_map(|word| parse_size(word).ok());
            assert!(args.size.is_some(), "{message}");
            write(&args).expect("the named size suffices");
        }
    }

    #[test]
    fn panels_of_slides_are_files_that_are_not_replaced() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let args = FigureStyle {
            style: Style::Slides,
            ..FigureStyle::default()
        };
        let check = |force| {
            let names = drawn(&args).names(&["waveform"]);
            check_directory(folder.path(), "--figures", &names, force)
        };
        check(false).expect("nothing is written yet");
        let figures = [two_panels()];
        let written = drawn(&args).write(folder.path(), "--figures", &figures, None);
        written.expect("drawn");
        for name in ["waveform-1.png", "waveform-2.png"] {
            assert!(folder.path().join(name).exists(), "{name}");
        }
        check(false).expect_err("exists");
        check(true).expect("forced");
    }

    #[test]
    fn a_failure_while_drawing_has_exit_code_1() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let flat = [Figure::new("flat", "", 0.0, Vec::new())];
        let style = FigureStyle::default();
        let written = drawn(&style).write(folder.path(), "--figures", &flat, None);
        let error = written.expect_err("failed");
        assert_eq!(error.exit_code(), 1);
    }
}
