//! What is heard at which tilt, on the way up and on the way down.

use crate::pipeline::message::{TiltedTone, Way};

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
    pub changes: Vec<Change>,
    /// All that was heard since the tilt began to move.
    pub heard: Vec<TiltedTone>,
}

/// A change of tone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// The tone before, Hz.
    pub from: f64,
    /// The new tone, where it was first heard.
    pub to: TiltedTone,
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
        let tilt = so_far[so_far.len() - 1][1];
        let highest = so_far
            .iter()
            .fold(f64::NEG_INFINITY, |a, [_, tilt]| a.max(*tilt));
        let way = if tilt < highest { Way::Down } else { Way::Up };
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
                self.changes.push(Change {
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
    pub fn on(&self, way: Way) -> impl Iterator<Item = &Change> {
        self.changes
            .iter()
            .filter(move |change| change.to.way == way)
    }

    /// The smallest and the largest tilt (rad) that was passed on both ways with different tones.
    pub fn differs(&self) -> Option<[f64; 2]> {
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

    /// Whether it is on its way down.
    pub fn comes_down(&self) -> bool {
        self.heard
            .last()
            .is_some_and(|heard| heard.way == Way::Down)
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
        assert!(tilts.comes_down());
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
