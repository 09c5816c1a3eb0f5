//! Accumulated growth of tangent vectors and the Lyapunov exponents derived from it.

use super::batches::{Growth, GrowthInterval};
use super::interval::{self, bounded_range};
use super::{Exponent, LyapunovSpectrum, Sign};

/// Factor by which a neutral vector may change its length at any time.
const NEUTRAL_FACTOR: f64 = 10.0;

impl Growth {
    /// Eq. (23): `lambda_i = lim 1/t ln |m_i(t)|`, from the growth so far. Before any growth the
    /// exponents are zero with infinite intervals.
    ///
    /// Over a time shorter than `min_time_for_zero` (s), slowly decaying growth looks neutral. An exponent that
    /// would count as zero then gets an interval of twice the resolution and is undetermined.
    pub fn spectrum(&self, dimension: usize, min_time_for_zero: f64) -> LyapunovSpectrum {
        let time = self.time();
        let mut resolution = if time > 0.0 {
            NEUTRAL_FACTOR.ln() / time
        } else {
            f64::INFINITY
        };
        let mut exponents = Vec::with_capacity(self.width);
        for l in 0..self.width {
            let value = if time > 0.0 {
                self.total(l) / time
            } else {
                0.0
            };
            let parts: Vec<GrowthInterval> = self.per_batch(|batch| self.get(batch, l));
            let half_width = match (value, bounded_range(&parts)) {
                (f64::NEG_INFINITY, _) => 0.0,
                (_, Some(range)) => {
                    resolution = resolution.max(range / time);
                    range / time
                }
                _ => self.half_width(|batch| self.get(batch, l).growth),
            };
            exponents.push(Exponent { value, half_width });
        }
        let mut spectrum = LyapunovSpectrum {
            exponents,
            time,
            dimension,
            resolution,
            kaplan_yorke: None,
        };
        if time < min_time_for_zero {
            for k in 0..spectrum.exponents.len() {
                if spectrum.sign(k) == Sign::Zero {
                    spectrum.exponents[k].half_width = 2.0 * spectrum.resolution;
                }
            }
        }
        spectrum.kaplan_yorke = self.kaplan_yorke(&spectrum);
        spectrum
    }

    /// Averaging time, s.
    fn time(&self) -> f64 {
        self.last - self.start
    }

    /// Collects a quantity over all full batches.
    fn per_batch<T>(&self, get: impl Fn(usize) -> T) -> Vec<T> {
        (0..self.count()).map(get).collect()
    }

    /// Half-width of the interval of a quantity linear in the growth, given per batch; 1/s.
    fn half_width(&self, growth: impl Fn(usize) -> f64) -> f64 {
        interval::half_width(&self.per_batch(growth)) / self.length
    }

    /// The Kaplan–Yorke dimension. Its interval follows from the contributions of each batch to its
    /// error, to first order. If the sum so far is zero, the dimension depends on whether the next
    /// exponent is zero, too; it is `None` if that is undetermined. For a positive sum it is a smooth
    /// function of the exponents.
    fn kaplan_yorke(&self, spectrum: &LyapunovSpectrum) -> Option<Exponent> {
        if spectrum.time <= 0.0 {
            return None;
        }
        let value = |k: usize| match spectrum.sign(k) {
            Sign::Zero => 0.0,
            _ => spectrum.exponents[k].value,
        };
        let mut sum = 0.0;
        for k in 0..spectrum.exponents.len() {
            if sum == 0.0 && spectrum.sign(k) == Sign::Undetermined {
                return None;
            }
            let next = value(k);
            if sum + next < 0.0 {
                let half_width = if k == 0 || next == f64::NEG_INFINITY {
                    0.0
                } else {
                    let change = |batch: usize| {
                        let first: f64 = (0..k).map(|l| self.get(batch, l).growth).sum();
                        let last = self.get(batch, k).growth;
                        first / next.abs() + sum * last / next.powi(2)
                    };
                    self.half_width(change)
                };
                return Some(Exponent {
                    value: k as f64 + sum / next.abs(),
                    half_width,
                });
            }
            sum += next;
        }
        (spectrum.exponents.len() == spectrum.dimension).then_some(Exponent {
            value: spectrum.dimension as f64,
            half_width: 0.0,
        })
    }
}
