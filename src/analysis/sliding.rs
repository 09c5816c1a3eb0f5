//! Windows on a stream, at exact instants.

/// The last samples of `C` parallel channels.
#[derive(Clone, Debug)]
pub struct History<const C: usize> {
    channels: [Vec<f64>; C],
    length: usize,
    seen: u64,
}

/// What a [`History`] or a [`SlidingWindow`] shows at one instant.
#[derive(Clone, Copy, Debug)]
pub struct View<'a, const C: usize> {
    /// The samples of each channel, oldest first.
    pub channels: [&'a [f64]; C],
    /// Samples seen since the start; the newest one here has the index `seen - 1`.
    pub seen: u64,
}

impl<const C: usize> History<C> {
    /// Keeps the last `length` samples.
    pub fn new(length: usize) -> Self {
        Self {
            channels: std::array::from_fn(|_| Vec::with_capacity(Self::room(length))),
            length,
            seen: 0,
        }
    }

    /// Takes the next samples, as many of each channel.
    ///
    /// # Panics
    /// If the channels differ in length.
    pub fn push(&mut self, samples: [&[f64]; C]) {
        let count = common_length(samples);
        // Of a piece longer than the history only the end can ever be seen.
        let unseen = count.saturating_sub(self.length);
        for (channel, new) in self.channels.iter_mut().zip(samples) {
            if channel.len() + count - unseen > Self::room(self.length) {
                channel.drain(..channel.len() - self.length);
            }
            channel.extend_from_slice(&new[unseen..]);
        }
        self.seen += count as u64;
    }

    /// The last samples, fewer than the length at the beginning.
    pub fn view(&self) -> View<'_, C> {
        let last = |c: &Vec<f64>| c.len().saturating_sub(self.length);
        View {
            channels: std::array::from_fn(|c| &self.channels[c][last(&self.channels[c])..]),
            seen: self.seen,
        }
    }

    /// Samples a channel may hold before the old ones are dropped: a multiple of the length, so
    /// that each sample is moved less than once on average.
    fn room(length: usize) -> usize {
        4 * length
    }
}

/// A [`History`] handed out every `hop` samples.
///
/// Window `j = 1, 2, ...` ends when `round(j hop)` samples have been seen, counted from the first
/// one: a hop that is not whole does not drift, and the windows do not depend on the pieces in
/// which the samples arrive.
#[derive(Clone, Debug)]
pub struct SlidingWindow<const C: usize> {
    history: History<C>,
    minimum: usize,
    hop: f64,
    fired: u64,
    /// Samples from one window that is handed out to the next, at least.
    apart: u64,
    /// Where the last one that was handed out ended.
    shown: Option<u64>,
}

impl<const C: usize> SlidingWindow<C> {
    /// Windows of `length` samples every `hop` samples (raised to 1 if smaller), none before it
    /// is full.
    pub fn new(length: usize, hop: f64) -> Self {
        Self {
            history: History::new(length),
            minimum: length,
            hop: hop.max(1.0),
            fired: 0,
            apart: 0,
            shown: None,
        }
    }

    /// Passes over windows from now on that end less than so many samples after the last one handed out.
    pub fn space_out(&mut self, apart: u64) {
        self.apart = apart;
    }

    /// Also hands out windows that are not yet full, once they hold `minimum` samples.
    #[must_use]
    pub fn starting_with(mut self, minimum: usize) -> Self {
        self.minimum = minimum.min(self.history.length);
        self
    }

    /// Takes the next samples, as many of each channel, and calls `each` for every window that
    /// they complete.
    ///
    /// # Errors
    /// The first error of `each`; samples after it are not taken.
    ///
    /// # Panics
    /// If the channels differ in length.
    pub fn push<E>(
        &mut self,
        samples: [&[f64]; C],
        mut each: impl FnMut(View<'_, C>) -> Result<(), E>,
    ) -> Result<(), E> {
        let count = common_length(samples);
        let mut taken = 0;
        while taken < count {
            let due = ((self.fired + 1) as f64 * self.hop).round() as u64;
            let step = (count - taken).min((due - self.history.seen) as usize);
            self.history.push(samples.map(|s| &s[taken..taken + step]));
            taken += step;
            if self.history.seen == due {
                self.fired += 1;
                let far = self.shown.is_none_or(|shown| due >= shown + self.apart);
                if due >= self.minimum as u64 && far {
                    self.shown = Some(due);
                    each(self.history.view())?;
                }
            }
        }
        Ok(())
    }
}

/// The length that all channels have.
fn common_length<const C: usize>(samples: [&[f64]; C]) -> usize {
    let count = samples.first().map_or(0, |s| s.len());
    assert!(
        samples.iter().all(|s| s.len() == count),
        "channels of a stream differ in length"
    );
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    /// Pushes the numbers 0, 1, ... in pieces and returns what each window saw.
    fn windows(piece: usize, hop: f64, minimum: usize) -> Vec<(u64, Vec<f64>)> {
        let stream: Vec<f64> = (0..500).map(f64::from).collect();
        let mut sliding = SlidingWindow::<1>::new(20, hop).starting_with(minimum);
        let mut out = Vec::new();
        for part in stream.chunks(piece) {
            sliding
                .push([part], |view| {
                    out.push((view.seen, view.channels[0].to_vec()));
                    Ok::<(), Infallible>(())
                })
                .unwrap_or_else(|never| match never {});
        }
        out
    }

    #[test]
    fn windows_end_where_they_should_and_do_not_drift() {
        let found = windows(64, 7.3, 20);
        let ends: Vec<u64> = (1..=68)
            .map(|j| (f64::from(j) * 7.3).round() as u64)
            .collect();
        let full: Vec<u64> = ends.into_iter().filter(|&e| e >= 20).collect();
        assert_eq!(found.iter().map(|w| w.0).collect::<Vec<_>>(), full);
        for (seen, window) in found {
            let expected: Vec<f64> = (seen - 20..seen).map(|i| i as f64).collect();
            assert_eq!(window, expected);
        }
    }

    #[test]
    fn windows_can_be_spaced_out_and_brought_together_again() {
        let mut sliding = SlidingWindow::<1>::new(20, 10.0);
        let mut ends = Vec::new();
        for (apart, count) in [(0, 50), (25, 100), (0, 30)] {
            sliding.space_out(apart);
            let samples = vec![0.0; count];
            sliding
                .push([&samples], |view| {
                    ends.push(view.seen);
                    Ok::<(), Infallible>(())
                })
                .unwrap_or_else(|never| match never {});
        }
        assert_eq!(ends, [20, 30, 40, 50, 80, 110, 140, 160, 170, 180]);
    }

    #[test]
    fn pieces_do_not_matter() {
        let whole = windows(500, 7.3, 5);
        for piece in [1, 3, 20, 21, 99] {
            assert_eq!(windows(piece, 7.3, 5), whole);
        }
    }

    #[test]
    fn windows_grow_from_the_minimum() {
        let lengths: Vec<usize> = windows(9, 6.0, 8).iter().map(|w| w.1.len()).collect();
        assert_eq!(lengths[..4], [12, 18, 20, 20]);
    }
}
