//! The growth of tangent vectors, and what it says of the exponents.

use super::batches::{Batches, Part};
use super::interval::{bounded, independent};
use super::{Exponent, LyapunovSpectrum, Sign};

/// Within this factor a neutral vector may change its length at any time.
const NEUTRAL: f64 = 10.0;

/// How tangent vectors have grown.
#[derive(Clone, Debug)]
pub(in crate::dynamics) struct Growth {
    /// Logarithms of the growth of each vector, in all.
    sums: Vec<f64>,
    batches: Batches,
}

impl Growth {
    pub fn new(width: usize) -> Self {
        Self {
            sums: vec![0.0; width],
            batches: Batches::new(width),
        }
    }

    /// Forgets all growth up to time `t` (s).
    pub fn clear(&mut self, t: f64) {
        self.sums.fill(0.0);
        self.batches.clear(t);
    }

    /// The time up to which growth is known, s.
    pub fn last(&self) -> f64 {
        self.batches.last()
    }

    /// Adds the logarithms of the growth of each vector since the last time, up to time `t` (s).
    pub fn push(&mut self, t: f64, logarithms: &[f64]) {
        for (sum, logarithm) in self.sums.iter_mut().zip(logarithms) {
            *sum += logarithm;
        }
        self.batches.push(t, logarithms);
    }

    /// Eq. (23): `lambda_i = lim 1/t ln |m_i(t)|`, by the growth so far. Before any growth the
    /// exponents are zero with intervals without end.
    ///
    /// In a time shorter than `patience` (s), growth that decays slowly looks neutral. What would
    /// count as zero then gets an interval of twice the resolution, and is doubtful.
    pub fn spectrum(&self, dimension: usize, patience: f64) -> LyapunovSpectrum {
        let time = self.time();
        let mut resolution = if time > 0.0 {
            NEUTRAL.ln() / time
        } else {
            f64::INFINITY
        };
        let mut exponents = Vec::with_capacity(self.sums.len());
        for (l, sum) in self.sums.iter().enumerate() {
            let value = if time > 0.0 { sum / time } else { 0.0 };
            let parts: Vec<Part> = self.each(|batch| self.batches.get(batch, l));
            let half_width = match (value, bounded(&parts)) {
                (f64::NEG_INFINITY, _) => 0.0,
                (_, Some(range)) => {
                    resolution = resolution.max(range / time);
                    range / time
                }
                _ => self.half_width(|batch| self.batches.get(batch, l).growth),
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
        if time < patience {
            for k in 0..spectrum.exponents.len() {
                if spectrum.sign(k) == Sign::Zero {
                    spectrum.exponents[k].half_width = 2.0 * spectrum.resolution;
                }
            }
        }
        spectrum.kaplan_yorke = self.kaplan_yorke(&spectrum);
        spectrum
    }

    /// Time over which growth is known, s.
    fn time(&self) -> f64 {
        self.batches.last() - self.batches.start()
    }

    /// Something of each full batch.
    fn each<T>(&self, get: impl Fn(usize) -> T) -> Vec<T> {
        (0..self.batches.count()).map(get).collect()
    }

    /// Half the width of the interval of something linear in the growth, given by batch; 1/s.
    fn half_width(&self, growth: impl Fn(usize) -> f64) -> f64 {
        independent(&self.each(growth)) / self.batches.length()
    }

    /// The dimension by the exponents; its interval by what each batch would add to its error, to
    /// first order. Where the sum so far is zero, a dimension hangs on whether the next exponent is
    /// zero, too: none is told if that is doubtful. Above zero, the dimension passes smoothly.
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
            if sum == 0.0 && spectrum.sign(k) == Sign::Doubtful {
                return None;
            }
            let next = value(k);
            if sum + next < 0.0 {
                let half_width = if k == 0 || next == f64::NEG_INFINITY {
                    0.0
                } else {
                    let change = |batch: usize| {
                        let first: f64 = (0..k).map(|l| self.batches.get(batch, l).growth).sum();
                        let last = self.batches.get(batch, k).growth;
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
