//! Sliding amplitude spectrum of the probe's velocity, with named lines.

use super::appearance::AppearanceClassifier;
use super::clock::samples;
use super::named_lines::{LINE_WINDOW, NamedLines, peak_magnitude};
use super::stage::Stage;
use super::windowed::{Windowed, velocity};
use crate::analysis::{sliding::SlidingWindow, tones::SpectrumAnalyser};
use crate::pipeline::message::Record;
use crate::scene::SpectrumSpec;

/// Emits [`Record::Spectrum`] of samples at `rate` (Hz).
///
/// Until the window is full, the spectrum uses the samples so far, from a quarter of the window on, with
/// wider bins. Lines below the velocity `rest` (m/s) are not reported.
pub fn spectrum(spec: &SpectrumSpec, rate: f64, rest: f64) -> impl Stage + use<> {
    let least = SpectrumAnalyser::MIN_SAMPLES;
    let length = samples(spec.window, rate, least);
    let sliding =
        SlidingWindow::new(length, spec.every * rate).with_min_length((length / 4).max(least));
    let mut analyser = SpectrumAnalyser::new(LINE_WINDOW, rate);
    let long = length as f64 > AppearanceClassifier::MEMORY * rate;
    let spectra = Windowed::new(sliding, velocity, move |window, context| {
        let [velocity] = window.channels;
        let spectrum = analyser.analyse(velocity)?;
        let named = NamedLines::following(&spectrum, context.bases);
        context.bases = named.naming.bases;
        context.floor = if long && velocity.len() == length {
            named.floor
        } else {
            1.0
        };
        // A vibration at rest has no lines.
        let peaks = if peak_magnitude(velocity) < rest {
            Vec::new()
        } else {
            named.peaks_above(rest)
        };
        Ok(Some(Record::Spectrum {
            time: window.time,
            bin: spectrum.bin,
            peaks,
            amplitude: spectrum.amplitude,
        }))
    });
    // Lessons and panels name the lines.
    spectra.complete()
}
