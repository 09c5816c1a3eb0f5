//! Regime of the motion, from the probe's displacement.

use std::sync::Arc;

use super::stage::{Stage, displacement, sliding, windowed};
use crate::analysis::regime::{RegimeSearch, classify};
use crate::pipeline::message::Record;
use crate::scene::RegimeSpec;

/// Emits [`Record::Regime`] of samples at `rate` (Hz). A window that cannot be classified is skipped.
pub fn regime(spec: &RegimeSpec, rate: f64) -> Stage {
    let search = RegimeSearch {
        sample_rate: rate,
        silence: spec.silence,
        background: 0.0,
    };
    let sliding = sliding(spec.window, spec.every, rate);
    // Complete: lessons and panels name the type of motion.
    windowed(displacement, sliding, false, move |window, context| {
        let verdict = classify(window.signal, &search).ok();
        context
            .records
            .extend(verdict.map(|verdict| Record::Regime {
                time: window.time,
                window: window.signal.len() as f64 / rate,
                verdict: Arc::new(verdict),
            }));
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::regime::Regime;
    use crate::pipeline::{Monitor, run};
    use crate::scene::Scene;

    /// Regimes of a preset scene: (time in ms, regime).
    fn verdicts(scene: &Scene) -> Vec<(f64, Regime)> {
        let mut records: Vec<Record> = Vec::new();
        let mut alone = scene.clone().without_analyses();
        alone.analysis.regime = scene.analysis.regime;
        run(&alone, "", &mut records, Monitor::default()).unwrap();
        let verdict = |record: &Record| match record {
            Record::Regime { time, verdict, .. } => Some((1e3 * time, verdict.regime)),
            _ => None,
        };
        records.iter().filter_map(verdict).collect()
    }

    #[test]
    fn a_periodic_motion_and_a_torus_are_recognised() {
        for (scene, expected) in [
            ("periodic-2deg", Regime::Periodic),
            ("doubled-torus-3deg", Regime::QuasiPeriodic),
        ] {
            let verdicts = verdicts(&Scene::load(scene).unwrap());
            // After the transient has left the window.
            let mut settled = verdicts.iter().filter(|(time, _)| *time > 70.0);
            let other = settled.find(|(_, regime)| *regime != expected);
            assert_eq!(other, None, "{scene}: {verdicts:?}");
        }
    }

    #[test]
    fn weak_chaos_is_recognised() {
        // The transient resembles the torus; after it has left the window, the motion is chaotic. Which windows look regular
        // changes with rounding, so several kicks are pooled.
        let kick = crate::scene::Parameter::named("start.kick_mm_per_s").unwrap();
        let verdicts = [0.01, 0.010_01, 0.010_02, 0.010_03].map(|size| {
            let scene = Scene::load("chaos-5deg").unwrap();
            verdicts(&scene.with_values(&[(kick, size)]).unwrap())
        });
        let verdicts = verdicts.concat();
        let count = |regimes: &[Regime]| {
            let found = verdicts
                .iter()
                .filter(|(_, regime)| regimes.contains(regime));
            found.count()
        };
        assert!(
            10 * count(&[Regime::Chaotic]) > 8 * verdicts.len(),
            "{verdicts:?}"
        );
        let regular = count(&[Regime::Periodic, Regime::QuasiPeriodic]);
        assert!(10 * regular < verdicts.len(), "{verdicts:?}");
    }

    #[test]
    fn the_tilt_ramp_passes_from_periodic_to_torus_to_chaos() {
        // Which windows of the chaos look regular changes with rounding, so several kicks are pooled.
        let kick = crate::scene::Parameter::named("start.kick_mm_per_s").unwrap();
        let verdicts = [0.01, 0.010_01, 0.010_02, 0.010_03].map(|size| {
            let scene = Scene::load("tilt-ramp").unwrap();
            verdicts(&scene.with_values(&[(kick, size)]).unwrap())
        });
        // Windows at a constant tilt, and the least share of the verdict there.
        for (regime, [from, to], least) in [
            (Regime::Periodic, [69.0, 101.0], 1.0),
            (Regime::QuasiPeriodic, [199.0, 241.0], 1.0),
            (Regime::Chaotic, [319.0, 381.0], 0.8),
        ] {
            let found = verdicts.iter().flatten();
            let found = found.filter(|(time, _)| (from..to).contains(time));
            let found: Vec<Regime> = found.map(|(_, regime)| *regime).collect();
            let own = found.iter().filter(|found| **found == regime).count();
            let share = own as f64 / found.len() as f64;
            assert!(share >= least, "{regime}: {found:?}");
        }
    }
}
