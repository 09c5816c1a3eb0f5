//! How two copies of the joint part that started almost in the same state.
//!
//! The rate is the slope of a straight line through the logarithm of the distance, where the flow
//! alone rules it: above what the errors of the steps make of it ([`TwinSamples::floor`]), and below
//! a tenth of the motion. Whenever the distance has been below the floor, the line begins anew.
//!
//! [`TwinSamples::floor`]: crate::pipeline::message::TwinSamples::floor

use super::clock::samples;
use super::stage::{Context, Emit, Stage};
use crate::analysis::LineFit;
use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::{Frame, Observation, Parting, PartingLine, Record, Summary};
use crate::scene::ButterflySpec;

/// Distance, relative to the motion's size, from which on it no longer grows as it did: the straight
/// part of its logarithm ends here.
const SATURATED: f64 = 0.1;

/// Emits [`Record::Parting`] time and again, and [`Record::Narration`] when the distance has
/// become as large as the motion.
pub struct ButterflyStage {
    /// Samples from one record to the next.
    every: usize,
    spec: ButterflySpec,
    /// Squares of the distances since the last record, and how many they are.
    squares: f64,
    count: usize,
    /// Time of the first sample of the second copy, s.
    start: Option<f64>,
    saturated: Option<f64>,
    line: LineFit,
    last: Option<Parting>,
}

impl ButterflyStage {
    /// For samples at `rate` (Hz).
    pub fn new(spec: ButterflySpec, rate: f64) -> Self {
        Self {
            every: samples(spec.every, rate, 1),
            spec,
            squares: 0.0,
            count: 0,
            start: None,
            saturated: None,
            line: LineFit::default(),
            last: None,
        }
    }

    /// Concludes the distances up to a time (s).
    fn conclude(&mut self, start: f64, time: f64, floor: f64) -> Parting {
        let distance = (self.squares / self.count as f64).sqrt();
        (self.squares, self.count) = (0.0, 0);
        if distance >= SATURATED {
            self.saturated.get_or_insert(time);
        }
        if self.saturated.is_none() {
            // Two copies of a joint at rest are never apart: that is below any floor.
            if distance > floor {
                self.line.push(time - start, distance.ln());
            } else {
                self.line.clear();
            }
        }
        let parting = Parting {
            time,
            start,
            distance,
            line: self.line.fit().map(|fit| PartingLine {
                rate: fit.slope,
                half_width: fit.half_width,
                since: start + fit.from,
                intercept: fit.intercept,
            }),
            saturated: self.saturated,
        };
        self.last = Some(parting);
        parting
    }
}

impl Stage for ButterflyStage {
    fn push(
        &mut self,
        frame: &Frame,
        _context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let Some(twin) = &frame.twin else {
            return Ok(());
        };
        for (k, distance) in twin.distance.iter().enumerate() {
            let time = frame.time(twin.first + k);
            let start = *self.start.get_or_insert(time);
            self.squares += distance * distance;
            self.count += 1;
            if self.count < self.every {
                continue;
            }
            let before = self.saturated;
            let parting = self.conclude(start, time, twin.floor);
            emit(Record::Parting(parting))?;
            if before.is_none() && parting.saturated.is_some() {
                let line = parting.line.filter(PartingLine::grows);
                let observation = Observation::Separated {
                    initial_distance: self.spec.distance,
                    after: parting.saturated.unwrap_or(parting.time) - parting.start,
                    e_fold_time: line.map(|line| 1.0 / line.rate),
                };
                emit(Record::Narration { time, observation })?;
            }
        }
        Ok(())
    }

    fn summarise(&self, summary: &mut Summary) {
        summary.parting = self.last;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::message::TwinSamples;

    const RATE: f64 = 1e5;
    const FLOOR: f64 = 1e-9;
    const SPEC: ButterflySpec = ButterflySpec {
        start: 1e-3,
        distance: 1e-6,
        every: 1e-3,
    };

    /// Distances that grow at a rate (1/s) from the start on until they are 1, in frames of so many
    /// samples.
    fn parting(rate: f64, frame: usize) -> Vec<Record> {
        let first = (SPEC.start * RATE) as usize;
        let mut stage = ButterflyStage::new(SPEC, RATE);
        let mut context = Context::new(RATE);
        let mut records = Vec::new();
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
                twin: Some(TwinSamples {
                    first: samples.start - begin,
                    displacement: vec![0.0; distance.len()],
                    velocity: vec![0.0; distance.len()],
                    distance,
                    floor: FLOOR,
                }),
                ..Frame::default()
            };
            let mut emit = |record| {
                records.push(record);
                Ok(())
            };
            stage.push(&frame, &mut context, &mut emit).unwrap();
        }
        records
    }

    fn last(records: &[Record]) -> Parting {
        let parting = records.iter().rev().find_map(|record| match record {
            Record::Parting(parting) => Some(*parting),
            _ => None,
        });
        parting.unwrap()
    }

    #[test]
    fn the_slope_is_the_rate_until_it_is_saturated() {
        let records = parting(80.0, 200);
        let end = last(&records);
        let line = end.line.unwrap();
        assert!((line.rate - 80.0).abs() < 1e-6, "{}", line.rate);
        assert_eq!(end.start, SPEC.start);
        // exp(80 t) = 1e5 after 143.9 ms, seen at the end of that record or of the next one.
        let after = end.saturated.unwrap() - SPEC.start;
        assert!(
            (0.1439..0.1439 + 2.0 * SPEC.every).contains(&after),
            "{after}"
        );
        let said = records.iter().filter_map(|record| match record {
            Record::Narration { observation, .. } => Some(observation),
            _ => None,
        });
        assert_eq!(said.count(), 1);
    }

    /// A jump to 1e-5 by an error of a step, and from there on growth: the line has the growth alone.
    #[test]
    fn what_lies_below_the_floor_is_left_out() {
        let mut stage = ButterflyStage::new(SPEC, RATE);
        let mut last = None;
        for k in 0..200 {
            let time = 1e-3 * f64::from(k);
            let (distance, floor) = match k {
                0..10 => (1e-6, 1e-4),
                _ => (1e-5 * (40.0 * (time - 0.01)).exp(), 1e-4),
            };
            (stage.squares, stage.count) = (distance * distance, 1);
            last = Some(stage.conclude(0.0, time, floor));
        }
        let line = last.unwrap().line.unwrap();
        assert!((line.rate - 40.0).abs() < 1e-6, "{line:?}");
        assert!(line.grows() && line.half_width < 1e-6, "{line:?}");
        // exp(40 t) = 10 after 57.6 ms.
        assert!((line.since - 0.068).abs() < 1e-9, "{line:?}");
        // Never above the floor, there is no line.
        let mut stage = ButterflyStage::new(SPEC, RATE);
        for k in 0..200 {
            (stage.squares, stage.count) = (1e-10, 1);
            assert_eq!(stage.conclude(0.0, 1e-3 * f64::from(k), 1e-4).line, None);
        }
    }

    #[test]
    fn copies_that_stay_together_are_never_saturated() {
        let records = parting(-3.0, 200);
        let end = last(&records);
        assert!((end.line.unwrap().rate + 3.0).abs() < 1e-6);
        assert_eq!(end.saturated, None);
        assert!(records.iter().all(|r| matches!(r, Record::Parting(_))));
    }

    #[test]
    fn frames_do_not_matter() {
        let all = |frame| -> Vec<Parting> {
            let records = parting(40.0, frame).into_iter();
            let partings = records.filter_map(|record| match record {
                Record::Parting(parting) => Some(parting),
                _ => None,
            });
            partings.collect()
        };
        let (short, long) = (all(200), all(1000));
        assert_eq!(short.len(), long.len());
        for (a, b) in short.iter().zip(&long) {
            // A sample's time is counted from its frame's start, and rounded there.
            assert!((a.time - b.time).abs() < 1e-15, "{a:?} {b:?}");
            assert!((a.distance / b.distance - 1.0).abs() < 1e-12, "{a:?} {b:?}");
            assert_eq!(a.saturated.is_some(), b.saturated.is_some());
        }
    }
}
