//! Modes followed along a branch by the correlation of their shapes.

use crate::dynamics::equilibrium::Eigenmode;

/// Correlation from which on two shapes are similar.
const SIMILAR: f64 = 0.3;

/// A mode with the number under which it is followed.
#[derive(Clone, Debug)]
pub(super) struct Tracked {
    /// Number of the mode.
    pub number: usize,
    /// The mode.
    pub mode: Eigenmode,
}

/// The numbers given so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Tracks {
    next: usize,
    /// Smallest correlation of an oscillating mode with itself in the last step.
    pub worst: f64,
}

impl Tracks {
    /// Gives each mode the number of the mode before it with the most similar shape. Modes without one get new
    /// numbers: at the start by ascending frequency, later where a pair of complex eigenvalues becomes two real ones
    /// or the reverse.
    pub fn follow(&mut self, before: &[Tracked], mut modes: Vec<Eigenmode>) -> Vec<Tracked> {
        modes.sort_by(|a, b| {
            let by_frequency = a.value.im.total_cmp(&b.value.im);
            by_frequency.then(a.value.re.total_cmp(&b.value.re))
        });
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (i, old) in before.iter().enumerate() {
            for (j, new) in modes.iter().enumerate() {
                if old.mode.oscillates() == new.oscillates() {
                    pairs.push((likeness(&old.mode, new), i, j));
                }
            }
        }
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut numbers: Vec<Option<usize>> = vec![None; modes.len()];
        let mut is_taken = vec![false; before.len()];
        self.worst = 1.0;
        for (_, i, j) in pairs {
            if !is_taken[i] && numbers[j].is_none() {
                is_taken[i] = true;
                numbers[j] = Some(before[i].number);
                if modes[j].oscillates() {
                    let correlation = before[i].mode.correlation(&modes[j]);
                    self.worst = self.worst.min(correlation);
                }
            }
        }
        let tracked = modes
            .into_iter()
            .zip(numbers)
            .map(|(mode, number)| Tracked {
                number: number.unwrap_or_else(|| {
                    self.next += 1;
                    self.next - 1
                }),
                mode,
            });
        let mut tracked: Vec<Tracked> = tracked.collect();
        tracked.sort_by_key(|tracked| tracked.number);
        tracked
    }
}

/// Similarity of two modes: the correlation of their shapes, less the relative distance of their eigenvalues, which
/// decides between modes of similar shape.
fn likeness(one: &Eigenmode, other: &Eigenmode) -> f64 {
    let size = one.value.norm().max(other.value.norm()).max(1e-300);
    one.correlation(other) - (one.value - other.value).norm() / size
}

/// The mode most similar to another.
pub(super) fn most_alike(modes: Vec<Eigenmode>, to: &Eigenmode) -> Option<Eigenmode> {
    let alike = modes
        .into_iter()
        .filter(|mode| mode.oscillates() == to.oscillates());
    alike.max_by(|a, b| likeness(a, to).total_cmp(&likeness(b, to)))
}

/// The mode with the largest growth rate among those with a similar shape.
pub(super) fn fastest_alike(modes: Vec<Eigenmode>, to: &Eigenmode) -> Option<Eigenmode> {
    let alike = modes
        .into_iter()
        .filter(|mode| mode.oscillates() && mode.correlation(to) > SIMILAR);
    alike.max_by(|a, b| a.value.re.total_cmp(&b.value.re))
}
