//! Performance and accuracy of a run, from its frames.

use super::message::{Frame, Health, Summary};
use super::prepare::FLOOR;
use crate::dynamics::SolverStats;

/// Converts the cumulative counters of the frames into rates.
#[derive(Debug, Default)]
pub(super) struct HealthMeter {
    stats: SolverStats,
    busy_seconds: f64,
    /// Largest relative residual in the last frame with energy samples; `None` before the first one after the
    /// start.
    audit: Option<f64>,
    /// Largest energy so far, the scale of the audit, J.
    energy_scale: f64,
}

impl HealthMeter {
    /// Rates over `frame`.
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
            let energies = [sample.total, sample.friction_work.abs()];
            self.energy_scale = energies.into_iter().fold(self.energy_scale, f64::max);
        }
        // The work of friction has a relative tolerance plus the absolute tolerance FLOOR, and the audit uses
        // the same scale: an energy below the floor is rounding noise, which friction has not supplied.
        let scale = self.energy_scale + FLOOR;
        // At the start, where energies are zero by definition, the residual is zero, too.
        let later = frame.energy.iter().filter(|sample| sample.time > 0.0);
        let residuals = later.map(|sample| sample.residual.abs() / scale);
        // If the energies overflow before the state does, the audit fails.
        let shares = residuals.map(|share| if share.is_nan() { f64::INFINITY } else { share });
        self.audit = shares.reduce(f64::max).or(self.audit);
        let health = Health {
            time: frame.end(),
            real_time_factor: factor(span, frame.busy_seconds - self.busy_seconds),
            error: frame.error,
            steps_per_ms: per_ms(frame.stats.steps, self.stats.steps),
            rejections_per_ms: per_ms(frame.stats.rejections, self.stats.rejections),
            rhs_evals_per_ms: per_ms(frame.stats.rhs_evals, self.stats.rhs_evals),
            events_per_ms: per_ms(frame.transitions, 0),
            frames_waiting,
            records_waiting,
            drops,
            audit: self.audit,
        };
        self.stats = frame.stats;
        self.busy_seconds = frame.busy_seconds;
        health
    }

    /// Adds performance and accuracy to the summary of a run. The analyses add the results.
    pub fn complete_summary(&self, summary: &mut Summary) {
        summary.real_time_factor = factor(summary.simulated_s, self.busy_seconds);
        summary.energy_residual = self.audit;
    }
}

/// Simulated time over computing time; 0 if nothing was simulated.
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
    fn infinite_energies_fail_the_audit() {
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

    /// The motion after a kick of 1e-60 m/s is rounding noise and must not fail the audit.
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

    /// The residual at the start is zero by definition and does not count as an audit.
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
        meter.complete_summary(&mut summary);
        assert_eq!(summary.energy_residual, None);
        let audit = meter.measure(&at(1e-3, 0.25), 0, 0, 0).audit;
        assert!((audit.unwrap() - 0.25).abs() < 1e-9);
        assert_eq!(meter.measure(&Frame::default(), 0, 0, 0).audit, audit);
    }

    #[test]
    fn rates_and_error_are_those_of_the_frame() {
        let frame = |t0: f64, calls, busy_seconds, ratio| Frame {
            t0,
            dt: 1e-3,
            displacement: vec![0.0; 2],
            stats: SolverStats {
                rhs_evals: calls,
                ..SolverStats::default()
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
        assert!((health.rhs_evals_per_ms - 1000.0).abs() < 1e-9);
        assert!((health.real_time_factor - 2.0).abs() < 1e-9);
        assert_eq!(health.error.map(|error| error.ratio), Some(0.4));
    }

    /// The first frame includes the steps that lead to it; each later frame has its own steps.
    #[test]
    fn every_frame_of_a_run_has_its_local_error() {
        let scene = Scene::load("doubled-torus-3deg").unwrap();
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
