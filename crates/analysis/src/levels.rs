//! Sound levels of a calibrated signal: equivalent continuous level, A-weighting, third octaves.
//!
//! All filters act on the spectrum of the whole signal, so that they have the magnitude of their analogue design at every
//! frequency below half the sample rate, and no phase. The signal counts as one period of a periodic one. If it
//! is long, silence of less than 1 % of its length may follow it, because a transform of its own length can be slow.

use schemars::JsonSchema;
use serde::Serialize;

use crate::memory;
use crate::{
    AnalysisError,
    filter::{band_pass, with_gain},
    stats::deviation,
    tones::{LineCriterion, SpectrumAnalyser, Window},
};

/// Reference of sound pressure levels, Pa.
pub const REFERENCE_PRESSURE: f64 = 20e-6;

/// What the levels of a signal are relative to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema, strum::Display)]
#[serde(rename_all = "kebab-case")]
pub enum LevelReference {
    /// A sine of the amplitude 1, full scale.
    #[default]
    #[strum(to_string = "dB FS")]
    FullScale,
    /// A sine whose amplitude is the largest magnitude of the samples.
    #[strum(to_string = "dB re largest sample")]
    LargestSample,
    /// 20 uPa RMS.
    #[strum(to_string = "dB re 20 uPa")]
    SoundPressure,
}

impl LevelReference {
    /// Unit of signals whose levels are relative to 20 uPa.
    pub const PASCAL: &str = "Pa";

    /// The reference for a signal with a unit: its full scale, 1, if the unit is `FS` and no sample is larger than lossy
    /// coding makes it, or if there is no unit and no sample is larger than 1.
    pub fn of(unit: &str, largest: f64) -> Self {
        match unit {
            Self::PASCAL => Self::SoundPressure,
            // Files of floats may hold other quantities.
            "FS" if largest <= OVERSHOOT => Self::FullScale,
            // Arrays without a unit usually hold the samples of a sound file as they are.
            "" if largest <= 1.0 => Self::FullScale,
            _ => Self::LargestSample,
        }
    }

    /// Amplitude of a sine of 0 dB, in the unit of the signal.
    pub fn amplitude(self, largest: f64) -> f64 {
        match self {
            Self::FullScale => 1.0,
            Self::LargestSample => largest,
            Self::SoundPressure => std::f64::consts::SQRT_2 * REFERENCE_PRESSURE,
        }
    }
}

/// Largest sample of a sound that lossy coding has taken beyond its full scale, 1.
const OVERSHOOT: f64 = 2.0;

/// Time constant of the time weighting F (IEC 61672-1), s.
const FAST: f64 = 0.125;

/// Number of bins that a third octave must have.
const MIN_BINS: f64 = 4.0;

/// Numbers of the third octaves, from 20 Hz to 20 kHz: `n` has the centre `1000 * 10^(n/10)` Hz.
const BANDS: std::ops::RangeInclusive<i32> = -17..=13;

/// Nominal centres of the third octaves, as they are named, Hz.
const NOMINAL: [f64; 31] = [
    20.0, 25.0, 31.5, 40.0, 50.0, 63.0, 80.0, 100.0, 125.0, 160.0, 200.0, 250.0, 315.0, 400.0,
    500.0, 630.0, 800.0, 1000.0, 1250.0, 1600.0, 2000.0, 2500.0, 3150.0, 4000.0, 5000.0, 6300.0,
    8000.0, 10_000.0, 12_500.0, 16_000.0, 20_000.0,
];

/// Sound levels of a calibrated signal, dB re 20 uPa.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SoundLevels {
    /// Equivalent continuous level, without frequency weighting, in dB.
    pub equivalent_level_db: f64,
    /// A-weighted equivalent continuous level, in dB.
    pub a_weighted_level_db: f64,
    /// Maximum of the A-weighted level with time weighting F (fast), in dB.
    pub fast_maximum_db: f64,
    /// Peak level: of the largest magnitude of the pressure, without frequency weighting, in dB.
    pub peak_level_db: f64,
    /// Third octaves below half the sample rate that the duration resolves.
    pub third_octaves: Vec<ThirdOctave>,
}

/// Level of a third octave.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ThirdOctave {
    /// Nominal centre of the band, Hz.
    pub centre_hz: f64,
    /// Equivalent continuous level in the band, in dB.
    pub band_level_db: f64,
    /// Standard deviation of the level if the sound in the band is random noise, in dB: `4.34 / sqrt(B T)` with the
    /// bandwidth `B` and the duration `T`.
    pub standard_deviation_db: f64,
}

/// Frequency weighting A of IEC 61672-1 (2013), Eq. (E.6): the gain relative to 1 kHz at a frequency (Hz).
pub fn a_weighting(frequency: f64) -> f64 {
    /// Poles, Hz.
    const POLES: [f64; 4] = [20.598_997, 107.652_65, 737.862_23, 12_194.217];
    let response = |frequency: f64| {
        let square = frequency * frequency;
        let pole = |k: usize| square + POLES[k] * POLES[k];
        POLES[3].powi(2) * square * square / (pole(0) * (pole(1) * pole(2)).sqrt() * pole(3))
    };
    response(frequency) / response(1000.0)
}

/// Width of a third octave by its centre: the difference of the edges, `10^0.05 - 10^-0.05`.
const RELATIVE_WIDTH: f64 = 0.230_767_516_168_217_7;

/// Squared gain of a third octave at a frequency: a Butterworth band-pass of order 6, which is in class 1 of IEC 61260.
/// The squares of its centre and of the frequency are given.
fn band_gain(centre_square: f64, square: f64) -> f64 {
    let relative = square / centre_square;
    // Square of the detuning (f/c - c/f) / w.
    let detuning = (relative - 2.0 + 1.0 / relative) / (RELATIVE_WIDTH * RELATIVE_WIDTH);
    1.0 / (1.0 + detuning * detuning * detuning)
}

/// Exact centre of a third octave, Hz.
fn centre(number: i32) -> f64 {
    1000.0 * 10_f64.powf(0.1 * f64::from(number))
}

/// Level of a mean square of the pressure (Pa^2), dB.
fn level(mean_square: f64) -> f64 {
    10.0 * (mean_square / REFERENCE_PRESSURE.powi(2)).log10()
}

/// Levels of the sound pressure (Pa) at a sample rate (Hz). The mean does not count.
///
/// # Errors
/// [`AnalysisError::TooShort`] without samples, [`AnalysisError::Memory`] if their spectrum does not fit into memory.
pub fn sound_levels(pressure: &[f64], rate: f64) -> Result<SoundLevels, AnalysisError> {
    let count = pressure.len();
    AnalysisError::check_length("sound levels", count, 1)?;
    levels_by_transform(pressure, rate, quick_length(count))
}

/// Levels of samples, followed by silence up to the length of the transform.
fn levels_by_transform(
    pressure: &[f64],
    rate: f64,
    length: usize,
) -> Result<SoundLevels, AnalysisError> {
    let count = pressure.len();
    // Samples, spectrum and scratch.
    let bytes = 4 * (length * size_of::<f64>()) as u64;
    memory::check(bytes).map_err(|shortage| AnalysisError::Memory {
        samples: count,
        shortage,
    })?;
    let mean = pressure.iter().sum::<f64>() / count as f64;
    let mut time: Vec<f64> = Vec::with_capacity(length);
    time.extend(pressure.iter().map(|pressure| pressure - mean));
    let peak = time.iter().fold(0.0, |peak: f64, p| peak.max(p.abs()));
    time.resize(length, 0.0);
    let spacing = rate / length as f64;
    let resolution = rate / count as f64;
    let bands = BANDS
        .zip(NOMINAL)
        .map(|(number, nominal)| (nominal, centre(number)));
    let resolved = bands.filter(|(_, centre)| {
        let upper_edge = centre * 10_f64.powf(0.05);
        centre * RELATIVE_WIDTH >= MIN_BINS * resolution && upper_edge <= 0.5 * rate
    });
    let mut bands: Vec<(f64, f64, f64)> = resolved
        .map(|(nominal, centre)| (nominal, centre, 0.0))
        .collect();
    // Sums of squares of all bins. Each bin stands for a sine, except those at zero and at half the rate. The bins become
    // A-weighted.
    let (mut sum, mut weighted_sum) = (0.0, 0.0);
    let weighted = with_gain(time, |k, square| {
        let sides = if k == 0 || 2 * k == length { 1.0 } else { 2.0 };
        let power = sides * square;
        let frequency = k as f64 * spacing;
        for (_, centre, sum) in &mut bands {
            *sum += power * band_gain(centre.powi(2), frequency * frequency);
        }
        let weight = a_weighting(frequency);
        sum += power;
        weighted_sum += power * weight * weight;
        weight
    });
    let level_of = |sum: f64| level(sum / (length as f64 * count as f64));
    let third_octaves = bands
        .into_iter()
        .map(|(centre_hz, centre, sum)| ThirdOctave {
            centre_hz,
            band_level_db: level_of(sum),
            standard_deviation_db: 4.34 / (centre * RELATIVE_WIDTH / resolution).sqrt(),
        });
    Ok(SoundLevels {
        third_octaves: third_octaves.collect(),
        equivalent_level_db: level_of(sum),
        a_weighted_level_db: level_of(weighted_sum),
        fast_maximum_db: level(fast_maximum(&weighted[..count], rate)),
        peak_level_db: level(peak * peak),
    })
}

/// Longest signal whose transform is quick for any length.
const SHORT: usize = 1 << 20;

/// The smallest length from `count` whose transform is quick: a product of 2, 3, 5 and 7.
fn quick_length(count: usize) -> usize {
    if count <= SHORT {
        return count;
    }
    let is_quick = |length: &usize| {
        let rest = [2, 3, 5, 7].iter().fold(*length, |mut rest, factor| {
            while rest.is_multiple_of(*factor) {
                rest /= factor;
            }
            rest
        });
        rest == 1
    };
    (count..).find(is_quick).expect("a power of two")
}

/// Maximum of the mean square with an exponential time weighting.
fn fast_maximum(samples: &[f64], rate: f64) -> f64 {
    let keep = (-1.0 / (FAST * rate)).exp();
    let (mut mean, mut maximum) = (0.0, 0.0_f64);
    for sample in samples {
        mean = keep * mean + (1.0 - keep) * sample * sample;
        maximum = maximum.max(mean);
    }
    maximum
}

/// Calibration: how the unit of a signal becomes a pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Calibration {
    /// Sensitivity: pressure in Pa for one unit of the signal.
    pub sensitivity_pa: f64,
    /// The tone of the calibrator; `None` if the sensitivity was given.
    pub calibrator: Option<CalibratorTone>,
}

impl Calibration {
    /// That of a signal in Pa.
    pub const PASCAL: Self = Self {
        sensitivity_pa: 1.0,
        calibrator: None,
    };
}

/// The tone of a calibrator in its recording.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CalibratorTone {
    /// Stated level of the tone, in dB.
    pub stated_level_db: f64,
    /// Frequency of the tone, Hz.
    pub tone_hz: f64,
    /// Standard deviation of the level between intervals of 0.25 s, in dB.
    pub level_deviation_db: f64,
}

/// Length of the intervals whose levels are compared, s.
const INTERVAL: f64 = 0.25;

/// The calibration from the recording of a calibrator, whose tone has the stated level (dB): the third octave around the
/// strongest line. `None` without a line, and of less than 0.5 s.
pub fn calibrate(samples: &[f64], rate: f64, stated: f64) -> Option<Calibration> {
    let spectrum = SpectrumAnalyser::new(Window::BlackmanHarris, rate)
        .analyse(samples)
        .ok()?;
    let tone = spectrum.lines(&LineCriterion::default()).first()?.frequency;
    let edges = [tone * 10_f64.powf(-0.05), tone * 10_f64.powf(0.05)];
    let band = band_pass(samples, rate, edges).samples;
    // Ten periods at each end depend on the other end.
    let margin = (10.0 * rate / tone).ceil() as usize;
    let inner = band.get(margin..band.len().checked_sub(margin)?)?;
    let length = (INTERVAL * rate) as usize;
    let square = |part: &[f64]| part.iter().map(|x| x * x).sum::<f64>() / part.len() as f64;
    let levels: Vec<f64> = inner
        .chunks_exact(length.max(1))
        .map(|part| level(square(part)))
        .collect();
    let rms = square(inner).sqrt();
    if levels.len() < 2 || rms.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
        return None;
    }
    Some(Calibration {
        sensitivity_pa: REFERENCE_PRESSURE * 10_f64.powf(stated / 20.0) / rms,
        calibrator: Some(CalibratorTone {
            stated_level_db: stated,
            tone_hz: tone,
            level_deviation_db: deviation(&levels),
        }),
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{SQRT_2, TAU};

    use super::*;
    use crate::test_signals::noise;

    /// A sine of 94 dB at a frequency, with a whole number of periods in 2 s.
    fn sine(frequency: f64, rate: f64) -> Vec<f64> {
        let amplitude = SQRT_2 * REFERENCE_PRESSURE * 10_f64.powf(94.0 / 20.0);
        let frequency = (2.0 * frequency).round() / 2.0;
        let sample = |k: u32| amplitude * (TAU * frequency * f64::from(k) / rate).sin();
        (0..(2.0 * rate) as u32).map(sample).collect()
    }

    fn decibel(gain: f64) -> f64 {
        20.0 * gain.log10()
    }

    /// The weighting A of Table 3 of IEC 61672-1 (2013), 10 Hz to 20 kHz, dB, at the exact frequencies of base ten and
    /// rounded to 0.1 dB. Compared with the transcription in the tests of the library phonometry.
    #[test]
    fn the_weighting_a_is_that_of_the_standard() {
        const TABLE: [f64; 34] = [
            -70.4, -63.4, -56.7, -50.5, -44.7, -39.4, -34.6, -30.2, -26.2, -22.5, -19.1, -16.1,
            -13.4, -10.9, -8.6, -6.6, -4.8, -3.2, -1.9, -0.8, 0.0, 0.6, 1.0, 1.2, 1.3, 1.2, 1.0,
            0.5, -0.1, -1.1, -2.5, -4.3, -6.6, -9.3,
        ];
        for (number, expected) in (-20..).zip(TABLE) {
            let found = decibel(a_weighting(centre(number)));
            assert!(
                (found - expected).abs() <= 0.0501,
                "{} Hz: {found}",
                centre(number)
            );
        }
        // Through the whole analysis.
        for (frequency, expected) in [(63.0, -26.2), (1000.0, 0.0), (8000.0, -1.1)] {
            let levels = sound_levels(&sine(frequency, 48_000.0), 48_000.0).unwrap();
            assert!((levels.equivalent_level_db - 94.0).abs() < 1e-9);
            assert!(
                (levels.a_weighted_level_db - 94.0 - expected).abs() < 0.1,
                "{frequency}"
            );
            // At 8 kHz no sample is at the peak.
            let peak = levels.peak_level_db - 94.0;
            assert!(
                frequency > 1000.0 || (peak - 3.01).abs() < 0.02,
                "{frequency}: {peak}"
            );
        }
    }

    /// Limits of the attenuation of class 1 in Table 1 of IEC 61260 (1995), which are those of ANSI S1.11 (2004): least
    /// and largest attenuation, dB, at the ratio of the frequency to the centre of a third octave, from Table F.1 of
    /// IEC 61260-1 (2014). Compared with the transcriptions in the tests of the library phonometry. The limits of the
    /// edition of 2014 are wider.
    #[test]
    fn third_octaves_are_of_class_1_by_tones() {
        const LIMITS: [(f64, f64, f64); 9] = [
            (1.0, -0.3, 0.3),
            (1.02667, -0.3, 0.4),
            (1.05575, -0.3, 0.6),
            (1.08746, -0.3, 1.3),
            (1.12202, 2.0, 5.0),
            (1.29437, 17.5, f64::INFINITY),
            (1.88173, 42.0, f64::INFINITY),
            (3.05365, 61.0, f64::INFINITY),
            (5.39195, 70.0, f64::INFINITY),
        ];
        for (number, nominal) in [(-7, 200.0), (0, 1000.0), (5, 3150.0)] {
            let attenuation_at =
                |hz: f64| -10.0 * band_gain(centre(number).powi(2), hz * hz).log10();
            for (ratio, least, largest) in LIMITS {
                for frequency in [centre(number) * ratio, centre(number) / ratio] {
                    // At the edges of a limit the tone must not be rounded to a whole number of periods.
                    let gain = attenuation_at(frequency);
                    assert!(
                        (least..=largest).contains(&gain),
                        "{nominal} Hz, {frequency} Hz: {gain}"
                    );
                    let played = (2.0 * frequency).round() / 2.0;
                    let levels = sound_levels(&sine(frequency, 48_000.0), 48_000.0).unwrap();
                    let band = levels
                        .third_octaves
                        .iter()
                        .find(|band| band.centre_hz == nominal);
                    let attenuation = 94.0 - band.unwrap().band_level_db;
                    let expected = attenuation_at(played);
                    assert!(
                        (attenuation - expected).abs() < 1e-3,
                        "{frequency} Hz: {attenuation}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_power_of_noise_is_the_sum_of_its_third_octaves() {
        use rand::{RngExt as _, SeedableRng};
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let noise: Vec<f64> = (0..96_000)
            .map(|_| random.random_range(-1.0..1.0))
            .collect();
        let levels = sound_levels(&noise, 48_000.0).unwrap();
        let density = (1.0 / 3.0) / 24_000.0;
        for band in &levels.third_octaves {
            let width = band.centre_hz * RELATIVE_WIDTH;
            // The bandwidth of a Butterworth filter of order 6 for noise is 1.047 of that between its edges.
            let expected = level(density * 1.047 * width);
            let off = (band.band_level_db - expected).abs();
            // The nominal centres are rounded by up to 1 %, that is 0.05 dB.
            assert!(
                off < 4.0 * band.standard_deviation_db + 0.06,
                "{band:?} {expected}"
            );
        }
        assert_eq!(
            levels.third_octaves.first().map(|b| b.centre_hz),
            Some(20.0)
        );
        assert_eq!(
            levels.third_octaves.last().map(|b| b.centre_hz),
            Some(20_000.0)
        );
        // 0.1 s do not resolve the lowest bands.
        let short = sound_levels(&noise[..4800], 48_000.0).unwrap();
        assert_eq!(
            short.third_octaves.first().map(|b| b.centre_hz),
            Some(200.0)
        );
        assert!(sound_levels(&[], 48_000.0).is_err());
    }

    #[test]
    fn the_length_of_a_signal_hardly_matters() {
        let noise = noise(1, 1_100_003, 1.0);
        let count = noise.len();
        let [own, quick] = [count, quick_length(count)]
            .map(|length| levels_by_transform(&noise, 48_000.0, length).unwrap());
        assert!((own.a_weighted_level_db - quick.a_weighted_level_db).abs() < 1e-4);
        for (a, b) in own.third_octaves.iter().zip(&quick.third_octaves) {
            let off = (a.band_level_db - b.band_level_db).abs();
            assert!(off < 0.1 * a.standard_deviation_db, "{a:?} {b:?}");
        }
        assert_eq!([1, 96_001, count].map(quick_length), [1, 96_001, 1_102_248]);
    }

    /// Time weighting F: a burst of 0.2 s reads 1.0 dB less than a steady tone (IEC 61672-1, Table 4).
    #[test]
    fn a_short_burst_reads_less() {
        let mut burst = sine(4000.0, 48_000.0);
        let steady = sound_levels(&burst, 48_000.0).unwrap();
        for (k, sample) in burst.iter_mut().enumerate() {
            if !(24_000..24_000 + 9600).contains(&k) {
                *sample = 0.0;
            }
        }
        let short = sound_levels(&burst, 48_000.0).unwrap();
        let less = steady.fast_maximum_db - short.fast_maximum_db;
        assert!((less - 1.0).abs() < 0.1, "{less}");
    }

    #[test]
    fn a_calibrator_gives_the_sensitivity() {
        let pressure = sine(1000.0, 48_000.0);
        let recorded: Vec<f64> = pressure.iter().map(|p| 0.05 * p).collect();
        let calibration = calibrate(&recorded, 48_000.0, 94.0).unwrap();
        // 0.0001 dB: the interval is not a whole number of periods.
        assert!(
            (calibration.sensitivity_pa / 20.0 - 1.0).abs() < 1.2e-5,
            "{calibration:?}"
        );
        assert!(calibration.calibrator.unwrap().level_deviation_db < 1e-6);
        assert_eq!(calibrate(&[0.0; 48_000], 48_000.0, 94.0), None);
        assert_eq!(calibrate(&recorded[..4800], 48_000.0, 94.0), None);
    }
}
