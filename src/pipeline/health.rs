//! How the run is doing, from the frames that pass.

use super::message::{Frame, Health, Summary};
use crate::dynamics::Tally;

/// Turns the frames' running totals into rates.
#[derive(Debug, Default)]
pub(super) struct HealthMeter {
    tally: Tally,
    busy_seconds: f64,
    /// Time covered so far, s.
    covered: f64,
    /// `None` before a frame has told energies.
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
        // A joint at rest has turned over nothing, and misses nothing.
        let scale = self.turnover.max(f64::MIN_POSITIVE);
        if !frame.energy.is_empty() {
            let residuals = frame.energy.iter().map(|s| s.residual.abs() / scale);
            // Energies that have left the numbers, of a state that has not yet, miss everything.
            let told = residuals.map(|share| if share.is_nan() { f64::INFINITY } else { share });
            self.audit = Some(told.fold(0.0, f64::max));
        }
        let health = Health {
            time: frame.end(),
            real_time_factor: factor(span, frame.busy_seconds - self.busy_seconds),
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
        summary.audit = self.audit.unwrap_or(0.0);
    }
}

/// Time over what it took; 0 where nothing was simulated.
fn factor(time: f64, busy: f64) -> f64 {
    if busy > 0.0 { time / busy } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::message::EnergySample;

    /// Squares overflow long before the state does.
    #[test]
    fn energies_beyond_the_numbers_fail_the_audit() {
        let frame = Frame {
            energy: vec![EnergySample {
                total: f64::INFINITY,
                residual: f64::INFINITY,
                ..EnergySample::default()
            }],
            ..Frame::default()
        };
        let health = HealthMeter::default().measure(&frame, 0, 0, 0);
        assert_eq!(health.audit, Some(f64::INFINITY));
    }
}
