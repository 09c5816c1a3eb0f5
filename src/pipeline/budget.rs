//! Budget of the analyses: fewer windows while they are slower than real time, or than the playback of a live run.

use super::message::{Frame, Record};

/// Simulated time over which the load is measured, s: several windows of each analysis.
const INTERVAL: f64 = 40e-3;

/// Most halvings of the rate.
const MOST_HALVINGS: u32 = 4;

/// Load below which the rate is doubled; the load is then still below 1.
const LOW_LOAD: f64 = 0.4;

/// Measures the time that the analyses take, and sets the divisor of their rate: of the windows that a scene
/// requests, every `divisor`-th is computed.
#[derive(Debug, Default)]
pub(super) struct Budget {
    halvings: u32,
    /// Since the last decision, s: simulated time, the time in which it is to be played, and computing time.
    simulated: f64,
    playback: f64,
    busy: f64,
    /// Simulated time so far, and the same weighted with the rate, s.
    total: f64,
    weighted: f64,
}

impl Budget {
    /// The present divisor.
    pub fn divisor(&self) -> u64 {
        1 << self.halvings
    }

    /// Adds a frame whose analyses took `busy` seconds. Returns a warning if the divisor changes.
    pub fn follow(&mut self, frame: &Frame, busy: f64) -> Option<Record> {
        let time = frame.end();
        let simulated = time - frame.t0;
        self.total += simulated;
        self.weighted += simulated / self.divisor() as f64;
        self.simulated += simulated;
        // A live run is played more slowly or faster.
        self.playback += simulated / frame.shown.map_or(1.0, |shown| shown.speed);
        self.busy += busy;
        if self.simulated < INTERVAL {
            return None;
        }
        let load = self.busy / self.playback;
        (self.simulated, self.playback, self.busy) = (0.0, 0.0, 0.0);
        let halvings = match load {
            1.0.. => MOST_HALVINGS.min(self.halvings + 1),
            ..LOW_LOAD => self.halvings.saturating_sub(1),
            _ => self.halvings,
        };
        let changed = std::mem::replace(&mut self.halvings, halvings) != halvings;
        let windows = match self.divisor() {
            1 => "all windows are".to_owned(),
            divisor => format!("1 of {divisor} windows is"),
        };
        changed.then(|| Record::Warning {
            time,
            text: format!(
                "the analyses took {load:.2} times the time of the playback: {windows} computed from {:.0} ms on",
                1e3 * time
            ),
        })
    }

    /// Mean rate of the analyses over the rate of the scene; `None` before the first frame.
    pub fn rate(&self) -> Option<f64> {
        (self.total > 0.0).then(|| self.weighted / self.total)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::analysis::recurrence::RecurrenceImage;
    use crate::pipeline::message::{DisplayRates, Summary};
    use crate::pipeline::{Monitor, run};
    use crate::scene::{AnalysisBudget, AnalysisSpec, Scene};

    /// Follows frames of 10 ms whose full analyses take `load` times as long, at a playback speed.
    fn follow_at(speed: f64, budget: &mut Budget, loads: &[f64]) -> Vec<u64> {
        let divisor = |(k, load): (usize, &f64)| {
            let busy = 10e-3 * load / budget.divisor() as f64;
            let (_, shown) = DisplayRates::at_speed(speed, 1e5);
            let frame = Frame {
                t0: 10e-3 * k as f64,
                dt: 1e-5,
                displacement: vec![0.0; 1000],
                shown: Some(shown),
                ..Frame::default()
            };
            budget.follow(&frame, busy);
            budget.divisor()
        };
        loads.iter().enumerate().map(divisor).collect()
    }

    fn follow(budget: &mut Budget, loads: &[f64]) -> Vec<u64> {
        follow_at(1.0, budget, loads)
    }

    #[test]
    fn a_slow_playback_leaves_more_time() {
        let mut budget = Budget::default();
        assert_eq!(follow_at(0.1, &mut budget, &[8.0; 16]), [1; 16]);
        assert_eq!(budget.rate(), Some(1.0));
        assert!(follow_at(0.1, &mut budget, &[30.0; 16])[15] >= 2);
    }

    #[test]
    fn the_rate_falls_until_the_analyses_keep_up_and_recovers() {
        let mut budget = Budget::default();
        let slow = follow(&mut budget, &[3.0; 16]);
        assert_eq!((slow[2], slow[4], slow[15]), (1, 2, 4));
        let fast = follow(&mut budget, &[0.3; 16]);
        assert_eq!(fast[15], 1);
        let rate = budget.rate().unwrap();
        assert!((0.4..0.8).contains(&rate), "{rate}");
    }

    /// The motion (q and dq/dt of all samples), the recurrence plots with their times, the number of warnings, and
    /// the summary.
    type Results = (Vec<f64>, Vec<(f64, Arc<RecurrenceImage>)>, usize, Summary);

    fn results(scene: &Scene, budget: AnalysisBudget) -> Results {
        let mut scene = scene.clone();
        scene.analysis.budget = budget;
        let mut records: Vec<Record> = Vec::new();
        let summary = run(&scene, "", &mut records, Monitor::default()).unwrap();
        let (mut motion, mut plots, mut warnings) = (Vec::new(), Vec::new(), 0);
        for record in records {
            match record {
                Record::Samples(frame) => motion.extend([&frame.q[..], &frame.qdot].concat()),
                Record::Recurrence { time, image } => plots.push((time, image)),
                Record::Warning { .. } => warnings += 1,
                _ => {}
            }
        }
        (motion, plots, warnings, summary)
    }

    /// A plot of 600 states every half millisecond takes several times longer than the simulated time.
    #[test]
    fn a_budget_changes_the_number_of_windows_and_nothing_else() {
        let mut scene = Scene::load("doubled-torus-3deg").unwrap();
        scene = scene.with_duration(150.0).unwrap();
        let mut recurrence = scene.analysis.recurrence.unwrap();
        (recurrence.size, recurrence.every) = (600, 0.5e-3);
        scene.analysis = AnalysisSpec {
            recurrence: Some(recurrence),
            ..AnalysisSpec::default()
        };
        let (motion, plots, warnings, summary) = results(&scene, AnalysisBudget::Complete);
        assert_eq!((warnings, summary.analysis_rate), (0, None));
        let (same, fewer, changes, limited) = results(&scene, AnalysisBudget::Realtime);
        assert!(motion == same, "the motion depends on the budget");
        assert_eq!(
            (summary.stats, summary.lines),
            (limited.stats, limited.lines)
        );
        assert!(
            changes > 0 && 4 * fewer.len() < 3 * plots.len(),
            "{}",
            fewer.len()
        );
        let rate = limited.analysis_rate.unwrap();
        assert!((0.1..0.9).contains(&rate), "{rate}");
        assert!(fewer.iter().all(|plot| plots.contains(plot)));
    }
}
