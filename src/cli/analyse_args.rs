//! Arguments of `squeakscope analyse`.

use std::num::NonZero;
use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args as Arguments, value_parser};
use strum::VariantArray;

use super::figures::FigureArgs;
use super::harness::OutputArgs;
use crate::analysis::recurrence::{Norm, Threshold};
use crate::import::MAX_SAMPLES;
use crate::study::signal::CalibrationSource;

/// Arguments of `squeakscope analyse`.
#[derive(Debug, Default, Arguments)]
#[command(next_help_heading = "Input")]
pub struct AnalyseArgs {
    /// Signal files: WAV, FLAC, MP3, AAC, M4A, MP4, Ogg, Opus, AIFF, CSV or other text columns, .uff, .npy, .npz, .mat, or
    /// recordings (.rrd); a directory stands for the signal files in it.
    #[arg(value_name = "FILE", required = true, help_heading = None::<&str>)]
    pub files: Vec<PathBuf>,
    /// Column or channel, by name or by index from 0 (the time column does not count) [default: the only
    /// one].
    #[arg(long, value_name = "NAME")]
    pub column: Option<String>,
    /// Analyse each column or channel, as a file of its own.
    #[arg(long, conflicts_with = "column")]
    pub each_channel: bool,
    /// Sampling rate, if the file does not state it or states a wrong one.
    #[arg(long, value_name = "HZ")]
    pub rate: Option<f64>,
    /// Skip this many lines at the start of a text file.
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub skip_lines: u64,
    /// Skip samples before this time.
    #[arg(long, value_name = "SECONDS")]
    pub from: Option<f64>,
    /// Skip samples at and after this time.
    #[arg(long, value_name = "SECONDS")]
    pub to: Option<f64>,
    /// Refuse a selection of more samples than this; each sample takes 8 bytes of memory.
    #[arg(long, value_name = "N", default_value_t = MAX_SAMPLES, value_parser = max_samples)]
    pub max_samples: usize,
    /// Analyse the motion within this tonal event, by its number in the table of events [default: the event
    /// with the largest energy].
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..),
        help_heading = "Analysis")]
    pub event: Option<u32>,
    /// List faint events, more than 40 dB below the recording, too.
    #[arg(long, help_heading = "Analysis")]
    pub faint: bool,
    /// Convert the signal to Pa; all levels are in dB re 20 uPa, also A-weighted and in third octaves. The calibration is the
    /// level of a calibrator and its recording (94dB=FILE), the pressure for one unit of the signal (12.5Pa), or the sensitivity of the microphone
    /// for a signal in V (50mV/Pa).
    #[arg(long, value_name = "CALIBRATION", help_heading = "Analysis")]
    pub calibration: Option<CalibrationSource>,
    /// Embedding delay [default: the first minimum of the mutual information].
    #[arg(long, value_name = "SAMPLES", value_parser = value_parser!(u32).range(1..),
        help_heading = "Analysis")]
    pub lag: Option<u32>,
    /// Embedding dimension [default: chosen by false nearest neighbours].
    #[arg(long, value_name = "M", value_parser = value_parser!(u32).range(1..),
        help_heading = "Analysis")]
    pub dimension: Option<u32>,
    /// Recurrence threshold: rate:R (recurrence rate), distance:D (unit of the signal), spread:S (standard
    /// deviations) or neighbours:N (fixed number of nearest neighbours) [default: rate:0.05].
    #[arg(long, value_name = "KIND:VALUE", value_parser = threshold, help_heading = "Analysis")]
    pub threshold: Option<Threshold>,
    /// Norm of the distance of two states in recurrence analysis [default: euclidean].
    #[arg(long, value_name = "NORM", value_parser = norms(), help_heading = "Analysis")]
    pub norm: Option<Norm>,
    /// Theiler window of recurrence analysis: pairs of states that are closer in time do not count [default: the
    /// delay].
    #[arg(long, value_name = "SAMPLES", value_parser = value_parser!(u32).range(1..), help_heading = "Analysis")]
    pub theiler: Option<u32>,
    /// Shortest diagonal line of recurrence quantification [default: 2].
    #[arg(long, value_name = "STATES", value_parser = value_parser!(u32).range(1..), help_heading = "Analysis")]
    pub min_diagonal: Option<u32>,
    /// Shortest vertical line of recurrence quantification [default: 2].
    #[arg(long, value_name = "STATES", value_parser = value_parser!(u32).range(1..), help_heading = "Analysis")]
    pub min_vertical: Option<u32>,
    /// Count the line of identity, as recurrent points and as a diagonal line: no Theiler window.
    #[arg(long, conflicts_with = "theiler", help_heading = "Analysis")]
    pub line_of_identity: bool,
    /// Compare the tonal events with labels of Audacity, and count those found, false and missed: the labels of the file, or
    /// a directory with the labels NAME.txt of each file NAME.
    #[arg(long, value_name = "FILE.txt|DIR", help_heading = "Analysis")]
    pub truth: Option<PathBuf>,
    /// Analyse this many files at once, if there are several [default: 1; each takes the memory of its samples].
    #[arg(long, value_name = "N", help_heading = "Execution")]
    pub jobs: Option<NonZero<usize>>,
    /// Write the tones as labels for Audacity; of several files, a file for each in this directory.
    #[arg(long, value_name = "FILE.txt|DIR", help_heading = "Output")]
    pub labels: Option<PathBuf>,
    /// Write the tonal events of all files as one table.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub events: Option<PathBuf>,
    /// Save a recording of the signal with each analysis over time.
    #[arg(long, value_name = "FILE.rrd", help_heading = "Output")]
    pub save: Option<PathBuf>,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub figures: FigureArgs,
}

/// Parses a norm by its name.
fn norms() -> impl TypedValueParser<Value = Norm> {
    let names = Norm::VARIANTS.iter().map(<&str>::from);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Norm>())
}

/// Parses a number of samples, such as 100000000 or 1e8.
fn max_samples(text: &str) -> Result<usize, String> {
    let number = text.parse::<f64>().ok();
    let whole = number.filter(|n| *n >= 1.0 && *n <= 1e15 && n.fract() == 0.0);
    whole
        .map(|n| n as usize)
        .ok_or_else(|| "give a whole number from 1 to 1e15".to_owned())
}

/// Parses a recurrence threshold and checks its range.
fn threshold(text: &str) -> Result<Threshold, String> {
    let (kind, value) = text.split_once(':').unwrap_or(("rate", text));
    let number = || {
        value
            .parse::<f64>()
            .ok()
            .filter(|v| v.is_finite() && *v > 0.0)
    };
    let threshold = match kind {
        "rate" => number().filter(|rate| *rate <= 1.0).map(Threshold::Rate),
        "distance" => number().map(Threshold::Distance),
        "spread" => number().map(Threshold::Spread),
        "neighbours" => {
            let count = value.parse().ok().filter(|count| *count > 0);
            count.map(Threshold::Neighbours)
        }
        _ => None,
    };
    threshold.ok_or_else(|| {
        "give rate:R (R at most 1), distance:D, spread:S or neighbours:N, each above 0".to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_parsed_by_kind() {
        assert_eq!(threshold("0.1"), Ok(Threshold::Rate(0.1)));
        assert_eq!(threshold("distance:2e-3"), Ok(Threshold::Distance(2e-3)));
        assert_eq!(threshold("spread:0.2"), Ok(Threshold::Spread(0.2)));
        assert_eq!(threshold("neighbours:10"), Ok(Threshold::Neighbours(10)));
        for text in [
            "",
            "rate:1.1",
            "rate:0",
            "spread:nan",
            "neighbours:0.5",
            "near:1",
            "distance:-1",
        ] {
            assert!(threshold(text).is_err(), "{text}");
        }
    }
}
