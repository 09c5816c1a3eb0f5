//! Budget of the analyses: fewer windows while they are slower than real time.

use super::message::Record;
use crate::scene::AnalysisBudget;

/// Simulated time over which the load is measured, s: several windows of each analysis.
const INTERVAL: f64 = 40e-3;

/// Largest divisor of the rate.
const MAX_DIVISOR: u64 = 16;

/// Load below which the rate is doubled; the load is then still below 1.
const LOW_LOAD: f64 = 0.4;

/// Measures the time that the analyses take, and sets the divisor of their rate: of the windows that a scene
/// requests, every `divisor`-th is computed.
#[derive(Debug)]
pub(super) struct Budget {
    kind: AnalysisBudget,
    divisor: u64,
    /// Simulated time and computing time since the last decision, s.
    simulated: f64,
    busy: f64,
    /// Simulated time so far, and the same weighted with the rate, s.
    total: f64,
    weighted: f64,
}

impl Budget {
    pub fn new(kind: AnalysisBudget) -> Self {
        Self {
            kind,
            divisor: 1,
            simulated: 0.0,
            busy: 0.0,
            total: 0.0,
            weighted: 0.0,
        }
    }

    /// The present divisor.
    pub fn divisor(&self) -> u64 {
        self.divisor
    }

    /// Adds a frame of `simulated` seconds that ends at `time` (s) and whose analyses took `busy` seconds.
    /// Returns a warning if the divisor changes.
    pub fn follow(&mut self, time: f64, simulated: f64, busy: f64) -> Option<Record> {
        if self.kind == AnalysisBudget::Complete {
            return None;
        }
        self.total += simulated;
        self.weighted += simulated / self.divisor as f64;
        self.simulated += simulated;
        self.busy += busy;
        if self.simulated < INTERVAL {
            return None;
        }
        let load = self.busy / self.simulated;
        (self.simulated, self.busy) = (0.0, 0.0);
        let divisor = match load {
            1.0.. => MAX_DIVISOR.min(2 * self.divisor),
            ..LOW_LOAD => (self.divisor / 2).max(1),
            _ => self.divisor,
        };
        let changed = std::mem::replace(&mut self.divisor, divisor) != divisor;
        let windows = match divisor {
            1 => "all windows are".to_owned(),
            _ => format!("1 of {divisor} windows is"),
        };
        changed.then(|| Record::Warning {
            time,
            text: format!(
                "the analyses took {load:.2} s per simulated second: {windows} computed from {:.0} ms on",
                1e3 * time
            ),
        })
    }

    /// Mean rate of the analyses over the rate of the scene; `None` if every window is computed.
    pub fn rate(&self) -> Option<f64> {
        let limited = self.kind == AnalysisBudget::Realtime && self.total > 0.0;
        limited.then(|| self.weighted / self.total)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Follows frames of 10 ms whose full analyses take `load` times as long.
    fn follow(budget: &mut Budget, loads: &[f64]) -> Vec<u64> {
        let divisor = |(k, load): (usize, &f64)| {
            let busy = 10e-3 * load / budget.divisor() as f64;
            budget.follow(10e-3 * (k + 1) as f64, 10e-3, busy);
            budget.divisor()
        };
        loads.iter().enumerate().map(divisor).collect()
    }

    #[test]
    fn the_rate_falls_until_the_analyses_keep_up_and_recovers() {
        let mut budget = Budget::new(AnalysisBudget::Realtime);
        let slow = follow(&mut budget, &[3.0; 16]);
        assert_eq!((slow[2], slow[4], slow[15]), (1, 2, 4));
        let fast = follow(&mut budget, &[0.3; 16]);
        assert_eq!(fast[15], 1);
        let rate = budget.rate().unwrap();
        assert!((0.4..0.8).contains(&rate), "{rate}");
    }

    #[test]
    fn without_a_budget_every_window_is_computed() {
        let mut budget = Budget::new(AnalysisBudget::Complete);
        assert_eq!(follow(&mut budget, &[9.0; 16]), [1; 16]);
        assert_eq!(budget.rate(), None);
    }
}
