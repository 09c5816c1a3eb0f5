//! Divergence of the perturbed trajectory.
//!
//! The rate is the slope of a straight line fitted to the logarithm of the distance, in the range where the
//! flow dominates: above the effect of step errors ([`PerturbedSamples::floor`]) and below a tenth of the motion.
//! Each time the distance falls below the floor, the fit restarts.
//!
//! [`PerturbedSamples::floor`]: crate::pipeline::message::PerturbedSamples::floor

use super::stage::{Stage, samples};
use crate::analysis::stats::LineFit;
use crate::pipeline::message::{DivergenceFit, Observation, Record, TrajectoryDivergence};
use crate::scene::PerturbedTrajectorySpec;

/// Distance relative to the norm of the motion at which exponential growth ends.
const SATURATED: f64 = 0.1;

/// Emits [`Record::TrajectoryDivergence`] at regular intervals, and [`Record::Narration`] once the distance is saturated.
/// `rate` is the sample rate, Hz.
pub fn divergence(spec: PerturbedTrajectorySpec, rate: f64) -> Stage {
    let every = samples(spec.every, rate, 1);
    // Sum of the squared distances since the last record, and their number.
    let (mut squares, mut count) = (0.0, 0);
    // Start time of the perturbed trajectory, and the time of its saturation, s.
    let (mut start, mut saturated) = (None, None);
    let mut line = LineFit::default();
    Box::new(move |frame, context| {
        let Some(perturbed) = &frame.perturbed else {
            return Ok(());
        };
        let first = frame.len() - perturbed.distance.len();
        for (k, distance) in perturbed.distance.iter().enumerate() {
            let time_s = frame.time(first + k);
            let start_s = *start.get_or_insert(time_s);
            squares += distance * distance;
            count += 1;
            if count < every {
                continue;
            }
            let distance = (squares / count as f64).sqrt();
            (squares, count) = (0.0, 0);
            let before = saturated;
            if distance >= SATURATED {
                saturated.get_or_insert(time_s);
            }
            if saturated.is_none() {
                // The distance is zero for a joint at rest.
                if distance > perturbed.floor {
                    line.push(time_s - start_s, distance.ln());
                } else {
                    line.clear();
                }
            }
            let divergence = TrajectoryDivergence {
                time_s,
                start_s,
                distance,
                line: line.fit().map(|fit| DivergenceFit {
                    rate_per_s: fit.slope,
                    half_width_per_s: fit.half_width,
                    since_s: start_s + fit.from,
                    intercept: fit.intercept,
                }),
                saturated_s: saturated,
            };
            let records = &mut context.records;
            records.push(Record::TrajectoryDivergence(divergence));
            if let (None, Some(saturated)) = (before, saturated) {
                let line = divergence.line.filter(DivergenceFit::grows);
                let observation = Observation::Separated {
                    initial_distance: spec.distance,
                    after: saturated - start_s,
                    e_fold_time: line.map(|line| 1.0 / line.rate_per_s),
                };
                let time = time_s;
                records.push(Record::Narration { time, observation });
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::super::stage::Context;
    use super::*;
    use crate::pipeline::message::{Frame, PerturbedSamples};

    const RATE: f64 = 1e5;
    const SPEC: PerturbedTrajectorySpec = PerturbedTrajectorySpec {
        start: 1e-3,
        distance: 1e-6,
        every: 1e-3,
    };

    /// Records for distances from the sample `first` on, at a sample rate (Hz), in frames of `frame` samples.
    fn recorded(
        distances: &[f64],
        [first, frame]: [usize; 2],
        rate: f64,
        floor: f64,
    ) -> Vec<Record> {
        let mut stage = super::divergence(SPEC, rate);
        let mut context = Context::new(rate);
        for begin in (0..first + distances.len()).step_by(frame) {
            let samples = first.max(begin)..begin + frame;
            let distance: Vec<f64> = samples.map(|k| distances[k - first]).collect();
            let frame = Frame {
                t0: begin as f64 / rate,
                dt: 1.0 / rate,
                displacement: vec![0.0; frame],
                perturbed: Some(PerturbedSamples {
                    displacement: vec![0.0; distance.len()],
                    velocity: vec![0.0; distance.len()],
                    distance,
                    floor,
                }),
                ..Frame::default()
            };
            stage(&frame, &mut context).unwrap();
        }
        context.records
    }

    /// Records for a distance that grows at a rate (1/s) until it is 1, in frames of the given number of
    /// samples.
    fn divergence(rate: f64, frame: usize) -> Vec<Record> {
        let first = (SPEC.start * RATE) as usize;
        let distances = (0..30_000 - first).map(|k| {
            let since = k as f64 / RATE;
            (SPEC.distance * (rate * since).exp()).min(1.0)
        });
        recorded(&distances.collect::<Vec<_>>(), [first, frame], RATE, 1e-9)
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
        let distance = |k: i32| match k {
            0..10 => 1e-6,
            _ => 1e-5 * (40.0 * (1e-3 * f64::from(k) - 0.01)).exp(),
        };
        let distances: Vec<f64> = (0..200).map(distance).collect();
        let line = last(&recorded(&distances, [0, 10], 1e3, 1e-4)).line;
        let line = line.unwrap();
        assert!((line.rate_per_s - 40.0).abs() < 1e-6, "{line:?}");
        assert!(line.grows() && line.half_width_per_s < 1e-6, "{line:?}");
        // exp(40 t) = 10 after 57.6 ms.
        assert!((line.since_s - 0.068).abs() < 1e-9, "{line:?}");
        // If the distance never exceeds the floor, there is no fit.
        let records = recorded(&[1e-5; 200], [0, 10], 1e3, 1e-4);
        assert!(records.iter().all(|record| match record {
            Record::TrajectoryDivergence(divergence) => divergence.line.is_none(),
            _ => false,
        }));
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
