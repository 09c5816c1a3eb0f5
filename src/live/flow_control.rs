//! Flow control of a viewer.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Maximum time in which a viewer must display a message. A slower viewer gets no further messages until it
/// has displayed all previous ones.
const MAX_DELAY: Duration = Duration::from_millis(1500);
/// Time after which a viewer without progress gets messages again.
const RETRY_AFTER: Duration = Duration::from_secs(10);

/// Flow control: backlog of a viewer. A viewer that sends no acknowledgements is assumed to keep up.
#[derive(Debug, Default)]
pub struct FlowControl {
    /// Unacknowledged messages: time of sending, and newest simulated time in the message, s; oldest first.
    unacknowledged: VecDeque<(Instant, f64)>,
    /// Newest simulated time to be sent, and newest acknowledged time, s.
    newest: f64,
    acknowledged: f64,
    /// Start of the present pause in sending, or time of its last progress; `None` while messages are sent.
    paused_since: Option<Instant>,
    acknowledges: bool,
}

impl FlowControl {
    /// Starts another recording.
    pub fn begin(&mut self) {
        *self = Self {
            acknowledges: self.acknowledges,
            ..Self::default()
        };
    }

    /// Registers the newest simulated time of the next message, s.
    pub fn queue(&mut self, until: Option<f64>) {
        self.newest = self.newest.max(until.unwrap_or(0.0));
    }

    pub fn sent(&mut self, now: Instant) {
        let last = self
            .unacknowledged
            .back()
            .map_or(self.acknowledged, |(_, last)| *last);
        if self.acknowledges && self.newest > last {
            self.unacknowledged.push_back((now, self.newest));
        }
    }

    pub fn acknowledge(&mut self, now: Instant, time: f64) {
        self.acknowledges = true;
        if time != self.acknowledged && self.paused_since.is_some() {
            self.paused_since = Some(now);
        }
        self.acknowledged = time;
        // Tolerance for times rounded to 1 ns.
        let is_seen = |(_, until): &(Instant, f64)| *until <= time + 1e-8;
        while self.unacknowledged.front().is_some_and(is_seen) {
            self.unacknowledged.pop_front();
        }
        if self.unacknowledged.is_empty() {
            self.paused_since = None;
        }
    }

    pub fn is_behind(&mut self, now: Instant) -> bool {
        let late = |(sent, _): &(Instant, f64)| now > *sent + MAX_DELAY;
        match self.paused_since {
            Some(since) if now > since + RETRY_AFTER => {
                self.unacknowledged.clear();
                self.paused_since = None;
            }
            None if self.unacknowledged.front().is_some_and(late) => self.paused_since = Some(now),
            Some(_) | None => {}
        }
        self.paused_since.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_viewer_gets_no_messages_until_it_has_caught_up() {
        let mut flow = FlowControl::default();
        let began = Instant::now();
        let at = |seconds| began + Duration::from_secs_f64(seconds);
        let sent = |flow: &mut FlowControl, when, until| {
            flow.queue(Some(until));
            flow.sent(at(when));
        };
        // Before the first acknowledgement the viewer is assumed to keep up.
        sent(&mut flow, 0.0, 1.0);
        assert!(!flow.is_behind(at(99.0)));
        flow.acknowledge(at(99.0), 1.0);
        sent(&mut flow, 100.0, 2.0);
        sent(&mut flow, 101.0, 2.1);
        assert!(!flow.is_behind(at(101.0)));
        assert!(flow.is_behind(at(102.0)));
        // Static data are sent in the meantime and need no acknowledgement.
        flow.queue(None);
        flow.sent(at(102.0));
        flow.acknowledge(at(102.1), 2.05);
        assert!(flow.is_behind(at(102.1)), "not everything is acknowledged");
        flow.acknowledge(at(102.2), 2.1);
        assert!(!flow.is_behind(at(102.2)));
        // A viewer without progress gets messages again after some time.
        sent(&mut flow, 103.0, 3.0);
        assert!(flow.is_behind(at(105.0)));
        flow.acknowledge(at(110.0), 2.5);
        assert!(flow.is_behind(at(119.0)));
        assert!(!flow.is_behind(at(121.0)));
        // Another recording starts at zero.
        sent(&mut flow, 122.0, 4.0);
        flow.begin();
        sent(&mut flow, 123.0, 0.1);
        flow.acknowledge(at(124.0), 0.1);
        assert!(!flow.is_behind(at(130.0)));
    }
}
