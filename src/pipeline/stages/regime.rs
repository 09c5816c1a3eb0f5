//! The kind of motion, from the probe's displacement.

use std::sync::Arc;

use super::thinning::EveryStep;
use super::{Context, Emit, Stage, samples};
use crate::analysis::{RegimeSearch, SlidingWindow, classify};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Frame, Record};
use crate::scene::RegimeSpec;

/// Emits [`Record::Regime`]. A window of which nothing can be said is passed over.
///
/// Samples are taken every step, counted from the first one of the run.
pub struct RegimeStage {
    every_step: EveryStep,
    sliding: SlidingWindow<1>,
    search: RegimeSearch,
}

impl RegimeStage {
    /// For samples at `rate` (Hz).
    pub fn new(spec: &RegimeSpec, rate: f64) -> Self {
        let every_step = EveryStep::new(samples(spec.step, rate, 1));
        let rate = rate / every_step.step() as f64;
        Self {
            every_step,
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
        let Self {
            every_step,
            sliding,
            search,
        } = self;
        let step = every_step.step() as u64;
        sliding.push([every_step.of(&frame.displacement)], |view| {
            let [displacement] = view.channels;
            let Ok(verdict) = classify(displacement, search) else {
                return Ok(());
            };
            emit(Record::Regime {
                time: context.newest((view.seen - 1) * step + 1),
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
        let last = |scene| verdicts(scene).pop().unwrap().1;
        assert_eq!(last("periodic-2deg"), Regime::Periodic);
        assert_eq!(last("torus-3deg"), Regime::QuasiPeriodic);
    }

    #[test]
    fn weak_chaos_is_not_told_as_a_tone() {
        let verdicts = verdicts("chaos-5deg");
        let doubts = |regime| matches!(regime, Regime::Chaotic | Regime::Unsure);
        let doubtful = verdicts.iter().filter(|(_, regime)| doubts(*regime));
        assert!(2 * doubtful.count() > verdicts.len(), "{verdicts:?}");
        assert!(
            verdicts
                .iter()
                .all(|(_, regime)| *regime != Regime::Periodic)
        );
    }

    #[test]
    #[ignore = "in 40 ms the verdict takes the ramp's weak chaos, and its drifting tone, for a torus"]
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
