//! Recurrence plots, Eq. (26): when is the system back where it was?
//!
//! Pixel `(i, j)` tells how far apart the states at two instants are. A periodic motion gives
//! unbroken diagonals a period apart, a torus diagonals with a second, slower spacing, chaos short
//! torn pieces (Marwan et al., Phys. Rep. 438, 237, 2007).

use crate::analysis::DelayVectors;

/// Distances of every pair of states in a window of delay vectors, Euclidean norm, and the
/// pictures they give:
///
/// ```text
/// Eq. (26):  R_ij(epsilon) = Theta(epsilon - |y_i - y_j|),   Theta(0) = 1
/// ```
///
/// Conventions: a pair at exactly the threshold is recurrent. The line of identity `i = j` is
/// always drawn and never counted: rates are over the `n (n - 1) / 2` pairs `i < j`. No Theiler
/// window: neighbours in time count.
///
/// Distances are kept in single precision, relative to the extent of the signal in the window:
/// good to about 1e-7 of that extent, far below what 8-bit pixels show. Memory is `4 n^2` bytes,
/// reused from one window to the next.
#[derive(Clone, Debug, Default)]
pub struct RecurrencePlot {
    size: usize,
    /// Half the extent of the signal, the unit of `squared`; 1 if the signal is constant.
    unit: f64,
    /// Squared distances over `unit^2`, `size x size`, row-major, symmetric.
    squared: Vec<f32>,
    /// Coordinate `c` of all points, one after another, from -1 to 1.
    points: Vec<f32>,
    /// Workspace of the selection: the pairs `i < j`.
    pairs: Vec<u32>,
}

impl RecurrencePlot {
    /// A plot without points.
    pub fn new() -> Self {
        Self::default()
    }

    /// Measures the distances between the vectors with the given indices, oldest first.
    ///
    /// # Panics
    /// If an index is not below [`DelayVectors::len`].
    pub fn measure(&mut self, vectors: &DelayVectors<'_>, picks: &[usize]) {
        let n = picks.len();
        self.size = n;
        self.gather(vectors, picks);
        self.squared.resize(n * n, 0.0);
        if n == 0 {
            return;
        }
        for (i, row) in self.squared.chunks_exact_mut(n).enumerate() {
            row.fill(0.0);
            for coordinate in self.points.chunks_exact(n) {
                let here = coordinate[i];
                for (sum, there) in row.iter_mut().zip(coordinate) {
                    *sum += (here - there) * (here - there);
                }
            }
        }
    }

    /// Points along a side, `n`.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The number of pairs `i < j`.
    pub fn pairs(&self) -> usize {
        self.size * self.size.saturating_sub(1) / 2
    }

    /// The largest distance in the window, in the signal's unit.
    pub fn largest(&self) -> f64 {
        f64::from(self.largest_squared()).sqrt() * self.unit
    }

    /// The threshold at which `round(rate * pairs)` pairs are recurrent: that order statistic of
    /// the distances, exactly. Pairs at equal distance come together, so that the rate reached
    /// may be larger. A rate of less than half a pair gives 0.
    pub fn distance_for_rate(&mut self, rate: f64) -> f64 {
        let wanted = (rate.clamp(0.0, 1.0) * self.pairs() as f64).round() as usize;
        let Some(last) = wanted.checked_sub(1) else {
            return 0.0;
        };
        self.pairs.clear();
        for i in 0..self.size {
            let later = &self.squared[i * self.size..][i + 1..self.size];
            // Floats that are not negative are ordered like their bits, which compare faster.
            self.pairs.extend(later.iter().map(|d| d.to_bits()));
        }
        let chosen = *self.pairs.select_nth_unstable(last).1;
        f64::from(f32::from_bits(chosen)).sqrt() * self.unit
    }

    /// Recurrence rate: the share of pairs no farther apart than `epsilon` (signal's unit), 0 to
    /// 1; 0 if there is no pair.
    pub fn rate(&self, epsilon: f64) -> f64 {
        if self.pairs() == 0 {
            return 0.0;
        }
        let limit = self.squared_in_units(epsilon);
        let close = |row: &[f32]| row.iter().map(|&d| u32::from(d <= limit)).sum::<u32>();
        let all: usize = self
            .squared
            .chunks_exact(self.size)
            .map(|row| close(row) as usize)
            .sum();
        // Both halves and the line of identity were counted.
        (all - self.size) as f64 / (2 * self.pairs()) as f64
    }

    /// The unthresholded picture, row-major: 0 for the same state, 255 for the largest distance
    /// of the window. All 0 if all states are the same.
    pub fn distance_picture(&self) -> Vec<u8> {
        let largest = self.largest_squared().sqrt();
        let scale = if largest > 0.0 { 255.0 / largest } else { 0.0 };
        let shade = |d: &f32| (d.sqrt() * scale + 0.5) as u8;
        self.squared.iter().map(shade).collect()
    }

    /// The picture of Eq. (26), row-major: 255 recurrent, 0 not.
    pub fn recurrence_picture(&self, epsilon: f64) -> Vec<u8> {
        let limit = self.squared_in_units(epsilon);
        let shade = |d: &f32| if *d <= limit { 255 } else { 0 };
        self.squared.iter().map(shade).collect()
    }

    /// Copies the picked points, centred and scaled to [-1, 1] so that single precision keeps
    /// their differences.
    fn gather(&mut self, vectors: &DelayVectors<'_>, picks: &[usize]) {
        let coordinates = || (0..vectors.dimension()).map(|c| vectors.coordinate(c));
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for coordinate in coordinates() {
            for &k in picks {
                low = low.min(coordinate[k]);
                high = high.max(coordinate[k]);
            }
        }
        let centre = 0.5 * (low + high);
        self.unit = if high > low { 0.5 * (high - low) } else { 1.0 };
        self.points.clear();
        for coordinate in coordinates() {
            let scaled = |&k: &usize| ((coordinate[k] - centre) / self.unit) as f32;
            self.points.extend(picks.iter().map(scaled));
        }
    }

    /// A distance as it is compared: squared, in units. A value from
    /// [`RecurrencePlot::distance_for_rate`] comes back to the very bits it was made of.
    fn squared_in_units(&self, distance: f64) -> f32 {
        (distance / self.unit).powi(2) as f32
    }

    fn largest_squared(&self) -> f32 {
        let bits = self.squared.iter().map(|d| d.to_bits()).max();
        bits.map_or(0.0, f32::from_bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::test_signals::{noise, sines};

    fn plot(signal: &[f64], lag: usize, dimension: usize) -> RecurrencePlot {
        let vectors = DelayVectors::new(signal, lag, dimension).unwrap();
        let picks: Vec<usize> = (0..vectors.len()).collect();
        let mut plot = RecurrencePlot::new();
        plot.measure(&vectors, &picks);
        plot
    }

    #[test]
    fn distances_are_those_of_the_definition() {
        let signal = noise(1, 90, 1e-7);
        let vectors = DelayVectors::new(&signal, 5, 4).unwrap();
        let picks: Vec<usize> = (0..vectors.len()).step_by(3).collect();
        let mut plot = RecurrencePlot::new();
        plot.measure(&vectors, &picks);
        let n = plot.size();
        assert_eq!(n, 25);
        let distance = |i: usize, j: usize| {
            let pairs = vectors.vector(picks[i]).zip(vectors.vector(picks[j]));
            pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
        };
        let direct: Vec<f64> = (0..n * n).map(|p| distance(p / n, p % n)).collect();
        let largest = direct.iter().copied().fold(0.0, f64::max);
        assert!((plot.largest() / largest - 1.0).abs() < 1e-6);
        for (pixel, d) in plot.distance_picture().iter().zip(&direct) {
            assert!((f64::from(*pixel) - 255.0 * d / largest).abs() <= 0.5 + 1e-3);
        }
        // At a threshold that no distance comes near, the picture is exactly Eq. (26).
        let mut sorted = direct.clone();
        sorted.sort_by(f64::total_cmp);
        let epsilon = 0.5 * (sorted[200] + sorted[202]);
        for (pixel, d) in plot.recurrence_picture(epsilon).iter().zip(&direct) {
            assert_eq!(*pixel == 255, *d <= epsilon);
        }
    }

    #[test]
    fn rate_reached_is_within_one_pair_of_the_rate_asked() {
        let mut plot = plot(&noise(2, 300, 1.0), 7, 5);
        let one_pair = 1.0 / plot.pairs() as f64;
        for asked in [0.0, 1e-4, 0.01, 0.05, 0.3, 0.99, 1.0] {
            let epsilon = plot.distance_for_rate(asked);
            assert!((plot.rate(epsilon) - asked).abs() <= one_pair, "{asked}");
            let picture = plot.recurrence_picture(epsilon);
            let recurrent = picture.iter().filter(|&&p| p == 255).count();
            let off_identity = (recurrent - plot.size()) as f64 / 2.0;
            assert!((off_identity * one_pair - plot.rate(epsilon)).abs() < 1e-12);
        }
    }

    #[test]
    fn pictures_are_symmetric_with_a_full_line_of_identity() {
        let mut plot = plot(&noise(3, 200, 1.0), 3, 3);
        let epsilon = plot.distance_for_rate(0.1);
        let n = plot.size();
        let (distance, recurrent) = (plot.distance_picture(), plot.recurrence_picture(epsilon));
        for i in 0..n {
            assert_eq!(distance[i * n + i], 0);
            assert_eq!(recurrent[i * n + i], 255);
            for j in 0..n {
                assert_eq!(distance[i * n + j], distance[j * n + i]);
                assert_eq!(recurrent[i * n + j], recurrent[j * n + i]);
            }
        }
        assert_eq!(distance.iter().max(), Some(&255));
    }

    #[test]
    fn a_sine_gives_diagonals_a_period_apart() {
        // 50 samples a period, lag a quarter period: the delay vectors run round a circle.
        let signal = sines(50.0, 425, &[(1.0, 1.0, 0.4)]);
        let mut plot = plot(&signal, 12, 2);
        let epsilon = plot.distance_for_rate(0.05);
        let (n, picture) = (plot.size(), plot.recurrence_picture(epsilon));
        for offset in 0..n - 50 {
            let diagonal = (0..n - offset).map(|i| picture[i * n + i + offset]);
            let share = diagonal.filter(|&p| p == 255).count() as f64 / (n - offset) as f64;
            match offset % 50 {
                0 => assert_eq!(share, 1.0, "diagonal {offset}"),
                5..=45 => assert_eq!(share, 0.0, "diagonal {offset}"),
                _ => {}
            }
        }
    }

    #[test]
    fn scale_and_shift_of_the_signal_do_not_change_the_pictures() {
        let signal = noise(4, 150, 1.0);
        // A power of two scales without rounding.
        let scaled: Vec<f64> = signal.iter().map(|x| x * 2.0_f64.powi(-40)).collect();
        let (mut a, mut b) = (plot(&signal, 4, 3), plot(&scaled, 4, 3));
        assert_eq!(a.distance_picture(), b.distance_picture());
        let (at, bt) = (a.distance_for_rate(0.07), b.distance_for_rate(0.07));
        assert_eq!(a.recurrence_picture(at), b.recurrence_picture(bt));
        assert_eq!(at * 2.0_f64.powi(-40), bt);
    }

    #[test]
    fn a_constant_signal_recurs_always() {
        let mut plot = plot(&[2.5; 40], 2, 3);
        assert_eq!(plot.largest(), 0.0);
        assert!(plot.distance_picture().iter().all(|&p| p == 0));
        assert_eq!(plot.distance_for_rate(0.05), 0.0);
        assert_eq!(plot.rate(0.0), 1.0);
        assert!(plot.recurrence_picture(0.0).iter().all(|&p| p == 255));
    }

    #[test]
    fn no_point_and_one_point_are_legal() {
        let signal = [1.0, 2.0];
        let vectors = DelayVectors::new(&signal, 1, 1).unwrap();
        let mut plot = RecurrencePlot::new();
        for picks in [&[][..], &[1]] {
            plot.measure(&vectors, picks);
            assert_eq!(plot.pairs(), 0);
            assert_eq!(plot.distance_for_rate(0.5), 0.0);
            assert_eq!(plot.rate(1.0), 0.0);
            assert_eq!(plot.recurrence_picture(0.0).len(), picks.len());
        }
    }
}
