//! How a viewer keeps up with what it is sent.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// How long a viewer may take to show what it was sent; until it has seen it all, the rest is left out.
const PATIENCE: Duration = Duration::from_millis(1500);
/// How long a viewer is waited for that has seen nothing more; then it is tried again.
const AT_REST: Duration = Duration::from_secs(10);

/// How far a viewer is behind what it was sent. One that says nothing of itself is taken to keep up.
#[derive(Debug, Default)]
pub struct Flow {
    /// When something was sent, and up to which simulated time it tells, s; oldest first.
    under_way: VecDeque<(Instant, f64)>,
    /// Simulated time of the newest that is to be sent, and that has been seen, s.
    newest: f64,
    seen: f64,
    /// Since when nothing is sent, or nothing more has been seen, until all that was sent has been.
    waits: Option<Instant>,
    speaks: bool,
}

impl Flow {
    /// Another recording begins.
    pub fn begin(&mut self) {
        *self = Self {
            speaks: self.speaks,
            ..Self::default()
        };
    }

    /// The next message has something of this time, s.
    pub fn tells(&mut self, until: Option<f64>) {
        self.newest = self.newest.max(until.unwrap_or(0.0));
    }

    pub fn sent(&mut self, now: Instant) {
        let last = self.under_way.back().map_or(self.seen, |(_, last)| *last);
        if self.speaks && self.newest > last {
            self.under_way.push_back((now, self.newest));
        }
    }

    pub fn saw(&mut self, now: Instant, time: f64) {
        self.speaks = true;
        if time != self.seen && self.waits.is_some() {
            self.waits = Some(now);
        }
        self.seen = time;
        // A nanosecond is lost where times are rounded.
        let is_seen = |(_, until): &(Instant, f64)| *until <= time + 1e-8;
        while self.under_way.front().is_some_and(is_seen) {
            self.under_way.pop_front();
        }
        if self.under_way.is_empty() {
            self.waits = None;
        }
    }

    pub fn is_behind(&mut self, now: Instant) -> bool {
        let late = |(sent, _): &(Instant, f64)| now > *sent + PATIENCE;
        match self.waits {
            Some(since) if now > since + AT_REST => {
                self.under_way.clear();
                self.waits = None;
            }
            None if self.under_way.front().is_some_and(late) => self.waits = Some(now),
            Some(_) | None => {}
        }
        self.waits.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_viewer_that_lags_is_spared_until_it_has_caught_up() {
        let mut flow = Flow::default();
        let began = Instant::now();
        let at = |seconds| began + Duration::from_secs_f64(seconds);
        let sent = |flow: &mut Flow, when, until| {
            flow.tells(Some(until));
            flow.sent(at(when));
        };
        // Before it has said anything, it keeps up.
        sent(&mut flow, 0.0, 1.0);
        assert!(!flow.is_behind(at(99.0)));
        flow.saw(at(99.0), 1.0);
        sent(&mut flow, 100.0, 2.0);
        sent(&mut flow, 101.0, 2.1);
        assert!(!flow.is_behind(at(101.0)));
        assert!(flow.is_behind(at(102.0)));
        // What holds at all times goes on meanwhile, and is not waited for.
        flow.tells(None);
        flow.sent(at(102.0));
        flow.saw(at(102.1), 2.05);
        assert!(flow.is_behind(at(102.1)), "not all of it");
        flow.saw(at(102.2), 2.1);
        assert!(!flow.is_behind(at(102.2)));
        // One that sees no more is tried again some time.
        sent(&mut flow, 103.0, 3.0);
        assert!(flow.is_behind(at(105.0)));
        flow.saw(at(110.0), 2.5);
        assert!(flow.is_behind(at(119.0)));
        assert!(!flow.is_behind(at(121.0)));
        // Another recording begins at zero.
        sent(&mut flow, 122.0, 4.0);
        flow.begin();
        sent(&mut flow, 123.0, 0.1);
        flow.saw(at(124.0), 0.1);
        assert!(!flow.is_behind(at(130.0)));
    }
}
