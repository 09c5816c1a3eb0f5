//! Orthonormal frames of tangent vectors, and when to make them.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::dynamics::System;

/// Growth, as the natural logarithm of the largest ratio of two vectors' growth, at which the
/// vectors are made orthonormal anew.
const TARGET: f64 = 3.0;

/// Measures tangent vectors and makes them orthonormal.
///
/// Lengths are those of the vibration's energy, `sum_i (omega_i^2 q_i^2 + q_i'^2) + sum_j w_j^2`:
/// exponents do not depend on it, but rounding does.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Factor of each component.
    scale: Vec<f64>,
    width: usize,
    /// The vectors scaled, one after another.
    columns: Vec<f64>,
    /// The orthonormal vectors of the start.
    first: Vec<f64>,
    /// Logarithm of the growth of each vector since the last frame.
    logarithms: Vec<f64>,
    /// Time of the last frame, s.
    last: f64,
    /// Time from one frame to the next, s; zero: at every step.
    interval: f64,
}

impl Frame {
    pub fn new<Y: System + ?Sized>(sys: &Y, width: usize, seed: u64) -> Self {
        let omega = sys.omega().iter();
        let mut scale: Vec<f64> = omega.map(|&w| if w > 0.0 { w } else { 1.0 }).collect();
        scale.resize(sys.tangent_dim(), 1.0);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let numbers = scale.len() * width;
        let first = (0..numbers).map(|_| StandardNormal.sample(&mut rng));
        let first: Vec<f64> = first.collect();
        let mut frame = Self {
            scale,
            width,
            columns: vec![0.0; numbers],
            first: Vec::new(),
            logarithms: vec![0.0; width],
            last: f64::NEG_INFINITY,
            interval: 0.0,
        };
        let mut start = first;
        frame.orthonormalise(0.0, &mut start);
        frame.first = start;
        frame
    }

    /// Writes the orthonormal vectors of the seed.
    pub fn start(&mut self, t: f64, vectors: &mut [f64]) {
        vectors.copy_from_slice(&self.first);
        self.last = t;
        self.interval = 0.0;
    }

    /// The natural logarithm of each vector's growth in the last span.
    pub fn logarithms(&self) -> &[f64] {
        &self.logarithms
    }

    /// Makes the vectors orthonormal if they have grown apart for long enough; returns the time
    /// since the last frame, s.
    pub fn orthonormalise_if_due(&mut self, t: f64, vectors: &mut [f64]) -> Option<f64> {
        if t - self.last < self.interval {
            return None;
        }
        self.orthonormalise(t, vectors)
    }

    /// Makes the vectors orthonormal; returns the time since the last frame, s, unless it is zero.
    pub fn orthonormalise(&mut self, t: f64, vectors: &mut [f64]) -> Option<f64> {
        let (n, width) = (self.scale.len(), self.width);
        let span = t - self.last;
        if span <= 0.0 {
            return None;
        }
        for (c, scale) in self.scale.iter().enumerate() {
            for l in 0..width {
                self.columns[l * n + c] = scale * vectors[c * width + l];
            }
        }
        for l in 0..width {
            let (done, rest) = self.columns.split_at_mut(l * n);
            let column = &mut rest[..n];
            // Twice is enough: the second pass removes what rounding left of the first.
            for _ in 0..2 {
                for other in done.chunks_exact(n) {
                    let part = dot(other, column);
                    for (x, y) in column.iter_mut().zip(other) {
                        *x -= part * y;
                    }
                }
            }
            let length = dot(column, column).sqrt();
            self.logarithms[l] = length.ln();
            for x in column.iter_mut() {
                *x /= length;
            }
        }
        for (c, scale) in self.scale.iter().enumerate() {
            for l in 0..width {
                vectors[c * width + l] = self.columns[l * n + c] / scale;
            }
        }
        self.last = t;
        if span.is_finite() {
            let low = self.logarithms.iter().copied().fold(0.0, f64::min);
            let high = self.logarithms.iter().copied().fold(0.0, f64::max);
            let wanted = span * (TARGET / (high - low).max(1e-3 * TARGET));
            self.interval = wanted.clamp(0.5 * self.interval, 2.0 * self.interval.max(span));
        }
        Some(span)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
