//! Periodic modulation of the amplitude and of the frequency of an event.

use std::f64::consts::LN_2;

use realfft::RealFftPlanner;

use super::baseband::LOW_PASS_S;
use super::partial::{Partial, STEP_S};
use super::spectrogram::{LOBE, vertex};
use super::{Modulation, Vibrato};
use crate::stats::{mean, median, trend};
use crate::tones::Window;

/// Lowest frequency of a modulation, Hz.
const LOWEST_HZ: f64 = 2.0;

/// Probability that noise has a line.
const FALSE_ALARM: f64 = 0.01;

/// Smallest depth that is reported.
const LEAST_DEPTH: f64 = 0.05;

/// Smallest relative deviation of frequency that is reported.
const LEAST_DEVIATION: f64 = 2e-4;

/// Least ratio to the mean power of noise of a line among `bins`.
pub(super) fn least_ratio(bins: usize) -> f64 {
    (bins as f64 / FALSE_ALARM).ln()
}

/// Modulation of the amplitude of a partial.
pub(super) fn modulation(partial: &Partial) -> Option<Modulation> {
    let (modulation_hz, amplitude) = strongest(&partial.amplitudes, LOW_PASS_S[1])?;
    let modulation_depth = amplitude / mean(&partial.amplitudes);
    (modulation_depth > LEAST_DEPTH).then_some(Modulation {
        modulation_hz,
        modulation_depth,
    })
}

/// Modulation of the frequency of a partial, `multiple` times the fundamental.
pub(super) fn vibrato(partial: &Partial, multiple: usize) -> Option<Vibrato> {
    let frequencies: Vec<f64> = partial.track.iter().map(|p| p.0).collect();
    let (vibrato_hz, deviation) = strongest(&frequencies, LOW_PASS_S[0])?;
    (deviation > LEAST_DEVIATION * partial.frequency_hz).then_some(Vibrato {
        vibrato_hz,
        vibrato_deviation_hz: deviation / multiple as f64,
    })
}

/// Frequency (Hz) and amplitude of the strongest line of a function of time in steps of [`STEP_S`], without
/// its trend, that passed a low-pass, if it stands out and ends are not its cause.
fn strongest(values: &[f64], low_pass_s: f64) -> Option<(f64, f64)> {
    let count = values.len();
    let duration = count as f64 * STEP_S;
    if count < 32 {
        return None;
    }
    let fft = RealFftPlanner::new().plan_fft_forward(count);
    let weights = Window::Hann.samples(count);
    let (mean, [slope, _]) = (mean(values), trend(values));
    let middle = 0.5 * (count as f64 - 1.0);
    let line = |i: usize| mean + slope * (i as f64 - middle);
    let mut input: Vec<f64> = (0..count)
        .map(|i| (values[i] - line(i)) * weights[i])
        .collect();
    let mut output = fft.make_output_vec();
    fft.process(&mut input, &mut output).ok()?;
    let powers: Vec<f64> = output.iter().map(|x| x.norm_sqr()).collect();
    // Beyond the main lobe of the level.
    let first = ((LOWEST_HZ * duration).ceil() as usize).max(LOBE);
    let last = (duration / low_pass_s) as usize;
    let best = (first..last).max_by(|a, b| powers[*a].total_cmp(&powers[*b]))?;
    let noise = median(powers[first..last].iter().copied()) / LN_2;
    let is_peak = powers[best] >= powers[best - 1] && powers[best] >= powers[best + 1];
    if !is_peak || powers[best] < least_ratio(last - first) * noise {
        return None;
    }
    let (shift, height) = vertex([powers[best - 1], powers[best], powers[best + 1]]);
    Some((
        (best as f64 + shift) / duration,
        2.0 * height.sqrt() / weights.iter().sum::<f64>(),
    ))
}
