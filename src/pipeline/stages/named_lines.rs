//! The named lines of a spectrum.

use crate::analysis::{
    stats::range,
    tones::{
        Bases, FREQUENCY_UNCERTAINTY, Line, LineCriterion, LineIdentification, SpectralLine,
        Spectrum, Window, follow_lines,
    },
};

/// Window of all spectra from which lines are extracted: its side lobes are below -92 dB.
pub const LINE_WINDOW: Window = Window::BlackmanHarris;

/// Number of lines that are named, and numbers of those that are kept: the strongest, and the strongest of a doubling, which
/// are often weaker.
const NAMED: usize = 24;
const STRONGEST: usize = 12;
const DOUBLED: usize = 2;

/// Lines of a spectrum with their names.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedLines {
    /// Lines, strongest first.
    pub lines: Vec<Line>,
    /// Their names and the base frequencies.
    pub naming: LineIdentification,
    /// Broadband share of the power, see [`Spectrum::broadband_share`].
    pub floor: f64,
}

impl NamedLines {
    /// Extracts and names the lines of a spectrum. The names of an earlier spectrum with the bases `previous` are kept as
    /// far as possible.
    pub fn following(spectrum: &Spectrum, previous: Bases) -> Self {
        let mut lines = spectrum.lines(&LineCriterion {
            max_lines: NAMED,
            ..LineCriterion::default()
        });
        let mut naming = follow_lines(&lines, FREQUENCY_UNCERTAINTY * spectrum.bin, previous);
        let is_doubled = |k: &usize| naming.names[*k].is_some_and(|name| name.divisor > 1);
        let weaker = (STRONGEST..lines.len()).filter(is_doubled).take(DOUBLED);
        let kept: Vec<usize> = (0..lines.len().min(STRONGEST)).chain(weaker).collect();
        naming.names = kept.iter().map(|k| naming.names[*k]).collect();
        lines = kept.iter().map(|k| lines[*k]).collect();
        Self {
            naming,
            floor: spectrum.broadband_share(),
            lines,
        }
    }

    /// Amplitude ratio of the strongest line that involves the second base frequency to the strongest line; 0
    /// if there is none.
    pub fn second_tone(&self) -> f64 {
        let named = self.lines.iter().zip(&self.naming.names);
        let mut second = named.filter(|(_, name)| name.is_some_and(|name| name.m != 0));
        let line = second.next().map(|(line, _)| line);
        line.map_or(0.0, |line| line.amplitude / self.lines[0].amplitude)
    }

    /// The lines with their names, for a record.
    pub fn peaks(&self) -> Vec<SpectralLine> {
        self.naming.label(&self.lines)
    }

    /// The lines with an amplitude of at least `rest`, for a record.
    pub fn peaks_above(&self, rest: f64) -> Vec<SpectralLine> {
        let mut peaks = self.peaks();
        peaks.retain(|line| line.amplitude >= rest);
        peaks
    }
}

/// The largest magnitude of a slice.
pub fn peak_magnitude(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| x.abs().max(m))
}

/// Half the peak-to-peak value of a slice; 0 if it is empty.
pub fn half_range(x: &[f64]) -> f64 {
    let [low, high] = range(x.iter().copied());
    if high > low { 0.5 * (high - low) } else { 0.0 }
}
