//! How the run is doing, from the frames that pass.

use super::message::{Frame, Health, Summary};
use super::prepare::FLOOR;
use crate::dynamics::Tally;

/// Turns the frames' running totals into rates.
#[derive(Debug, Default)]
pub(super) struct HealthMeter {
    tally: Tally,
    busy_seconds: f64,
    /// Time covered so far, s.
    covered: f64,
    /// `None` before a frame has told energies after the start.
    audit: Option<f64>,
    /// The largest energy, and so the scale of the audit, J.
    turnover: f64,
}

impl HealthMeter {
    /// The rates over `frame`.
    pub fn measure(
        &mut self,
        frame: &Frame,
        frames_waiting: usize,
        records_waiting: usize,
        drops: u64,
    ) -> Health {
        let span = frame.end() - frame.t0;
        let per_ms = |now: u64, before: u64| (now - before) as f64 / (1e3 * span);
        for sample in &frame.energy {
            self.turnover = self
                .turnover
                .max(sample.total)
                .max(sample.friction_work.abs());
        }
        // Work is followed to a share of itself and the floor together, and so it is audited: a motion
        // below the floor is made of rounding, which no friction has brought in.
        let scale = self.turnover + FLOOR;
        // At the start, from which the energy is counted, there is nothing to miss.
        let later = frame.energy.iter().filter(|sample| sample.time > 0.0);
        let residuals = later.map(|sample| sample.residual.abs() / scale);
        // Energies that have left the numbers, of a state that has not yet, miss everything.
        let told = residuals.map(|share| if share.is_nan() { f64::INFINITY } else { share });
        self.audit = told.reduce(f64::max).or(self.audit);
        let health = Health {
            time: frame.end(),
            real_time_factor: factor(span, frame.busy_seconds - self.busy_seconds),
            error: frame.error,
            steps_per_ms: per_ms(frame.tally.steps, self.tally.steps),
            rejections_per_ms: per_ms(frame.tally.rejections, self.tally.rejections),
            calls_per_ms: per_ms(frame.tally.calls, self.tally.calls),
            events_per_ms: per_ms(frame.transitions, 0),
            frames_waiting,
            records_waiting,
            drops,
            audit: self.audit,
        };
        self.tally = frame.tally;
        self.busy_seconds = frame.busy_seconds;
        self.covered += span;
        health
    }

    /// Adds to the summary of a run how it did; what it came to is the analyses' to say.
    pub fn conclude(&self, summary: &mut Summary) {
        summary.real_time_factor = factor(self.covered, self.busy_seconds);
        summary.audit = self.audit;
    }
}

/// Time over what it took; 0 where nothing was simulated.
fn factor(time: f64, busy: f64) -> f64 {
    if busy > 0.0 { time / busy } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::ErrorEstimate;
    use crate::pipeline::message::{EnergySample, Record};
    use crate::pipeline::{Monitor, run};
    use crate::scene::Scene;

    /// Squares overflow long before the state does.
    #[test]
    fn energies_beyond_the_numbers_fail_the_audit() {
        let frame = Frame {
            energy: vec![EnergySample {
                time: 1e-3,
                total: f64::INFINITY,
                residual: f64::INFINITY,
                ..EnergySample::default()
            }],
            ..Frame::default()
        };
        let health = HealthMeter::default().measure(&frame, 0, 0, 0);
        assert_eq!(health.audit, Some(f64::INFINITY));
    }

    /// What a kick of 1e-60 m/s becomes is rounding, and no fault of the motion.
    #[test]
    fn energies_below_the_floor_pass_the_audit() {
        let frame = Frame {
            energy: vec![EnergySample {
                time: 1e-3,
                total: 1e-30,
                residual: 1e-30,
                ..EnergySample::default()
            }],
            ..Frame::default()
        };
        let health = HealthMeter::default().measure(&frame, 0, 0, 0);
        assert!(health.audit.unwrap() < 1e-12);
    }

    /// At the start nothing can be missing: that is no audit yet.
    #[test]
    fn the_start_alone_is_not_audited() {
        let at = |time: f64, residual| Frame {
            energy: vec![EnergySample {
                time,
                total: 1.0,
                residual,
                ..EnergySample::default()
            }],
            ..Frame::default()
        };
        let mut meter = HealthMeter::default();
        assert_eq!(meter.measure(&at(0.0, 0.0), 0, 0, 0).audit, None);
        let mut summary = Summary::default();
        meter.conclude(&mut summary);
        assert_eq!(summary.audit, None);
        let audit = meter.measure(&at(1e-3, 0.25), 0, 0, 0).audit;
        assert!((audit.unwrap() - 0.25).abs() < 1e-9);
        assert_eq!(meter.measure(&Frame::default(), 0, 0, 0).audit, audit);
    }

    #[test]
    fn rates_are_those_of_a_frame_and_the_error_is_its_own() {
        let frame = |t0: f64, calls, busy_seconds, ratio| Frame {
            t0,
            dt: 1e-3,
            displacement: vec![0.0; 2],
            tally: Tally {
                calls,
                ..Tally::default()
            },
            error: Some(ErrorEstimate {
                ratio,
                tolerance: 1e-5,
            }),
            busy_seconds,
            ..Frame::default()
        };
        let mut meter = HealthMeter::default();
        meter.measure(&frame(0.0, 500, 1e-3, 0.9), 0, 0, 0);
        let health = meter.measure(&frame(2e-3, 2500, 2e-3, 0.4), 0, 0, 0);
        assert!((health.calls_per_ms - 1000.0).abs() < 1e-9);
        assert!((health.real_time_factor - 2.0).abs() < 1e-9);
        assert_eq!(health.error.map(|error| error.ratio), Some(0.4));
    }

    /// The first frame with everything that leads to it, each later one with its own steps.
    #[test]
    fn every_frame_of_a_run_tells_its_local_error() {
        let scene = Scene::load("torus-3deg").unwrap();
        let scene = scene.with_duration(8.0).unwrap();
        let mut records: Vec<Record> = Vec::new();
        run(&scene, "test", &mut records, Monitor::default()).unwrap();
        let errors = records.iter().filter_map(|record| match record {
            Record::Health(health) => Some(health.error.expect("steps with an estimate")),
            _ => None,
        });
        let errors: Vec<ErrorEstimate> = errors.collect();
        assert!(errors.len() > 4, "{}", errors.len());
        for error in errors {
            assert_eq!(error.tolerance, scene.integrator.tolerance);
            assert!(error.ratio > 0.0 && error.ratio <= 1.0, "{error:?}");
        }
    }
}
