//! Recurrence plots, Eq. (26).
//!
//! Pixel `(i, j)` shows the distance between the states at two instants. A periodic motion gives
//! unbroken diagonals one period apart, a torus diagonals with a second, longer spacing, and chaos
//! short, interrupted diagonals (Marwan et al., Phys. Rep. 438, 237, 2007).

use super::Threshold;
use super::threshold::rank_of_rate;
use crate::{AnalysisError, DelayVectors, Norm, deviation};

/// Distances between all pairs of states in a window of delay vectors, and the images computed from
/// them:
///
/// ```text
/// Eq. (26):  R_ij(epsilon) = Theta(epsilon - |y_i - y_j|),   Theta(0) = 1
/// ```
///
/// For windows small enough to display: it uses `8 n^2` bytes, which are reused for the next window. To
/// count without an image, see [`quantify`](super::quantify).
///
/// Conventions and the classification of every pair are those of
/// [`RecurrenceCounts`](super::RecurrenceCounts): row `i`, column `j`, recurrent at exactly the
/// threshold. Images show all pairs. Rates refer to the pairs outside the Theiler window, which is given
/// in samples of the signal even if only some of the samples are plotted: pairs of states closer in time
/// are drawn but not counted.
#[derive(Clone, Debug)]
pub struct RecurrencePlot {
    norm: Norm,
    theiler: usize,
    size: usize,
    /// Unrooted distances (see [`Norm`]), `size x size`, row-major, symmetric.
    unrooted: Vec<f64>,
    /// Row `i` is counted before column `counted[i].0` and from column `counted[i].1`, without the line
    /// of identity.
    counted: Vec<(usize, usize)>,
    /// Standard deviation of the signal.
    deviation: f64,
    /// Coordinate `c` of all points, consecutively.
    points: Vec<f64>,
    /// Workspace for the selection of an order statistic.
    selection: Vec<u64>,
}

/// A recurrence plot at a threshold.
#[derive(Clone, Debug, PartialEq)]
pub struct ThresholdedPlot {
    /// Row-major: 255 recurrent, 0 not.
    pub pixels: Vec<u8>,
    /// Threshold distance, in the signal's unit; `None` for a separate threshold per state
    /// ([`Threshold::Neighbours`]).
    pub distance: Option<f64>,
    /// Recurrence rate: recurrent share of the counted pairs, 0 to 1; 0 without pairs.
    pub rate: f64,
}

/// Image of a recurrence plot, Eq. (26), of the delay vectors, Eq. (25), of a window of a signal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecurrenceImage {
    /// Length of the window, s.
    pub window: f64,
    /// Points per side.
    pub size: usize,
    /// Distance between the two states, 0 (equal) to 255 (maximum of the window):
    /// `distance[i * size + j]`, oldest first.
    pub distance: Vec<u8>,
    /// 255 where recurrent, else 0; in the same order.
    pub recurrent: Vec<u8>,
    /// Threshold distance, in the signal's unit; `None` for a separate threshold per state.
    pub threshold: Option<f64>,
    /// Recurrence rate, 0 to 1.
    pub rate: f64,
    /// Lag, s.
    pub lag: f64,
    /// Embedding dimension.
    pub dimension: usize,
}

/// Euclidean norm and a Theiler window of 1: all pairs count except the line of identity.
impl Default for RecurrencePlot {
    fn default() -> Self {
        Self::with(Norm::Euclidean, 1)
    }
}

impl RecurrencePlot {
    /// Creates an empty plot; same as [`RecurrencePlot::default`].
    pub fn new() -> Self {
        Self::default()
    }

    /// Creates an empty plot with a norm and a Theiler window (samples).
    pub fn with(norm: Norm, theiler: usize) -> Self {
        Self {
            norm,
            theiler,
            size: 0,
            unrooted: Vec::new(),
            counted: Vec::new(),
            deviation: 0.0,
            points: Vec::new(),
            selection: Vec::new(),
        }
    }

    /// Computes the distances between the vectors with the given indices, oldest first.
    ///
    /// # Panics
    /// If an index is not below [`DelayVectors::len`].
    pub fn measure(&mut self, vectors: &DelayVectors<'_>, indices: &[usize]) {
        let n = indices.len();
        self.size = n;
        self.deviation = deviation(vectors.samples());
        let min_separation = self.theiler.max(1);
        let bounds = indices.iter().map(|&index| {
            let before =
                indices.partition_point(|&other| other.saturating_add(min_separation) <= index);
            let after =
                indices.partition_point(|&other| other < index.saturating_add(min_separation));
            (before, after)
        });
        self.counted.clear();
        self.counted.extend(bounds);
        self.points.clear();
        for coordinate in (0..vectors.dimension()).map(|c| vectors.coordinate(c)) {
            self.points.extend(indices.iter().map(|&k| coordinate[k]));
        }
        self.unrooted.clear();
        self.unrooted.resize(n * n, 0.0);
        match self.norm {
            Norm::Euclidean => self.fill(|sum, t| sum + t * t),
            Norm::Maximum => self.fill(|most, t| if t.abs() > most { t.abs() } else { most }),
            Norm::Manhattan => self.fill(|sum, t| sum + t.abs()),
        }
    }

    /// Computes all unrooted distances, coordinate by coordinate.
    fn fill(&mut self, add: impl Fn(f64, f64) -> f64) {
        let n = self.size.max(1);
        for (i, row) in self.unrooted.chunks_exact_mut(n).enumerate() {
            for coordinate in self.points.chunks_exact(n) {
                let here = coordinate[i];
                for (unrooted, there) in row.iter_mut().zip(coordinate) {
                    *unrooted = add(*unrooted, here - there);
                }
            }
        }
    }

    /// Points per side, `n`.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Number of counted pairs `i < j`: half of the pairs that the rate refers to, without the line of
    /// identity.
    pub fn pairs(&self) -> usize {
        self.counted
            .iter()
            .map(|&(_, after)| self.size - after)
            .sum()
    }

    /// Largest distance in the window, in the signal's unit.
    pub fn largest(&self) -> f64 {
        self.norm.distance_of_unrooted(self.largest_unrooted())
    }

    /// Computes the recurrence plot at a threshold.
    ///
    /// # Errors
    /// [`AnalysisError::Threshold`] as in [`quantify`](super::quantify).
    pub fn recurrences(&mut self, threshold: Threshold) -> Result<ThresholdedPlot, AnalysisError> {
        let distance = match threshold.check()? {
            Threshold::Distance(distance) => Some(distance),
            Threshold::Spread(times) => Some(times * self.deviation),
            Threshold::Rate(rate) => Some(self.distance_for_rate(rate)),
            Threshold::Neighbours(_) => None,
        };
        // Of the unrooted distances in each column.
        let limits = match (distance, threshold) {
            (None, Threshold::Neighbours(count)) => self.neighbour_limits(count),
            (distance, _) => {
                vec![self.norm.unrooted_limit(distance.unwrap_or_default()); self.size]
            }
        };
        Ok(ThresholdedPlot {
            pixels: self.pixels(&limits),
            distance,
            rate: self.share(&limits),
        })
    }

    /// Distance at which `round(rate * pairs)` pairs are recurrent: the order statistic of the distances
    /// that [`find_threshold`](super::find_threshold) computes. Pairs at equal distance are included
    /// together, which can make the actual rate larger. A rate of less than half a pair gives 0.
    fn distance_for_rate(&mut self, rate: f64) -> f64 {
        let [pairs, identity] = [self.pairs(), self.identity()].map(|count| count as u64);
        let Some(last) = rank_of_rate(rate, pairs, identity) else {
            return 0.0;
        };
        self.selection.clear();
        for (i, &(_, after)) in self.counted.iter().enumerate() {
            let later = &self.unrooted[i * self.size..][after..self.size];
            self.selection.extend(later.iter().map(|d| d.to_bits()));
        }
        let unrooted = f64::from_bits(*self.selection.select_nth_unstable(last as usize).1);
        self.norm.distance_of_unrooted(unrooted)
    }

    /// Image without a threshold, row-major: 0 for equal states, 255 for the largest distance of the
    /// window. All 0 if all states are equal.
    pub fn distance_picture(&self) -> Vec<u8> {
        let largest = self.largest_unrooted();
        let scale = if largest > 0.0 { 1.0 / largest } else { 0.0 };
        let root = self.norm == Norm::Euclidean;
        let shade = |&unrooted: &f64| {
            // Single precision exceeds the resolution of a pixel.
            let share = (unrooted * scale) as f32;
            let distance = if root { share.sqrt() } else { share };
            (distance * 255.0 + 0.5) as u8
        };
        self.unrooted.iter().map(shade).collect()
    }

    /// Limits of the columns for a fixed number of neighbours per state.
    fn neighbour_limits(&mut self, count: usize) -> Vec<f64> {
        let mut limits = Vec::with_capacity(self.size);
        for (i, &(before, after)) in self.counted.iter().enumerate() {
            // The distances are symmetric: column `i` equals row `i`.
            let column = &self.unrooted[i * self.size..][..self.size];
            let others = column[..before].iter().chain(&column[after..]);
            self.selection.clear();
            self.selection.extend(others.map(|d| d.to_bits()));
            let last = count.min(self.selection.len()).checked_sub(1);
            limits.push(last.map_or(0.0, |last| {
                f64::from_bits(*self.selection.select_nth_unstable(last).1)
            }));
        }
        limits
    }

    /// Recurrence rate, Eq. (26): share of counted pairs within the limits of their columns, 0 to 1; 0 without pairs.
    fn share(&self, limits: &[f64]) -> f64 {
        let identity = self.identity();
        let all = 2 * self.pairs() + identity;
        if all == 0 {
            return 0.0;
        }
        let within: usize = self
            .unrooted
            .chunks_exact(self.size.max(1))
            .zip(&self.counted)
            .map(|(row, &(before, after))| {
                let within = |&column: &usize| row[column] <= limits[column];
                (0..before).chain(after..self.size).filter(within).count()
            })
            .sum();
        (within + identity) as f64 / all as f64
    }

    /// Image of Eq. (26), row-major: 255 within the limits of the columns, else 0.
    fn pixels(&self, limits: &[f64]) -> Vec<u8> {
        let rows = self.unrooted.chunks_exact(self.size.max(1));
        let within = |(unrooted, limit): (&f64, &f64)| if unrooted <= limit { 255 } else { 0 };
        rows.flat_map(|row| row.iter().zip(limits).map(within))
            .collect()
    }

    /// Number of counted pairs on the line of identity, all of them recurrent.
    fn identity(&self) -> usize {
        if self.theiler == 0 { self.size } else { 0 }
    }

    fn largest_unrooted(&self) -> f64 {
        // Non-negative floating-point numbers have the order of their bit patterns, which compare
        // faster.
        let bits = self
            .unrooted
            .iter()
            .map(|unrooted| unrooted.to_bits())
            .max();
        f64::from_bits(bits.unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_signals::{noise, sines};
    use crate::{RateBase, RecurrenceCounts, RecurrenceCriterion, find_threshold, quantify};

    fn plot(signal: &[f64], lag: usize, dimension: usize) -> RecurrencePlot {
        let vectors = DelayVectors::new(signal, lag, dimension).unwrap();
        let indices: Vec<usize> = (0..vectors.len()).collect();
        let mut plot = RecurrencePlot::new();
        plot.measure(&vectors, &indices);
        plot
    }

    /// The plot at a distance.
    fn at(plot: &mut RecurrencePlot, distance: f64) -> ThresholdedPlot {
        plot.recurrences(Threshold::Distance(distance)).unwrap()
    }

    #[test]
    fn distances_match_the_definition() {
        let signal = noise(1, 90, 1e-7);
        let vectors = DelayVectors::new(&signal, 5, 4).unwrap();
        let indices: Vec<usize> = (0..vectors.len()).step_by(3).collect();
        let mut plot = RecurrencePlot::new();
        plot.measure(&vectors, &indices);
        let n = plot.size();
        assert_eq!(n, 25);
        let distance = |i: usize, j: usize| {
            let pairs = vectors.vector(indices[i]).zip(vectors.vector(indices[j]));
            pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
        };
        let direct: Vec<f64> = (0..n * n).map(|p| distance(p / n, p % n)).collect();
        let largest = direct.iter().copied().fold(0.0, f64::max);
        assert_eq!(plot.largest(), largest);
        for (pixel, d) in plot.distance_picture().iter().zip(&direct) {
            assert!((f64::from(*pixel) - 255.0 * d / largest).abs() <= 0.5 + 1e-3);
        }
        // At a threshold between two distances the image is exactly Eq. (26).
        let mut sorted = direct.clone();
        sorted.sort_by(f64::total_cmp);
        let epsilon = 0.5 * (sorted[200] + sorted[202]);
        for (pixel, d) in at(&mut plot, epsilon).pixels.iter().zip(&direct) {
            assert_eq!(*pixel == 255, *d <= epsilon);
        }
    }

    #[test]
    fn the_rate_is_within_one_pair_of_the_target() {
        let mut plot = plot(&noise(2, 300, 1.0), 7, 5);
        let one_pair = 1.0 / plot.pairs() as f64;
        for asked in [0.0, 1e-4, 0.01, 0.05, 0.3, 0.99, 1.0] {
            let epsilon = plot.distance_for_rate(asked);
            assert!(
                (at(&mut plot, epsilon).rate - asked).abs() <= one_pair,
                "{asked}"
            );
            let picture = at(&mut plot, epsilon).pixels;
            let recurrent = picture.iter().filter(|&&p| p == 255).count();
            let off_identity = (recurrent - plot.size()) as f64 / 2.0;
            assert!((off_identity * one_pair - at(&mut plot, epsilon).rate).abs() < 1e-12);
        }
    }

    #[test]
    fn images_are_symmetric_with_a_full_line_of_identity() {
        let mut plot = plot(&noise(3, 200, 1.0), 3, 3);
        let epsilon = plot.distance_for_rate(0.1);
        let n = plot.size();
        let (distance, recurrent) = (plot.distance_picture(), at(&mut plot, epsilon).pixels);
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
        // 50 samples per period and a lag of a quarter period: the delay vectors lie on a circle.
        let signal = sines(50.0, 425, &[(1.0, 1.0, 0.4)]);
        let mut plot = plot(&signal, 12, 2);
        let epsilon = plot.distance_for_rate(0.05);
        let (n, picture) = (plot.size(), at(&mut plot, epsilon).pixels);
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
    fn the_scale_of_the_signal_does_not_change_the_images() {
        let signal = noise(4, 150, 1.0);
        // A power of two scales without rounding.
        let scaled: Vec<f64> = signal.iter().map(|x| x * 2.0_f64.powi(-40)).collect();
        let (mut a, mut b) = (plot(&signal, 4, 3), plot(&scaled, 4, 3));
        assert_eq!(a.distance_picture(), b.distance_picture());
        let [p, q] = [&mut a, &mut b].map(|plot| plot.recurrences(Threshold::Rate(0.07)).unwrap());
        assert_eq!(p.pixels, q.pixels);
        assert_eq!(p.distance.map(|d| d * 2.0_f64.powi(-40)), q.distance);
    }

    #[test]
    fn a_constant_signal_is_always_recurrent() {
        let mut plot = plot(&[2.5; 40], 2, 3);
        assert_eq!(plot.largest(), 0.0);
        assert!(plot.distance_picture().iter().all(|&p| p == 0));
        assert_eq!(plot.distance_for_rate(0.05), 0.0);
        assert_eq!(at(&mut plot, 0.0).rate, 1.0);
        assert!(at(&mut plot, 0.0).pixels.iter().all(|&p| p == 255));
    }

    #[test]
    fn zero_points_and_one_point_are_valid() {
        let signal = [1.0, 2.0];
        let vectors = DelayVectors::new(&signal, 1, 1).unwrap();
        let mut plot = RecurrencePlot::new();
        for indices in [&[][..], &[1]] {
            plot.measure(&vectors, indices);
            assert_eq!(plot.pairs(), 0);
            assert_eq!(plot.distance_for_rate(0.5), 0.0);
            assert_eq!(at(&mut plot, 1.0).rate, 0.0);
            assert_eq!(at(&mut plot, 0.0).pixels.len(), indices.len());
        }
    }

    #[test]
    fn images_match_the_counts() {
        // Rounded to a grid, which puts many pairs at the same distance.
        let fine = noise(5, 150, 1.0);
        let coarse: Vec<f64> = fine.iter().map(|x| (4.0 * x).round()).collect();
        let thresholds = [
            Threshold::Distance(2.0),
            Threshold::Spread(0.7),
            Threshold::Rate(0.0),
            Threshold::Rate(0.08),
            Threshold::Rate(1.0),
            Threshold::Neighbours(4),
            Threshold::Neighbours(500),
        ];
        for (signal, norm) in [&fine, &coarse].into_iter().flat_map(|signal| {
            [Norm::Euclidean, Norm::Maximum, Norm::Manhattan].map(|norm| (signal, norm))
        }) {
            let vectors = DelayVectors::new(signal, 4, 3).unwrap();
            let indices: Vec<usize> = (0..vectors.len()).collect();
            for (threshold, theiler) in thresholds
                .iter()
                .flat_map(|&threshold| [0, 1, 9].map(|theiler| (threshold, theiler)))
            {
                let rule = RecurrenceCriterion {
                    norm,
                    threshold,
                    theiler,
                };
                let mut plot = RecurrencePlot::with(norm, theiler);
                plot.measure(&vectors, &indices);
                let picture = plot.recurrences(threshold).unwrap();
                let n = plot.size();
                let counted = RecurrenceCounts::of_matrix(n, n, theiler, |i, j| {
                    picture.pixels[i * n + j] == 255
                });
                let counts = quantify(&vectors, &rule).unwrap();
                assert_eq!(counted, counts, "{rule:?}");
                let rate = counts.measures(2, 2, RateBase::Counted).recurrence_rate;
                assert_eq!(picture.rate, rate, "{rule:?}");
                assert_eq!(picture.distance, find_threshold(&vectors, &rule).ok());
            }
        }
    }

    #[test]
    fn the_theiler_window_is_in_samples_of_the_signal() {
        let signal = noise(6, 200, 1.0);
        let vectors = DelayVectors::new(&signal, 1, 2).unwrap();
        let indices: Vec<usize> = (0..vectors.len()).step_by(10).collect();
        let counted = |theiler| {
            let mut plot = RecurrencePlot::with(Norm::Maximum, theiler);
            plot.measure(&vectors, &indices);
            let largest = plot.largest();
            assert_eq!(at(&mut plot, largest).rate, 1.0);
            plot.pairs()
        };
        let n = indices.len();
        assert_eq!(counted(0), n * (n - 1) / 2);
        assert_eq!(counted(10), n * (n - 1) / 2);
        assert_eq!(counted(11), (n - 1) * (n - 2) / 2);
        assert_eq!(counted(21), (n - 2) * (n - 3) / 2);
    }

    #[test]
    fn thresholds_out_of_range_are_rejected() {
        let mut plot = plot(&noise(7, 50, 1.0), 2, 2);
        for threshold in [
            Threshold::Distance(-1.0),
            Threshold::Spread(f64::NAN),
            Threshold::Rate(1.5),
            Threshold::Neighbours(0),
        ] {
            assert!(plot.recurrences(threshold).is_err(), "{threshold:?}");
        }
    }
}
