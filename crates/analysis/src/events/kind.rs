//! The kind of a sound: ten numbers about it, and a fitted model of what they mean.
//!
//! A path through noise is faint and incoherent; syllables and notes are brief, and there are many alike of other pitches; a
//! struck note dies out; noise of a resonance has a random phase and an uneven level; bursts are separated by silence. A squeak
//! is a steady level with a coherent phase, often with harmonics, alone. No number decides alone: the model (`model.json`) is a
//! multinomial logistic regression on recordings whose sounds are known.

use std::f64::consts::LN_2;
use std::sync::LazyLock;

use super::group::{Group, SAME};
use super::partial::STEP_S;
use super::{EventKind, TonalEvent};
use crate::logistic::Model;

/// The classes of the model; `None` is no event.
pub(super) const CLASSES: [Option<EventKind>; 4] = [
    None,
    Some(EventKind::Tone),
    Some(EventKind::NarrowBandNoise),
    Some(EventKind::Bursts),
];

pub(super) static MODEL: LazyLock<Model> =
    LazyLock::new(|| Model::of_program(include_str!("model.json")));

/// Time before and after a sound in which sounds alike are counted, s: those at another frequency with duration, unevenness
/// and innovation within a factor of two.
const AROUND_S: f64 = 5.0;

/// The inputs of the model for one of `all` sounds, by name.
pub(super) fn inputs(which: usize, all: &[(TonalEvent, Group)]) -> [(&'static str, f64); 10] {
    let (event, group) = &all[which];
    let (_, leader) = group.leader();
    let length = |event: &TonalEvent| event.span().length_s().max(STEP_S).ln();
    // The number of others that sound between two times, as a logarithm.
    let count = |margin_s: f64, is: &dyn Fn(&TonalEvent, &Group) -> bool| {
        let others = all.iter().enumerate().filter(|(k, (other, group))| {
            *k != which
                && other.start_s < event.end_s + margin_s
                && other.end_s > event.start_s - margin_s
                && is(other, group)
        });
        (others.count() as f64).ln_1p()
    };
    let is_alike = |other: &TonalEvent, other_group: &Group| {
        let (_, other_leader) = other_group.leader();
        (length(other) - length(event)).abs() < LN_2
            && (other_leader.unevenness - leader.unevenness).abs() < LN_2
            && (other_leader.innovation - leader.innovation).abs() < LN_2
            && (other.frequency_hz / event.frequency_hz - 1.0).abs() > SAME
    };
    [
        ("snr", event.snr_db),
        ("duration", length(event)),
        ("frequency", event.frequency_hz.ln()),
        ("unevenness", leader.unevenness),
        ("decay", leader.decay),
        ("incoherence", leader.incoherence),
        ("kurtosis", leader.kurtosis),
        ("harmonics", (event.harmonics as f64).ln()),
        ("alike", count(AROUND_S, &is_alike)),
        ("near", count(event.span().length_s(), &|_, _| true)),
    ]
}

/// The likeliest class of inputs with its probability.
pub(super) fn likeliest(inputs: &[(&str, f64); 10]) -> (Option<EventKind>, f64) {
    let probabilities = MODEL.probabilities(&inputs.map(|input| input.1));
    let classes = CLASSES.into_iter().zip(probabilities);
    let best = classes.max_by(|a, b| a.1.total_cmp(&b.1));
    best.expect("the model has classes")
}
