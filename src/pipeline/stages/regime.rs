//! Regime of the motion, from the probe's displacement.

use std::sync::Arc;

use super::stage::Stage;
use super::windowed::{Windowed, displacement, sliding};
use crate::analysis::{RegimeSearch, classify};
use crate::pipeline::message::Record;
use crate::scene::RegimeSpec;

/// Emits [`Record::Regime`] of samples at `rate` (Hz). A window that cannot be classified is skipped.
pub fn regime(spec: &RegimeSpec, rate: f64) -> impl Stage + use<> {
    let search = RegimeSearch {
        sample_rate: rate,
        silence: spec.silence,
        background: 0.0,
    };
    let sliding = sliding(&spec.sliding, rate);
    let verdicts = Windowed::new(sliding, displacement, move |window, _, emit| {
        let [signal] = window.channels;
        let Ok(verdict) = classify(signal, &search) else {
            return Ok(());
        };
        emit(Record::Regime {
            time: window.time,
            window: signal.len() as f64 / rate,
            verdict: Arc::new(verdict),
        })
    });
    // Lessons and panels name the type of motion.
    verdicts.complete()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::Regime;
    use crate::pipeline::{Monitor, run};
    use crate::scene::Scene;

    /// Regimes of a preset scene: (time in ms, regime).
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
    fn a_periodic_motion_and_a_torus_are_recognised() {
        for (scene, expected) in [
            ("periodic-2deg", Regime::Periodic),
            ("doubled-torus-3deg", Regime::QuasiPeriodic),
        ] {
            let verdicts = verdicts(scene);
            // After the transient has left the window.
            let mut settled = verdicts.iter().filter(|(time, _)| *time > 70.0);
            let other = settled.find(|(_, regime)| *regime != expected);
            assert_eq!(other, None, "{scene}: {verdicts:?}");
        }
    }

    #[test]
    fn weak_chaos_is_recognised() {
        // The transient resembles the torus; after it has left the window, the motion is chaotic.
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
    fn the_tilt_ramp_passes_from_periodic_to_torus_to_chaos() {
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
