//! The strongest spectral line over a tilt that rises and falls.

use crate::analysis::stats::range;
use crate::pipeline::message::{TiltDirection, TiltLoop, TiltedTone, ToneChange};

/// Two lines are the same if their frequencies differ by at most this fraction.
const SAME: f64 = 0.1;

/// Tracks the strongest line while the tilt rises and falls.
#[derive(Clone, Debug, Default)]
pub struct TiltHistory {
    /// Length of the windows of the spectrum, s.
    window: f64,
    /// Start time (s) of each tilt, and the tilt, rad.
    course: Vec<[f64; 2]>,
    /// The lasting line, Hz.
    tone: Option<f64>,
    /// Another line that was observed once.
    pending: Option<TiltedTone>,
    /// Changes from one lasting line to another.
    changes: Vec<ToneChange>,
    /// All lines since the tilt started to change.
    observed: Vec<TiltedTone>,
}

impl TiltHistory {
    /// For spectra with the given window length, s.
    pub fn new(window: f64) -> Self {
        Self {
            window,
            ..Self::default()
        }
    }

    /// Sets the tilt (rad) from a time (s) on.
    pub fn set_tilt(&mut self, time: f64, tilt: f64) {
        if self.course.last().is_none_or(|last| last[1] != tilt) {
            self.course.push([time, tilt]);
        }
    }

    /// Processes the strongest line (Hz) of the window that ends at a time (s). Returns it with its tilt
    /// after the tilt has started to change.
    pub fn add_line(&mut self, time: f64, frequency: f64) -> Option<TiltedTone> {
        let middle = time - 0.5 * self.window;
        let so_far = self.course.partition_point(|[since, _]| *since <= middle);
        if so_far < 2 {
            self.tone = Some(frequency);
            return None;
        }
        let so_far = &self.course[..so_far];
        let [before, tilt] = [2, 1].map(|back| so_far[so_far.len() - back][1]);
        let way = TiltDirection::of(before, tilt);
        let observed = TiltedTone {
            tilt,
            way,
            frequency,
        };
        self.observed.push(observed);
        self.follow(observed);
        Some(observed)
    }

    /// Registers a change if the new line is observed twice in a row.
    fn follow(&mut self, observed: TiltedTone) {
        let is_same = |line: &TiltedTone| same(line.frequency, observed.frequency);
        let first = self.pending.take().filter(is_same);
        let other = |tone: &f64| !same(observed.frequency, *tone);
        match (self.tone.filter(other), first) {
            (Some(_), None) => {
                self.pending = Some(observed);
                return;
            }
            (Some(from), Some(to)) => self.changes.push(ToneChange { from, to }),
            // A slow drift of the frequency with the tilt is not a change.
            (None, _) => {}
        }
        self.tone = Some(observed.frequency);
    }

    /// The smallest and the largest tilt (rad) at which the lines differ between rise and fall.
    fn differing_tilts(&self) -> Option<[f64; 2]> {
        let is_up = |line: &&TiltedTone| line.way == TiltDirection::Up;
        let (up, down): (Vec<&TiltedTone>, Vec<_>) = self.observed.iter().partition(is_up);
        let differing = down.into_iter().filter(|down| {
            let off = |up: &TiltedTone| (up.tilt - down.tilt).abs();
            let nearest = up.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            nearest.is_some_and(|up| !same(up.frequency, down.frequency))
        });
        let [low, high] = range(differing.map(|line| line.tilt));
        (low <= high).then_some([low, high])
    }

    /// Summary for a lesson.
    pub fn summary(&self) -> TiltLoop {
        let is_up = |change: &ToneChange| change.to.way == TiltDirection::Up;
        let last = self.changes.iter().rposition(is_up);
        let last_up = last.map(|at| self.changes[at].to.tilt);
        let next = last.and_then(|at| self.changes.get(at + 1));
        // The change back is one at a smaller tilt.
        let back = next.map(|change| change.to.tilt);
        let back = back.filter(|back| last_up.is_some_and(|up| *back < up));
        let (up, down) = self.changes.iter().partition(|change| is_up(change));
        TiltLoop {
            tilt: self.observed.last().map(|observed| observed.tilt),
            has_decreased: self.observed.iter().any(|o| o.way == TiltDirection::Down),
            up,
            down,
            differing: self.differing_tilts(),
            last_up,
            back,
        }
    }
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.max(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tilt that rises to 10 and falls back in steps of 1, with a line that depends on direction and tilt.
    fn observed(tone: impl Fn(TiltDirection, f64) -> f64) -> TiltHistory {
        let mut tilts = TiltHistory::new(0.0);
        for k in 0..=20 {
            let tilt = f64::from(10 - (k - 10i32).abs());
            let way = if k <= 10 {
                TiltDirection::Up
            } else {
                TiltDirection::Down
            };
            tilts.set_tilt(f64::from(k), tilt);
            tilts.add_line(f64::from(k), tone(way, tilt));
        }
        tilts
    }

    #[test]
    fn a_hysteresis_loop_has_two_switching_tilts() {
        let tilts = observed(|way, tilt| match way {
            TiltDirection::Up if tilt < 8.0 => 4e3,
            TiltDirection::Down if tilt < 4.0 => 4e3,
            _ => 2e3,
        });
        let found = tilts.summary();
        let at = |changes: &[ToneChange]| changes.iter().map(|c| c.to.tilt).collect::<Vec<_>>();
        assert_eq!((at(&found.up), at(&found.down)), (vec![8.0], vec![3.0]));
        assert_eq!(found.differing, Some([4.0, 7.0]));
        assert!(found.has_decreased);
        assert_eq!([found.last_up, found.back], [Some(8.0), Some(3.0)]);
    }

    /// Manual changes of the tilt: up, down and up again.
    #[test]
    fn each_line_has_the_direction_of_its_own_change() {
        let mut tilts = TiltHistory::new(0.0);
        let turns = [0, 1, 2, 3, 4, 3, 2, 3, 4, 5, 6];
        for (k, tilt) in turns.into_iter().enumerate() {
            tilts.set_tilt(k as f64, f64::from(tilt));
            tilts.add_line(k as f64, if tilt < 5 { 4e3 } else { 2e3 });
        }
        let ways: Vec<_> = tilts.observed.iter().map(|observed| observed.way).collect();
        assert_eq!(
            ways[3..7],
            [
                TiltDirection::Up,
                TiltDirection::Down,
                TiltDirection::Down,
                TiltDirection::Up
            ]
        );
        let found = tilts.summary();
        assert_eq!((found.up.len(), found.down.len()), (1, 0));
        assert!(found.has_decreased, "earlier in the run");
        assert!(matches!([found.last_up, found.back], [Some(_), None]));
    }

    #[test]
    fn identical_lines_in_both_directions_are_no_loop() {
        let tilts = observed(|_, tilt| if tilt < 8.0 { 4e3 } else { 2e3 });
        assert_eq!(tilts.summary().differing, None);
        assert_eq!(tilts.changes.len(), 2);
        // A line observed once is not a change, nor is a drifting one.
        let tilts = observed(|way, tilt| match (way, tilt) {
            (TiltDirection::Up, 5.0) => 9e3,
            _ => 4e3 + 100.0 * tilt,
        });
        assert_eq!(tilts.changes, []);
    }
}
