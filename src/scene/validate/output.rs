//! What is made of the samples: analyses and recording.

use crate::scene::error::SceneError;
use crate::scene::file::Document;
use crate::scene::keys;
use crate::scene::spec::{
    AnalysisSpec, RecordSpec, RecurrenceSpec, RecurrenceThreshold, SpectrogramSpec, SpectrumSpec,
};

pub(super) fn analysis(
    document: &Document<'_>,
    sample_rate: f64,
) -> Result<AnalysisSpec, SceneError> {
    Ok(AnalysisSpec {
        spectrum: spectrum(document, sample_rate)?,
        spectrogram: spectrogram(document, sample_rate)?,
        recurrence: recurrence(document, sample_rate)?,
    })
}

fn spectrum(document: &Document<'_>, rate: f64) -> Result<Option<SpectrumSpec>, SceneError> {
    if !document.has("analysis.spectrum") {
        return Ok(None);
    }
    let spec = SpectrumSpec {
        window: document.get(&keys::SPECTRUM_WINDOW)?,
        every: document.get(&keys::SPECTRUM_EVERY)?,
    };
    long_enough(document, keys::SPECTRUM_WINDOW.path, spec.window, rate)?;
    Ok(Some(spec))
}

fn spectrogram(document: &Document<'_>, rate: f64) -> Result<Option<SpectrogramSpec>, SceneError> {
    if !document.has("analysis.spectrogram") {
        return Ok(None);
    }
    let spec = SpectrogramSpec {
        window: document.get(&keys::SPECTROGRAM_WINDOW)?,
        every: document.get(&keys::SPECTROGRAM_EVERY)?,
        max_frequency: document.get(&keys::MAX_FREQUENCY)?,
    };
    long_enough(document, keys::SPECTROGRAM_WINDOW.path, spec.window, rate)?;
    if spec.max_frequency > rate / 2.0 {
        return Err(document.inconsistent(
            keys::MAX_FREQUENCY.path,
            &[keys::SAMPLE_RATE.path],
            format!(
                "{} kHz is above half the sample rate ({} kHz), beyond which samples say nothing",
                spec.max_frequency / 1e3,
                rate / 2e3
            ),
            "lower it, or raise time.sample_rate_khz",
        ));
    }
    Ok(Some(spec))
}

fn recurrence(document: &Document<'_>, rate: f64) -> Result<Option<RecurrenceSpec>, SceneError> {
    if !document.has("analysis.recurrence") {
        return Ok(None);
    }
    let share = document.find(&keys::THRESHOLD_RATE)?;
    let distance = document.find(&keys::THRESHOLD_DISTANCE)?;
    let threshold = match (share, distance) {
        (Some(share), None) => RecurrenceThreshold::Rate(share),
        (None, Some(distance)) => RecurrenceThreshold::Distance(distance),
        (None, None) => return Err(document.missing(&keys::THRESHOLD_RATE)),
        (Some(_), Some(_)) => {
            return Err(document.inconsistent(
                keys::THRESHOLD_DISTANCE.path,
                &[keys::THRESHOLD_RATE.path],
                "the threshold is given twice, as a rate and as a distance",
                "keep one of threshold_rate and threshold_um",
            ));
        }
    };
    let spec = RecurrenceSpec {
        window: document.get(&keys::RECURRENCE_WINDOW)?,
        size: document.get(&keys::RECURRENCE_SIZE)?,
        every: document.get(&keys::RECURRENCE_EVERY)?,
        lag: document.get(&keys::LAG)?,
        dimension: document.get(&keys::DIMENSION)?,
        threshold,
    };
    long_enough(document, keys::RECURRENCE_WINDOW.path, spec.window, rate)?;
    if spec.size as f64 > (spec.window * rate).round() {
        return Err(document.inconsistent(
            keys::RECURRENCE_SIZE.path,
            &[keys::RECURRENCE_WINDOW.path],
            format!(
                "{} points from a window of {:.0} samples",
                spec.size,
                spec.window * rate
            ),
            "take fewer points or a longer window",
        ));
    }
    if spec.lag * rate < 0.999 {
        return Err(document.inconsistent(
            keys::LAG.path,
            &[keys::SAMPLE_RATE.path],
            format!("the delay is shorter than one sample ({} us)", 1e6 / rate),
            "make it at least that long",
        ));
    }
    Ok(Some(spec))
}

/// A window must hold enough samples to be analysed.
fn long_enough(
    document: &Document<'_>,
    key: &'static str,
    window: f64,
    rate: f64,
) -> Result<(), SceneError> {
    const FEWEST_SAMPLES: f64 = 16.0;
    if (window * rate).round() >= FEWEST_SAMPLES {
        return Ok(());
    }
    Err(document.inconsistent(
        key,
        &[keys::SAMPLE_RATE.path],
        format!("the window holds fewer than {FEWEST_SAMPLES} samples"),
        format!("make it at least {} ms", FEWEST_SAMPLES / rate * 1e3),
    ))
}

pub(super) fn record(document: &Document<'_>, sample_rate: f64) -> Result<RecordSpec, SceneError> {
    let rate = |key| {
        let rate = document.get(key)?;
        if rate <= sample_rate {
            return Ok(rate);
        }
        Err(document.inconsistent(
            key.path,
            &[keys::SAMPLE_RATE.path],
            format!(
                "more often than samples are taken ({} kHz)",
                sample_rate / 1e3
            ),
            "make it at most time.sample_rate_khz",
        ))
    };
    Ok(RecordSpec {
        patch_rate: rate(&keys::PATCH_RATE)?,
        body_rate: rate(&keys::BODY_RATE)?,
        energy_rate: rate(&keys::ENERGY_RATE)?,
        exaggeration: document.get(&keys::EXAGGERATION)?,
    })
}
