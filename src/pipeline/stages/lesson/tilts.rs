//! What is heard at which tilt, on the way up and on the way down.

use crate::pipeline::message::{TiltLoop, TiltedTone, ToneChange, Way};

/// Two tones are the same where they differ by no more than this share.
const SAME: f64 = 0.1;

/// Follows the strongest line through tilts that go up and come down again.
#[derive(Clone, Debug)]
pub struct Tilts {
    /// Length of the windows that are listened to, s.
    window: f64,
    /// When a tilt began (s), and the tilt, rad.
    course: Vec<[f64; 2]>,
    /// The tone that lasts, Hz.
    tone: Option<f64>,
    /// Another one that was heard once.
    pending: Option<TiltedTone>,
    /// The changes from one tone to another that lasts.
    changes: Vec<ToneChange>,
    /// All that was heard since the tilt began to move.
    heard: Vec<TiltedTone>,
}

impl Tilts {
    /// For spectra of windows of so many seconds.
    pub fn new(window: f64) -> Self {
        Self {
            window,
            course: Vec::new(),
            tone: None,
            pending: None,
            changes: Vec::new(),
            heard: Vec::new(),
        }
    }

    /// Takes the tilt (rad) from a time (s) on.
    pub fn enter(&mut self, time: f64, tilt: f64) {
        if self.course.last().is_none_or(|last| last[1] != tilt) {
            self.course.push([time, tilt]);
        }
    }

    /// Takes the strongest line (Hz) of the window that ends at a time (s); returns it with its tilt,
    /// once that has begun to move.
    pub fn hear(&mut self, time: f64, frequency: f64) -> Option<TiltedTone> {
        let middle = time - 0.5 * self.window;
        let so_far = self.course.partition_point(|[since, _]| *since <= middle);
        if so_far < 2 {
            self.tone = Some(frequency);
            return None;
        }
        let so_far = &self.course[..so_far];
        let [before, tilt] = [2, 1].map(|back| so_far[so_far.len() - back][1]);
        let way = if tilt < before { Way::Down } else { Way::Up };
        let heard = TiltedTone {
            tilt,
            way,
            frequency,
        };
        self.heard.push(heard);
        self.follow(heard);
        Some(heard)
    }

    /// A change counts where the new tone is heard twice in a row.
    fn follow(&mut self, heard: TiltedTone) {
        let Some(tone) = self.tone else {
            self.tone = Some(heard.frequency);
            return;
        };
        if same(heard.frequency, tone) {
            // A tone may drift with the tilt: that is no change.
            self.tone = Some(heard.frequency);
            self.pending = None;
            return;
        }
        match self.pending.filter(|p| same(p.frequency, heard.frequency)) {
            Some(first) => {
                self.changes.push(ToneChange {
                    from: tone,
                    to: first,
                });
                self.tone = Some(heard.frequency);
                self.pending = None;
            }
            None => self.pending = Some(heard),
        }
    }

    /// The changes on one way.
    fn on(&self, way: Way) -> impl Iterator<Item = &ToneChange> {
        self.changes
            .iter()
            .filter(move |change| change.to.way == way)
    }

    /// The smallest and the largest tilt (rad) that was passed on both ways with different tones.
    fn differs(&self) -> Option<[f64; 2]> {
        let up: Vec<_> = self.heard.iter().filter(|h| h.way == Way::Up).collect();
        let down = self.heard.iter().filter(|h| h.way == Way::Down);
        let differing = down.filter(|down| {
            let nearest = up.iter().min_by(|a, b| {
                (a.tilt - down.tilt)
                    .abs()
                    .total_cmp(&(b.tilt - down.tilt).abs())
            });
            nearest.is_some_and(|up| !same(up.frequency, down.frequency))
        });
        differing.map(|heard| heard.tilt).fold(None, |span, tilt| {
            let [low, high] = span.unwrap_or([tilt; 2]);
            Some([low.min(tilt), high.max(tilt)])
        })
    }

    /// All of this for a lesson.
    pub fn summary(&self) -> TiltLoop {
        let [up, back] = self.last_loop();
        let on = |way| self.on(way).copied().collect();
        TiltLoop {
            tilt: self.heard.last().map(|heard| heard.tilt),
            has_come_down: self.has_come_down(),
            up: on(Way::Up),
            down: on(Way::Down),
            differing: self.differs(),
            last_up: up.map(|up| up.to.tilt),
            back: back.map(|back| back.to.tilt),
        }
    }

    /// Whether it has come down, be it a little.
    fn has_come_down(&self) -> bool {
        self.heard.iter().any(|heard| heard.way == Way::Down)
    }

    /// The last change on the way up, and the change back on the way down after it, at a smaller tilt.
    fn last_loop(&self) -> [Option<&ToneChange>; 2] {
        let is_up = |change: &ToneChange| change.to.way == Way::Up;
        let Some(last) = self.changes.iter().rposition(is_up) else {
            return [None; 2];
        };
        let up = &self.changes[last];
        let back = self.changes[last + 1..].first();
        [Some(up), back.filter(|down| down.to.tilt < up.to.tilt)]
    }
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.max(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tilt up to 10 and back, 1 a step, with tones by way and tilt.
    fn heard(tone: impl Fn(Way, f64) -> f64) -> Tilts {
        let mut tilts = Tilts::new(0.0);
        for k in 0..=20 {
            let tilt = f64::from(10 - (k - 10i32).abs());
            let way = if k <= 10 { Way::Up } else { Way::Down };
            tilts.enter(f64::from(k), tilt);
            tilts.hear(f64::from(k), tone(way, tilt));
        }
        tilts
    }

    #[test]
    fn a_loop_has_two_tilts_of_change() {
        let tilts = heard(|way, tilt| match way {
            Way::Up if tilt < 8.0 => 4e3,
            Way::Down if tilt < 4.0 => 4e3,
            _ => 2e3,
        });
        let up: Vec<_> = tilts.on(Way::Up).map(|change| change.to.tilt).collect();
        let down: Vec<_> = tilts.on(Way::Down).map(|change| change.to.tilt).collect();
        assert_eq!((up, down), (vec![8.0], vec![3.0]));
        assert_eq!(tilts.differs(), Some([4.0, 7.0]));
        assert!(tilts.has_come_down());
        let tilts_of = |changes: [Option<&ToneChange>; 2]| changes.map(|c| c.map(|c| c.to.tilt));
        assert_eq!(tilts_of(tilts.last_loop()), [Some(8.0), Some(3.0)]);
    }

    /// As a hand moves the slider: up, down and up again.
    #[test]
    fn each_way_is_that_of_its_own_move() {
        let mut tilts = Tilts::new(0.0);
        let turns = [0, 1, 2, 3, 4, 3, 2, 3, 4, 5, 6];
        for (k, tilt) in turns.into_iter().enumerate() {
            tilts.enter(k as f64, f64::from(tilt));
            tilts.hear(k as f64, if tilt < 5 { 4e3 } else { 2e3 });
        }
        let ways: Vec<_> = tilts.heard.iter().map(|heard| heard.way).collect();
        assert_eq!(ways[3..7], [Way::Up, Way::Down, Way::Down, Way::Up]);
        assert_eq!(tilts.on(Way::Up).count(), 1);
        assert_eq!(tilts.on(Way::Down).count(), 0);
        assert!(tilts.has_come_down(), "before");
        assert!(matches!(tilts.last_loop(), [Some(_), None]));
    }

    #[test]
    fn what_is_the_same_both_ways_is_no_loop() {
        let tilts = heard(|_, tilt| if tilt < 8.0 { 4e3 } else { 2e3 });
        assert_eq!(tilts.differs(), None);
        assert_eq!(tilts.changes.len(), 2);
        // A tone that is heard once is no change; nor is one that drifts.
        let tilts = heard(|way, tilt| match (way, tilt) {
            (Way::Up, 5.0) => 9e3,
            _ => 4e3 + 100.0 * tilt,
        });
        assert_eq!(tilts.changes, []);
    }
}
