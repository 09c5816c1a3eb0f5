//! Divergence of the perturbed trajectory.
//!
//! The rate is the slope of a straight line fitted to the logarithm of the distance, in the range where the
//! flow dominates: above the effect of step errors ([`PerturbedSamples::floor`]) and below a tenth of the motion.
//! Each time the distance falls below the floor, the fit restarts.
//!
//! [`PerturbedSamples::floor`]: crate::pipeline::message::PerturbedSamples::floor

use super::stage::{Context, Stage, samples};
use crate::analysis::stats::LineFit;
use crate::pipeline::message::{DivergenceFit, Frame, Observation, Record, TrajectoryDivergence};
use crate::scene::PerturbedTrajectorySpec;

/// Distance relative to the norm of the motion at which exponential growth ends.
const SATURATED: f64 = 0.1;

/// The stage of the perturbed trajectory, for samples at `rate` (Hz).
pub fn divergence(spec: PerturbedTrajectorySpec, rate: f64) -> Stage {
    let mut stage = DivergenceStage::new(spec, rate);
    Box::new(move |frame, context| {
        stage.push(frame, context);
        Ok(())
    })
}

/// Emits [`Record::TrajectoryDivergence`] at regular intervals, and [`Record::Narration`] once the distance is saturated.
struct DivergenceStage {
    /// Number of samples between two records.
    every: usize,
    spec: PerturbedTrajectorySpec,
    /// Sum of the squared distances since the last record, and their number.
    squares: f64,
    count: usize,
    /// Start time of the perturbed trajectory, s.
    start: Option<f64>,
    saturated: Option<f64>,
    line: LineFit,
}

impl DivergenceStage {
    /// Sets up the stage for samples at `rate` (Hz).
    fn new(spec: PerturbedTrajectorySpec, rate: f64) -> Self {
        Self {
            every: samples(spec.every, rate, 1),
            spec,
            squares: 0.0,
            count: 0,
            start: None,
            saturated: None,
            line: LineFit::default(),
        }
    }

    /// Evaluates the distances up to a time (s).
    fn evaluate(&mut self, start: f64, time: f64, floor: f64) -> TrajectoryDivergence {
        let distance = (self.squares / self.count as f64).sqrt();
        (self.squares, self.count) = (0.0, 0);
        if distance >= SATURATED {
            self.saturated.get_or_insert(time);
        }
        if self.saturated.is_none() {
            // The distance is zero for a joint at rest.
            if distance > floor {
                self.line.push(time - start, distance.ln());
            } else {
                self.line.clear();
            }
        }
        TrajectoryDivergence {
            time_s: time,
            start_s: start,
            distance,
            line: self.line.fit().map(|fit| DivergenceFit {
                rate_per_s: fit.slope,
                half_width_per_s: fit.half_width,
                since_s: start + fit.from,
                intercept: fit.intercept,
            }),
            saturated_s: self.saturated,
        }
    }

    /// Processes the next frame.
    fn push(&mut self, frame: &Frame, context: &mut Context) {
        let Some(perturbed) = &frame.perturbed else {
            return;
        };
        let first = frame.len() - perturbed.distance.len();
        for (k, distance) in perturbed.distance.iter().enumerate() {
            let time = frame.time(first + k);
            let start = *self.start.get_or_insert(time);
            self.squares += distance * distance;
            self.count += 1;
            if self.count < self.every {
                continue;
            }
            let before = self.saturated;
            let divergence = self.evaluate(start, time, perturbed.floor);
            context
                .records
                .push(Record::TrajectoryDivergence(divergence));
            if let (None, Some(saturated)) = (before, divergence.saturated_s) {
                let line = divergence.line.filter(DivergenceFit::grows);
                let observation = Observation::Separated {
                    initial_distance: self.spec.distance,
                    after: saturated - start,
                    e_fold_time: line.map(|line| 1.0 / line.rate_per_s),
                };
                context
                    .records
                    .push(Record::Narration { time, observation });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::message::PerturbedSamples;

    const RATE: f64 = 1e5;
    const FLOOR: f64 = 1e-9;
    const SPEC: PerturbedTrajectorySpec = PerturbedTrajectorySpec {
        start: 1e-3,
        distance: 1e-6,
        every: 1e-3,
    };

    /// Records for a distance that grows at a rate (1/s) until it is 1, in frames of the given number of
    /// samples.
    fn divergence(rate: f64, frame: usize) -> Vec<Record> {
        let first = (SPEC.start * RATE) as usize;
        let mut stage = DivergenceStage::new(SPEC, RATE);
        let mut context = Context::new(RATE);
        for begin in (0..30_000).step_by(frame) {
            let samples = first.max(begin)..begin + frame;
            let distance = samples.clone().map(|k| {
                let since = (k - first) as f64 / RATE;
                (SPEC.distance * (rate * since).exp()).min(1.0)
            });
            let distance: Vec<f64> = distance.collect();
            let frame = Frame {
                t0: begin as f64 / RATE,
                dt: 1.0 / RATE,
                displacement: vec![0.0; frame],
                perturbed: Some(PerturbedSamples {
                    displacement: vec![0.0; distance.len()],
                    velocity: vec![0.0; distance.len()],
                    distance,
                    floor: FLOOR,
                }),
                ..Frame::default()
            };
            stage.push(&frame, &mut context);
        }
        context.records
    }

    fn last(records: &[Record]) -> TrajectoryDivergence {
        let divergence = records.iter().rev().find_map(|record| match record {
            Record::TrajectoryDivergence(divergence) => Some(*divergence),
            _ => None,
        });
        divergence.unwrap()
    }

    #[test]
    fn the_slope_is_the_rate_until_saturation() {
        let records = divergence(80.0, 200);
        let end = last(&records);
        let line = end.line.unwrap();
        assert!((line.rate_per_s - 80.0).abs() < 1e-6, "{}", line.rate_per_s);
        assert_eq!(end.start_s, SPEC.start);
        // exp(80 t) = 1e5 after 143.9 ms, reported at the end of the present or the next interval.
        let after = end.saturated_s.unwrap() - SPEC.start;
        assert!(
            (0.1439..0.1439 + 2.0 * SPEC.every).contains(&after),
            "{after}"
        );
        let narrations = records.iter().filter_map(|record| match record {
            Record::Narration { observation, .. } => Some(observation),
            _ => None,
        });
        assert_eq!(narrations.count(), 1);
    }

    /// The distance jumps to 1e-5 by a step error and then grows: only the growth enters the fit.
    #[test]
    fn distances_below_the_floor_are_excluded() {
        let mut stage = DivergenceStage::new(SPEC, RATE);
        let mut last = None;
        for k in 0..200 {
            let time = 1e-3 * f64::from(k);
            let (distance, floor) = match k {
                0..10 => (1e-6, 1e-4),
                _ => (1e-5 * (40.0 * (time - 0.01)).exp(), 1e-4),
            };
            (stage.squares, stage.count) = (distance * distance, 1);
            last = Some(stage.evaluate(0.0, time, floor));
        }
        let line = last.unwrap().line.unwrap();
        assert!((line.rate_per_s - 40.0).abs() < 1e-6, "{line:?}");
        assert!(line.grows() && line.half_width_per_s < 1e-6, "{line:?}");
        // exp(40 t) = 10 after 57.6 ms.
        assert!((line.since_s - 0.068).abs() < 1e-9, "{line:?}");
        // If the distance never exceeds the floor, there is no fit.
        let mut stage = DivergenceStage::new(SPEC, RATE);
        for k in 0..200 {
            (stage.squares, stage.count) = (1e-10, 1);
            assert_eq!(stage.evaluate(0.0, 1e-3 * f64::from(k), 1e-4).line, None);
        }
    }

    #[test]
    fn trajectories_that_stay_close_are_never_saturated() {
        let records = divergence(-3.0, 200);
        let end = last(&records);
        assert!((end.line.unwrap().rate_per_s + 3.0).abs() < 1e-6);
        assert_eq!(end.saturated_s, None);
        assert!(
            records
                .iter()
                .all(|r| matches!(r, Record::TrajectoryDivergence(_)))
        );
    }

    #[test]
    fn the_result_does_not_depend_on_the_frames() {
        let all = |frame| -> Vec<TrajectoryDivergence> {
            let records = divergence(40.0, frame).into_iter();
            let partings = records.filter_map(|record| match record {
                Record::TrajectoryDivergence(divergence) => Some(divergence),
                _ => None,
            });
            partings.collect()
        };
        let (short, long) = (all(200), all(1000));
        assert_eq!(short.len(), long.len());
        for (a, b) in short.iter().zip(&long) {
            // Sample times are relative to the start of their frame, and rounded there.
            assert!((a.time_s - b.time_s).abs() < 1e-15, "{a:?} {b:?}");
            assert!((a.distance / b.distance - 1.0).abs() < 1e-12, "{a:?} {b:?}");
            assert_eq!(a.saturated_s.is_some(), b.saturated_s.is_some());
        }
    }
}
