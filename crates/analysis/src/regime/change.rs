//! Lasting changes of a motion within the record.

use crate::stats::mean;

/// Sections of the record whose levels and periods are compared.
pub(super) const SECTIONS: usize = 8;

/// Least scatter of equal levels, natural logarithm.
const MIN_SCATTER: f64 = 0.02;

/// A change from one level, held in all sections before it, to another, held in all sections after it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    /// Change of the natural logarithm.
    pub size: f64,
    /// Change over its standard error (Welch's statistic with a pooled variance).
    pub significance: f64,
}

impl Change {
    /// The most significant change of the logarithms of levels and of differences.
    pub(super) fn most_significant(
        levels: &[f64; SECTIONS],
        differences: Option<&[f64; SECTIONS]>,
    ) -> Option<Self> {
        // At least two sections on either side of the one that contains the change.
        let all = std::iter::once(levels)
            .chain(differences)
            .flat_map(|values| (2..SECTIONS - 2).map(move |k| Self::at(values, k)));
        all.max_by(|a, b| a.significance.total_cmp(&b.significance))
    }

    /// The change in section `k`.
    fn at(values: &[f64; SECTIONS], k: usize) -> Self {
        let squares = |part: &[f64]| part.iter().map(|x| (x - mean(part)).powi(2)).sum::<f64>();
        let (before, after) = (&values[..k], &values[k + 1..]);
        let [a, b] = [before, after].map(|part| part.len() as f64);
        let variance = (squares(before) + squares(after)) / (a + b - 2.0);
        let error = (variance.max(MIN_SCATTER * MIN_SCATTER) * (1.0 / a + 1.0 / b)).sqrt();
        let size = mean(after) - mean(before);
        Self {
            size,
            significance: size.abs() / error,
        }
    }
}
