//! Successive motions within one run.

use schemars::JsonSchema;
use serde::Serialize;

use crate::dynamics::{Attractor, LyapunovSpectrum};

/// A motion between two changes of attractor, with its exponents.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct MotionSegment {
    /// Start time, s: of the averaging for the first motion, else of the change.
    pub start_s: f64,
    /// End time, s.
    pub end_s: f64,
    /// Attractor that the exponents indicate.
    #[schemars(with = "String")]
    pub attractor: Attractor,
    /// Exponents averaged within the motion; of zero averaging time if it is too short.
    #[serde(flatten)]
    pub spectrum: LyapunovSpectrum,
}

impl MotionSegment {
    /// Lifetime of the chaotic transient before the last motion, s: the time from `since` (s), when the
    /// motion started under its present parameters, to the end of the last chaotic segment before the last
    /// one. `None` if no earlier motion under these parameters was chaotic.
    pub fn chaotic_transient(segments: &[Self], since: f64) -> Option<f64> {
        let (_, earlier) = segments.split_last()?;
        let mut chaotic = earlier.iter().rev().filter(|s| s.attractor.is_chaotic());
        let end = chaotic.next()?.end_s;
        (end > since).then_some(end - since)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transient_lives_until_its_last_chaotic_motion_ends() {
        let segment = |start, end, attractor| MotionSegment {
            start_s: start,
            end_s: end,
            attractor,
            spectrum: LyapunovSpectrum::default(),
        };
        let [chaos, approach, cycle] = [
            segment(0.1, 0.8, Attractor::Chaos),
            segment(0.8, 0.9, Attractor::Undecided),
            segment(0.9, 2.0, Attractor::Cycle),
        ];
        let lifetime = |segments: &[&MotionSegment], since| {
            let segments: Vec<MotionSegment> = segments.iter().copied().cloned().collect();
            MotionSegment::chaotic_transient(&segments, since)
        };
        assert_eq!(lifetime(&[&chaos, &cycle], 0.0), Some(0.8));
        assert_eq!(
            lifetime(&[&chaos, &approach, &cycle], 0.25),
            Some(0.8 - 0.25)
        );
        // The chaos belongs to other parameters.
        assert_eq!(lifetime(&[&chaos, &cycle], 0.85), None);
        assert_eq!(lifetime(&[&approach, &cycle], 0.0), None);
        assert_eq!(lifetime(&[&cycle, &chaos], 0.0), None);
        assert_eq!(lifetime(&[&chaos], 0.0), None);
        assert_eq!(lifetime(&[], 0.0), None);
    }
}
