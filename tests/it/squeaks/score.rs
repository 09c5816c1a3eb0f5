//! Scores of a method that finds squeaks: recall, precision, recordings with a false event.

use super::generator::Squeak;

/// Largest relative error of the frequency of a squeak that counts as found.
pub const FREQUENCY_TOLERANCE: f64 = 0.005;

/// Largest error of the start and of the end of a squeak that counts as found, s.
pub const END_TOLERANCE_S: f64 = 0.1;

/// What a method says about one squeak.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// Frequency of the fundamental, Hz.
    pub frequency_hz: f64,
}

impl Found {
    /// Whether this is the squeak: frequency, start and end within the tolerances.
    fn is(&self, squeak: &Squeak) -> bool {
        (self.frequency_hz / squeak.frequency_hz - 1.0).abs() <= FREQUENCY_TOLERANCE
            && (self.start_s - squeak.start_s).abs() <= END_TOLERANCE_S
            && (self.end_s - squeak.end_s).abs() <= END_TOLERANCE_S
    }
}

/// Counts over recordings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Score {
    /// Recordings.
    pub recordings: usize,
    /// Squeaks in them.
    pub squeaks: usize,
    /// Squeaks that were found.
    pub found: usize,
    /// Events that are no squeak, or one with a wrong frequency, start or end.
    pub false_events: usize,
    /// Recordings with such an event.
    pub with_false: usize,
}

impl Score {
    /// The score in one recording. An event is at most one squeak, and a squeak at most one event: further events of
    /// a squeak are false.
    pub fn of(squeaks: &[Squeak], events: &[Found]) -> Self {
        let mut left: Vec<&Squeak> = squeaks.iter().collect();
        for event in events {
            let which = left.iter().position(|squeak| event.is(squeak));
            which.map(|k| left.swap_remove(k));
        }
        let found = squeaks.len() - left.len();
        let false_events = events.len() - found;
        Self {
            recordings: 1,
            squeaks: squeaks.len(),
            found,
            false_events,
            with_false: usize::from(false_events > 0),
        }
    }

    /// Share of the squeaks that were found; NaN without squeaks.
    pub fn recall(&self) -> f64 {
        self.found as f64 / self.squeaks as f64
    }

    /// Share of the events that are squeaks; NaN without events.
    pub fn precision(&self) -> f64 {
        self.found as f64 / (self.found + self.false_events) as f64
    }

    /// Share of the recordings with a false event.
    pub fn with_false_share(&self) -> f64 {
        self.with_false as f64 / self.recordings as f64
    }
}

impl std::iter::Sum for Score {
    fn sum<I: Iterator<Item = Self>>(scores: I) -> Self {
        scores.fold(Self::default(), |a, b| Self {
            recordings: a.recordings + b.recordings,
            squeaks: a.squeaks + b.squeaks,
            found: a.found + b.found,
            false_events: a.false_events + b.false_events,
            with_false: a.with_false + b.with_false,
        })
    }
}

/// Counts by set of recordings: the signal-to-noise ratio, what else is in the recordings, or what they are of.
#[derive(Default)]
pub struct Counts(pub Vec<(String, Score)>);

impl Counts {
    /// Adds a set.
    pub fn push(&mut self, set: String, scores: impl Iterator<Item = Score>) {
        self.0.push((set, scores.sum()));
    }

    /// The counts of a set.
    pub fn of(&self, set: &str) -> Score {
        let found = self.0.iter().find(|(name, _)| name == set);
        found.unwrap_or_else(|| panic!("no set {set}")).1
    }

    /// The counts as CSV, with the name of the program in the first column.
    pub fn csv(&self, program: &str) -> String {
        let mut text = "program,set,recordings,squeaks,found,false_events,with_false\n".to_owned();
        for (set, score) in &self.0 {
            let Score {
                recordings,
                squeaks,
                found,
                false_events,
                with_false,
            } = score;
            text += &format!(
                "{program},{set},{recordings},{squeaks},{found},{false_events},{with_false}\n"
            );
        }
        text
    }

    /// The counts of a program in a CSV.
    pub fn read(text: &str, program: &str) -> Self {
        let mut counts = Self::default();
        for line in text.lines() {
            let cells: Vec<&str> = line.split(',').collect();
            if cells[0] == program {
                let count = |k: usize| cells[k].parse().expect("a count");
                let score = Score {
                    recordings: count(2),
                    squeaks: count(3),
                    found: count(4),
                    false_events: count(5),
                    with_false: count(6),
                };
                counts.0.push((cells[1].to_owned(), score));
            }
        }
        counts
    }
}

/// A squeak from 2 to 4 s at 1 kHz.
fn squeak(frequency_hz: f64) -> Squeak {
    Squeak {
        start_s: 2.0,
        end_s: 4.0,
        frequency_hz,
        snr_db: 10.0,
        harmonics: 1,
        modulation: None,
        second: None,
    }
}

fn event(start_s: f64, end_s: f64, frequency_hz: f64) -> Found {
    Found {
        start_s,
        end_s,
        frequency_hz,
    }
}

#[test]
fn a_squeak_is_found_within_the_tolerances_only() {
    let found = |event| Score::of(&[squeak(1000.0)], &[event]).found == 1;
    assert!(found(event(2.09, 3.91, 1004.9)));
    assert!(found(event(1.91, 4.09, 995.1)));
    for miss in [
        event(2.11, 4.0, 1000.0),
        event(2.0, 4.11, 1000.0),
        event(2.0, 4.0, 1005.1),
        event(2.0, 4.0, 2000.0),
    ] {
        assert!(!found(miss), "{miss:?}");
    }
}

#[test]
fn each_squeak_counts_once_and_all_other_events_are_false() {
    let squeaks = [squeak(1000.0), squeak(3100.0)];
    let events = [
        event(2.0, 4.0, 1001.0),
        event(2.05, 4.0, 1000.0),
        event(2.0, 3.0, 3100.0),
    ];
    let score = Score::of(&squeaks, &events);
    assert_eq!(
        (score.found, score.false_events, score.with_false),
        (1, 2, 1)
    );
    assert_eq!((score.recall(), score.precision()), (0.5, 1.0 / 3.0));
    let both: Score = [score, Score::of(&[], &[])].into_iter().sum();
    assert_eq!((both.recordings, both.with_false_share()), (2, 0.5));
}

#[test]
fn counts_are_read_as_they_were_written() {
    let mut counts = Counts::default();
    let score = Score::of(&[squeak(1000.0)], &[event(2.0, 4.0, 1000.0)]);
    counts.push("10 dB".to_owned(), [score, score].into_iter());
    let text = counts.csv("this") + &counts.csv("that");
    let read = Counts::read(&text, "that");
    assert_eq!(read.of("10 dB"), counts.of("10 dB"));
    assert_eq!((read.0.len(), read.of("10 dB").squeaks), (1, 2));
}
