//! The kind of motion, from the probe's displacement.

use std::sync::Arc;

use super::{Context, Emit, Stage, sliding};
use crate::analysis::{RegimeSearch, SlidingWindow, classify};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Frame, Record};
use crate::scene::RegimeSpec;

/// Emits [`Record::Regime`]. A window of which nothing can be said is passed over.
pub struct RegimeStage {
    sliding: SlidingWindow<1>,
    search: RegimeSearch,
}

impl RegimeStage {
    /// For samples at `rate` (Hz).
    pub fn new(spec: &RegimeSpec, rate: f64) -> Self {
        Self {
            sliding: sliding(&spec.sliding, rate),
            search: RegimeSearch {
                sample_rate: rate,
                silence: spec.silence,
            },
        }
    }
}

impl Stage for RegimeStage {
    fn push(
        &mut self,
        frame: &Frame,
        context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let Self { sliding, search } = self;
        sliding.space_out(frame.apart());
        sliding.push([&frame.displacement], |view| {
            let [displacement] = view.channels;
            let Ok(verdict) = classify(displacement, search) else {
                return Ok(());
            };
            emit(Record::Regime {
                time: context.newest(view.seen),
                window: displacement.len() as f64 / search.sample_rate,
                verdict: Arc::new(verdict),
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::Regime;
    use crate::pipeline::{Monitor, run};
    use crate::scene::Scene;

    /// The verdicts on a scene that comes with the program: (time in ms, verdict).
    fn verdicts(scene: &str) -> Vec<(f64, Regime)> {
        let mut records: Vec<Record> = Vec::new();
        let scene = Scene::load(scene).unwrap();
        run(&scene, "", &mut records, Monitor::default()).unwrap();
        let verdict = |record: &Record| match record {
            Record::Regime { time, verdict, .. } => Some((1e3 * time, verdict.regime)),
            _ => None,
        };
        records.iter().filter_map(verdict).collect()
    }

    #[test]
    fn a_tone_and_a_torus_are_told_as_that() {
        for (scene, expected) in [
            ("periodic-2deg", Regime::Periodic),
            ("torus-3deg", Regime::QuasiPeriodic),
        ] {
            let verdicts = verdicts(scene);
            // Once the start is gone from the window.
            let mut settled = verdicts.iter().filter(|(time, _)| *time > 70.0);
            let other = settled.find(|(_, regime)| *regime != expected);
            assert_eq!(other, None, "{scene}: {verdicts:?}");
        }
    }

    #[test]
    fn weak_chaos_is_told_as_chaos() {
        // Its start settles as the torus does; once it is gone from the window it is chaos.
        let verdicts = verdicts("chaos-5deg");
        let chaotic = |(_, regime): &&(f64, Regime)| *regime == Regime::Chaotic;
        assert!(
            10 * verdicts.iter().filter(chaotic).count() > 8 * verdicts.len(),
            "{verdicts:?}"
        );
        let regular = [Regime::Periodic, Regime::QuasiPeriodic];
        let taken = verdicts.iter().find(|(_, regime)| regular.contains(regime));
        assert_eq!(taken, None, "{verdicts:?}");
    }

    #[test]
    fn the_ramp_goes_from_a_tone_to_a_torus_to_chaos() {
        let verdicts = verdicts("tilt-ramp");
        let lasting = verdicts.iter().map(|(_, regime)| *regime).filter(|regime| {
            let lasting = [Regime::Periodic, Regime::QuasiPeriodic, Regime::Chaotic];
            lasting.contains(regime)
        });
        let mut history: Vec<Regime> = lasting.collect();
        history.dedup();
        let expected = [Regime::Periodic, Regime::QuasiPeriodic, Regime::Chaotic];
        assert_eq!(history, expected, "{verdicts:?}");
    }
}
