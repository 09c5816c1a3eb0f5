//! The kind of a sound: eleven numbers about it, and a fitted model of what they mean.
//!
//! A path through noise is faint; a struck note falls from its onset on; syllables and notes are brief, follow each other and
//! start together with others; noise of a resonance has a random phase and an uneven level; bursts are modulated deeply, and each
//! has a phase of its own. A squeak is a steady level with a coherent phase, often with harmonics, alone. No
//! number decides alone: the model (`model.json`) is a multinomial logistic regression on recordings whose sounds are known.

use std::sync::LazyLock;

use super::baseband::averages;
use super::group::Group;
use super::partial::STEP_S;
use super::{EventKind, TonalEvent};
use crate::logistic::Model;
use crate::stats::{LineFit, deviation, mean};

/// The inputs of the model.
pub(super) const INPUTS: [&str; 11] = [
    "snr",
    "level",
    "duration",
    "frequency",
    "slope",
    "unevenness",
    "incoherence",
    "modulation",
    "harmonics",
    "brief_sounds",
    "simultaneous_onsets",
];

/// The classes of the model; `None` is no event.
pub(super) const CLASSES: [Option<EventKind>; 4] = [
    None,
    Some(EventKind::Tone),
    Some(EventKind::NarrowBandNoise),
    Some(EventKind::Bursts),
];

pub(super) static MODEL: LazyLock<Model> =
    LazyLock::new(|| Model::of_program(include_str!("model.json")));

/// Half of the time over which the level is averaged, steps.
const HALF_LEVEL: usize = 4;

/// Signal-to-noise ratio from which more says nothing, dB.
const CLEAR_DB: f64 = 25.0;

/// Slope of the level from which steeper says less, dB/s.
const STEEP_DB_PER_S: f64 = 10.0;

/// Largest duration of brief sounds, and time before and after a sound in which they count, s.
const BRIEF_S: f64 = 1.0;
const AROUND_S: f64 = 3.0;

/// Largest distance of another onset from the start or the end of a sound, s.
const TOGETHER_S: f64 = 0.05;

/// Slope of the level without a tenth at each end, dB/s, and standard deviation of the power over its mean.
fn level(group: &Group) -> [f64; 2] {
    let (_, leader) = group.leader();
    let power: Vec<f64> = leader.track.iter().map(|p| p.1).collect();
    let smooth = averages(&power, HALF_LEVEL);
    let mean = mean(&smooth).max(f64::MIN_POSITIVE);
    let margin = smooth.len() / 10;
    let mut line = LineFit::default();
    for (i, power) in smooth[margin..smooth.len() - margin].iter().enumerate() {
        // What is more than 30 dB below the mean is a gap, however deep.
        line.push(STEP_S * i as f64, 10.0 * (power / mean + 1e-3).log10());
    }
    let slope = line.fit().map_or(0.0, |fit| fit.slope);
    [slope, deviation(&smooth) / mean]
}

/// The inputs of the model for an event of a group among `all`, in a recording of a level, dB.
pub(super) fn inputs(
    event: &TonalEvent,
    group: &Group,
    all: &[TonalEvent],
    recording_db: f64,
) -> [f64; INPUTS.len()] {
    let [slope, unevenness] = level(group);
    let count = |is: &dyn Fn(&TonalEvent) -> bool| {
        let others = all.iter().filter(|other| !std::ptr::eq(*other, event));
        (others.filter(|other| is(other)).count() as f64).ln_1p()
    };
    [
        event.snr_db.min(CLEAR_DB),
        event.level_db - recording_db,
        event.span().length_s().max(STEP_S).ln(),
        event.frequency_hz.ln(),
        slope / (1.0 + slope.abs() / STEEP_DB_PER_S),
        unevenness,
        group.leader().1.incoherence,
        event.modulation.map_or(0.0, |m| m.modulation_depth),
        (event.harmonics as f64).ln(),
        count(&|other| {
            other.span().length_s() < BRIEF_S
                && other.start_s < event.end_s + AROUND_S
                && other.end_s > event.start_s - AROUND_S
        }),
        count(&|other| {
            [event.start_s, event.end_s]
                .into_iter()
                .any(|time| (other.start_s - time).abs() < TOGETHER_S)
        }),
    ]
}

/// The likeliest class of inputs with its probability.
pub(super) fn likeliest(inputs: &[f64]) -> (Option<EventKind>, f64) {
    let probabilities = MODEL.probabilities(inputs).into_iter();
    let classes = CLASSES.into_iter().zip(probabilities);
    let best = classes.max_by(|a, b| a.1.total_cmp(&b.1));
    best.expect("the model has classes")
}
