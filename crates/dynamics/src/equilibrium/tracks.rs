//! Modes that are followed by their shapes while a parameter changes.

use super::Eigenmode;

/// Correlation from which on two shapes are similar.
const SIMILAR: f64 = 0.3;

/// A mode with the number under which it is followed.
#[derive(Clone, Debug)]
pub struct TrackedMode {
    /// Number of the mode.
    pub number: usize,
    /// The mode.
    pub mode: Eigenmode,
}

/// The numbers given so far to modes that are followed.
#[derive(Clone, Debug, Default)]
pub struct ModeTracks {
    next: usize,
    /// Smallest correlation of an oscillating mode with itself in the last step, 0 to 1.
    pub worst_correlation: f64,
}

impl ModeTracks {
    /// Gives each mode the number of the mode before it with the most similar shape. Modes without one get new
    /// numbers: at the start by ascending frequency, later where a pair of complex eigenvalues becomes two real ones
    /// or the reverse. The result is in ascending order of the numbers.
    pub fn follow(
        &mut self,
        before: &[TrackedMode],
        mut modes: Vec<Eigenmode>,
    ) -> Vec<TrackedMode> {
        modes.sort_by(|a, b| {
            let by_frequency = a.value.im.total_cmp(&b.value.im);
            by_frequency.then(a.value.re.total_cmp(&b.value.re))
        });
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (i, old) in before.iter().enumerate() {
            for (j, new) in modes.iter().enumerate() {
                if old.mode.oscillates() == new.oscillates() {
                    pairs.push((old.mode.likeness(new), i, j));
                }
            }
        }
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut numbers: Vec<Option<usize>> = vec![None; modes.len()];
        let mut is_taken = vec![false; before.len()];
        self.worst_correlation = 1.0;
        for (_, i, j) in pairs {
            if !is_taken[i] && numbers[j].is_none() {
                is_taken[i] = true;
                numbers[j] = Some(before[i].number);
                if modes[j].oscillates() {
                    let correlation = before[i].mode.correlation(&modes[j]);
                    self.worst_correlation = self.worst_correlation.min(correlation);
                }
            }
        }
        let tracked = modes
            .into_iter()
            .zip(numbers)
            .map(|(mode, number)| TrackedMode {
                number: number.unwrap_or_else(|| {
                    self.next += 1;
                    self.next - 1
                }),
                mode,
            });
        let mut tracked: Vec<TrackedMode> = tracked.collect();
        tracked.sort_by_key(|tracked| tracked.number);
        tracked
    }
}

impl Eigenmode {
    /// Similarity of two modes: the correlation of their shapes, less the relative distance of their eigenvalues, which
    /// decides between modes of similar shape.
    fn likeness(&self, other: &Self) -> f64 {
        let size = self.value.norm().max(other.value.norm()).max(1e-300);
        self.correlation(other) - (self.value - other.value).norm() / size
    }

    /// The mode of a list that is most similar to this one.
    pub fn most_alike<'m>(&self, modes: &'m [Self]) -> Option<&'m Self> {
        let alike = modes.iter();
        let alike = alike.filter(|mode| mode.oscillates() == self.oscillates());
        alike.max_by(|a, b| a.likeness(self).total_cmp(&b.likeness(self)))
    }

    /// The mode with the largest growth rate among those of a list with a similar shape.
    pub fn fastest_alike<'m>(&self, modes: &'m [Self]) -> Option<&'m Self> {
        let alike = modes.iter();
        let alike = alike.filter(|mode| mode.oscillates() && mode.correlation(self) > SIMILAR);
        alike.max_by(|a, b| a.value.re.total_cmp(&b.value.re))
    }
}
