//! The kind of motion, from the probe's displacement.

use std::sync::Arc;

use super::{Context, Emit, Stage, samples};
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
            sliding: SlidingWindow::new(
                samples(spec.sliding.window, rate, 1),
                spec.sliding.every * rate,
            ),
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

    /// What is said for sure, each once.
    fn history(verdicts: &[(f64, Regime)]) -> Vec<Regime> {
        let lasting = [Regime::Periodic, Regime::QuasiPeriodic, Regime::Chaotic];
        let told = verdicts.iter().map(|(_, regime)| *regime);
        let mut told: Vec<Regime> = told.filter(|regime| lasting.contains(regime)).collect();
        told.dedup();
        told
    }

    #[test]
    fn the_ramp_goes_from_a_tone_to_a_torus_to_chaos() {
        let verdicts = verdicts("tilt-ramp");
        let expected = [Regime::Periodic, Regime::QuasiPeriodic, Regime::Chaotic];
        assert_eq!(history(&verdicts), expected, "{verdicts:?}");
    }

    #[test]
    fn scenes_of_one_kind_are_told_as_that() {
        for (scene, regime) in [
            ("periodic-2deg", Regime::Periodic),
            ("torus-3deg", Regime::QuasiPeriodic),
            ("chaos-5deg", Regime::Chaotic),
        ] {
            let verdicts = verdicts(scene);
            assert_eq!(verdicts.last().unwrap().1, regime, "{scene}: {verdicts:?}");
        }
    }
}
