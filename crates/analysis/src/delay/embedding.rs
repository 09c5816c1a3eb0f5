//! Delay vectors, Eq. (25): state-space reconstruction from a single signal.
//!
//! One signal of a system with several degrees of freedom contains the others: its values now, one lag
//! ago, two lags ago, ... are coordinates in which the attractor unfolds (Takens 1981).

use std::sync::atomic::{AtomicBool, Ordering};

use crate::AnalysisError;

/// Eq. (25): `y_n = (u[n - (m-1) tau], ..., u[n - tau], u[n])`, as a view of the samples `u`.
///
/// The newest coordinate of vector `i` is sample `i + (m-1) tau`. No samples are copied.
#[derive(Clone, Copy, Debug)]
pub struct DelayVectors<'a> {
    samples: &'a [f64],
    lag: usize,
    dimension: usize,
    stop: Option<&'a AtomicBool>,
}

impl<'a> DelayVectors<'a> {
    /// Delay vectors of `samples` with lag `tau` (samples) and embedding dimension `m`.
    ///
    /// # Errors
    /// [`AnalysisError::InvalidDelay`] for a lag or dimension of 0; [`AnalysisError::TooShort`] if there
    /// are too few samples for one vector.
    pub fn new(samples: &'a [f64], lag: usize, dimension: usize) -> Result<Self, AnalysisError> {
        if lag == 0 || dimension == 0 {
            return Err(AnalysisError::InvalidDelay { lag, dimension });
        }
        let need = Self::samples_for(1, lag, dimension);
        AnalysisError::check_length("delay vectors", samples.len(), need)?;
        Ok(Self {
            samples,
            lag,
            dimension,
            stop: None,
        })
    }

    /// Sets a flag that ends long computations over the vectors once it is true. Their results are then meaningless.
    pub fn with_stop(self, stop: &'a AtomicBool) -> Self {
        let stop = Some(stop);
        Self { stop, ..self }
    }

    /// Whether that flag is set.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
    }

    /// Number of samples needed for `count` vectors (dimension at least 1). Saturates at `usize::MAX`.
    pub fn samples_for(count: usize, lag: usize, dimension: usize) -> usize {
        count.saturating_add((dimension - 1).saturating_mul(lag))
    }

    /// Number of vectors, at least 1.
    #[allow(
        clippy::len_without_is_empty,
        reason = "a view without a vector cannot be constructed"
    )]
    pub fn len(&self) -> usize {
        self.samples.len() - (self.dimension - 1) * self.lag
    }

    /// The samples `u`.
    pub fn samples(&self) -> &'a [f64] {
        self.samples
    }

    /// Lag `tau`, samples.
    pub fn lag(&self) -> usize {
        self.lag
    }

    /// Embedding dimension `m`.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Coordinate `c` (0 the oldest, `m - 1` the newest) of all vectors, in order.
    pub fn coordinate(&self, c: usize) -> &'a [f64] {
        &self.samples[c * self.lag..][..self.len()]
    }

    /// Coordinates of vector `i`, oldest first.
    pub fn vector(&self, i: usize) -> impl Iterator<Item = f64> + 'a {
        let samples = &self.samples[i..];
        samples
            .iter()
            .copied()
            .step_by(self.lag)
            .take(self.dimension)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_match_the_equation() {
        let u: Vec<f64> = (0..10).map(|k| f64::from(k * k)).collect();
        let y = DelayVectors::new(&u, 3, 3).unwrap();
        assert_eq!(y.len(), 4);
        for i in 0..y.len() {
            let n = i + 6;
            let expected = [u[n - 6], u[n - 3], u[n]];
            assert!(y.vector(i).eq(expected));
            assert!((0..3).all(|c| y.coordinate(c)[i] == expected[c]));
        }
        assert_eq!(DelayVectors::samples_for(y.len(), 3, 3), u.len());
    }

    #[test]
    fn invalid_embeddings_are_rejected() {
        let u = [0.0; 6];
        assert_eq!(
            DelayVectors::new(&u, 3, 3).unwrap_err(),
            AnalysisError::TooShort {
                what: "delay vectors",
                have: 6,
                need: 7
            }
        );
        assert!(DelayVectors::new(&u, 0, 3).is_err());
        assert!(DelayVectors::new(&u, 1, 0).is_err());
        assert_eq!(DelayVectors::new(&u, 9, 1).unwrap().len(), 6);
        // Spans of 2^64 and more.
        assert!(DelayVectors::new(&u, 1 << 63, 3).is_err());
        assert!(DelayVectors::new(&u, usize::MAX, usize::MAX).is_err());
    }
}
