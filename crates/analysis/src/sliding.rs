//! Sliding windows over a sample stream, ending at exact instants.

/// The last samples of `C` parallel channels.
#[derive(Clone, Debug)]
pub struct History<const C: usize> {
    channels: [Vec<f64>; C],
    length: usize,
    seen: u64,
}

/// Contents of a [`History`] or a [`SlidingWindow`] at one instant.
#[derive(Clone, Copy, Debug)]
pub struct View<'a, const C: usize> {
    /// Samples of each channel, oldest first.
    pub channels: [&'a [f64]; C],
    /// Samples received since the start. The newest sample here has the index `seen - 1`.
    pub seen: u64,
}

impl<const C: usize> History<C> {
    /// Creates a history of the last `length` samples.
    pub fn new(length: usize) -> Self {
        Self {
            channels: std::array::from_fn(|_| Vec::with_capacity(Self::capacity(length))),
            length,
            seen: 0,
        }
    }

    /// Appends samples, the same number to each channel.
    ///
    /// # Panics
    /// If the channels differ in length.
    pub fn push(&mut self, samples: [&[f64]; C]) {
        let count = common_length(samples);
        // Only the end of a block longer than the history can become visible.
        let unseen = count.saturating_sub(self.length);
        for (channel, new) in self.channels.iter_mut().zip(samples) {
            if channel.len() + count - unseen > Self::capacity(self.length) {
                channel.drain(..channel.len() - self.length);
            }
            channel.extend_from_slice(&new[unseen..]);
        }
        self.seen += count as u64;
    }

    /// The last samples; fewer than the length at the beginning.
    pub fn view(&self) -> View<'_, C> {
        let last = |c: &Vec<f64>| c.len().saturating_sub(self.length);
        View {
            channels: std::array::from_fn(|c| &self.channels[c][last(&self.channels[c])..]),
            seen: self.seen,
        }
    }

    /// Maximum number of buffered samples per channel before old ones are dropped. A multiple of the
    /// length moves each sample less than once on average.
    fn capacity(length: usize) -> usize {
        4 * length
    }
}

/// A [`History`] that passes on a window every `hop` samples.
///
/// Window `j = 1, 2, ...` ends after `round(j hop)` samples, counted from the first one. A non-integer
/// hop therefore does not drift, and the windows do not depend on the block sizes of the stream.
#[derive(Clone, Debug)]
pub struct SlidingWindow<const C: usize> {
    history: History<C>,
    minimum: usize,
    hop: f64,
    completed: u64,
    /// End of the last window passed on.
    last_end: Option<u64>,
    /// Windows that end less than this number of samples after the last one passed on are skipped; 0 by default.
    pub min_spacing: u64,
    /// Only windows whose number is a multiple of this one, at least 1, are passed on; 1 by default.
    pub divisor: u64,
}

impl<const C: usize> SlidingWindow<C> {
    /// Creates windows of `length` samples every `hop` samples (at least 1). The first window is the
    /// first full one.
    pub fn new(length: usize, hop: f64) -> Self {
        Self {
            history: History::new(length),
            minimum: length,
            hop: hop.max(1.0),
            completed: 0,
            min_spacing: 0,
            last_end: None,
            divisor: 1,
        }
    }

    /// Also passes on partly filled windows with at least `minimum` samples.
    #[must_use]
    pub fn with_min_length(mut self, minimum: usize) -> Self {
        self.minimum = minimum.min(self.history.length);
        self
    }

    /// Appends samples, the same number to each channel, and calls `each` for every window that they
    /// complete.
    ///
    /// # Errors
    /// The first error of `each`. Later samples are not appended.
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
            let due = ((self.completed + 1) as f64 * self.hop).round() as u64;
            let step = (count - taken).min((due - self.history.seen) as usize);
            self.history.push(samples.map(|s| &s[taken..taken + step]));
            taken += step;
            if self.history.seen == due {
                self.completed += 1;
                let spaced = self
                    .last_end
                    .is_none_or(|last_end| due >= last_end + self.min_spacing);
                let counted = self.completed.is_multiple_of(self.divisor);
                if due >= self.minimum as u64 && spaced && counted {
                    self.last_end = Some(due);
                    each(self.history.view())?;
                }
            }
        }
        Ok(())
    }
}

/// Common length of all channels.
fn common_length<const C: usize>(samples: [&[f64]; C]) -> usize {
    let count = samples.first().map_or(0, |s| s.len());
    assert!(
        samples.iter().all(|s| s.len() == count),
        "the channels of a stream differ in length"
    );
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    /// Pushes the numbers 0, 1, ... in blocks and returns the contents of each window.
    fn windows(block: usize, hop: f64, minimum: usize) -> Vec<(u64, Vec<f64>)> {
        let stream: Vec<f64> = (0..500).map(f64::from).collect();
        let mut sliding = SlidingWindow::<1>::new(20, hop).with_min_length(minimum);
        let mut out = Vec::new();
        for part in stream.chunks(block) {
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
    fn windows_end_at_rounded_multiples_of_the_hop() {
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
    fn the_minimum_spacing_can_be_changed_between_blocks() {
        let mut sliding = SlidingWindow::<1>::new(20, 10.0);
        let mut ends = Vec::new();
        for (min_spacing, count) in [(0, 50), (25, 100), (0, 30)] {
            sliding.min_spacing = min_spacing;
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
    fn a_divisor_leaves_every_so_many_windows() {
        let mut sliding = SlidingWindow::<1>::new(20, 10.0);
        let mut ends = Vec::new();
        for (divisor, count) in [(1, 50), (3, 100), (1, 30)] {
            sliding.divisor = divisor;
            sliding
                .push([&vec![0.0; count]], |view| {
                    ends.push(view.seen);
                    Ok::<(), Infallible>(())
                })
                .unwrap_or_else(|never| match never {});
        }
        assert_eq!(ends, [20, 30, 40, 50, 60, 90, 120, 150, 160, 170, 180]);
    }

    #[test]
    fn block_sizes_do_not_change_the_windows() {
        let whole = windows(500, 7.3, 5);
        for block in [1, 3, 20, 21, 99] {
            assert_eq!(windows(block, 7.3, 5), whole);
        }
    }

    #[test]
    fn windows_grow_from_the_minimum() {
        let lengths: Vec<usize> = windows(9, 6.0, 8).iter().map(|w| w.1.len()).collect();
        assert_eq!(lengths[..4], [12, 18, 20, 20]);
    }
}
