//! The lines of a spectrum, read.

use crate::analysis::{
    FREQUENCY_UNCERTAINTY, Line, LineCriterion, Naming, SpectralLine, Spectrum, Window, name_lines,
    range,
};

/// The window of all spectra whose lines are read: its side lobes hide nothing above -92 dB.
pub const LINE_WINDOW: Window = Window::BlackmanHarris;

/// A spectrum's lines and their names.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// The lines, the strongest first.
    pub lines: Vec<Line>,
    /// Their names, and the base frequencies.
    pub naming: Naming,
    /// See [`Spectrum::floor_share`].
    pub floor: f64,
}

impl Reading {
    /// Of a spectrum.
    pub fn of(spectrum: &Spectrum) -> Self {
        let lines = spectrum.lines(&LineCriterion::default());
        Self {
            naming: name_lines(&lines, FREQUENCY_UNCERTAINTY * spectrum.bin),
            floor: spectrum.floor_share(),
            lines,
        }
    }

    /// Amplitude of the strongest line that the second base takes part in, over that of the
    /// strongest line; 0 if there is none.
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
