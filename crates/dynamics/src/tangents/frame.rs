//! Orthonormal frames of tangent vectors and the intervals between them.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::System;
use crate::system::energy_units;

/// Target for the natural logarithm of the ratio between the largest and smallest growth over one
/// interval. At this value three of sixteen digits are lost.
const TARGET_LOG_RATIO: f64 = 7.0;

/// Maximum number of steps between orthonormalisations. A step of an explicit method contracts by a
/// factor of at most about `e^3`, so a sudden contraction still leaves some digits.
const MAX_INTERVAL: u32 = 8;

/// Measures and orthonormalises tangent vectors.
///
/// The norm is that of the vibration energy, `sum_i (omega_i^2 q_i^2 + q_i'^2) + sum_j w_j^2`. Lyapunov
/// exponents do not depend on the norm, but rounding errors do.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Weight of each component.
    scale: Vec<f64>,
    width: usize,
    /// The scaled vectors, one after another.
    columns: Vec<f64>,
    /// The initial orthonormal vectors.
    first: Vec<f64>,
    /// Natural logarithm of the growth of each vector over the last interval; minus infinity for a collapsed direction.
    pub logarithms: Vec<f64>,
    /// Steps since the last orthonormalisation.
    steps: u32,
    /// Steps between orthonormalisations.
    interval: u32,
}

impl Frame {
    pub fn new(sys: &dyn System, width: usize, seed: u64) -> Self {
        let scale = energy_units(sys);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let numbers = scale.len() * width;
        let mut first: Vec<f64> = (0..numbers)
            .map(|_| StandardNormal.sample(&mut rng))
            .collect();
        let mut frame = Self {
            scale,
            width,
            columns: vec![0.0; numbers],
            first: Vec::new(),
            logarithms: vec![0.0; width],
            steps: 0,
            interval: 1,
        };
        frame.orthonormalise(&mut first);
        frame.first = first;
        frame
    }

    /// Writes the initial orthonormal vectors.
    pub fn start(&mut self, vectors: &mut [f64]) {
        vectors.copy_from_slice(&self.first);
        self.steps = 0;
        self.interval = 1;
    }

    /// Counts a step and returns whether orthonormalisation is due.
    pub fn is_due(&mut self) -> bool {
        self.steps += 1;
        self.steps >= self.interval
    }

    /// Makes orthonormalisation due at the next step, because a jump may have aligned the vectors.
    pub fn require_next(&mut self) {
        self.steps = self.interval;
    }

    /// Orthonormalises the vectors by the modified Gram–Schmidt method, applied twice, and sets the
    /// interval to the next orthonormalisation.
    ///
    /// A vector that consists of rounding errors only is a collapsed direction. Its growth is minus
    /// infinity, and it is replaced by a new vector.
    pub fn orthonormalise(&mut self, vectors: &mut [f64]) {
        let (n, width) = (self.scale.len(), self.width);
        let rounding = 16.0 * n as f64 * f64::EPSILON;
        for (c, scale) in self.scale.iter().enumerate() {
            for l in 0..width {
                self.columns[l * n + c] = scale * vectors[c * width + l];
            }
        }
        for l in 0..width {
            let (done, rest) = self.columns.split_at_mut(l * n);
            let column = &mut rest[..n];
            let before = length(column);
            make_orthogonal(column, done);
            let after = length(column);
            if after > rounding * before || !after.is_finite() {
                self.logarithms[l] = after.ln();
                column.iter_mut().for_each(|x| *x /= after);
            } else {
                self.logarithms[l] = f64::NEG_INFINITY;
                replace(column, done);
            }
        }
        for (c, scale) in self.scale.iter().enumerate() {
            for l in 0..width {
                vectors[c * width + l] = self.columns[l * n + c] / scale;
            }
        }
        self.choose_interval();
    }

    /// Sets the interval so that the vectors separate by about [`TARGET_LOG_RATIO`] at their last rate.
    fn choose_interval(&mut self) {
        let finite = self.logarithms.iter().copied().filter(|x| x.is_finite());
        let low = finite.clone().fold(0.0, f64::min);
        let high = finite.fold(0.0, f64::max);
        let apart = (high - low) / f64::from(self.steps.max(1));
        let wanted = (TARGET_LOG_RATIO / apart).min(f64::from(MAX_INTERVAL)) as u32;
        self.interval = wanted.clamp(1, 2 * self.interval);
        self.steps = 0;
    }
}

/// Removes the components of `column` along the orthonormal vectors `done`. The second pass removes the
/// rounding error of the first.
fn make_orthogonal(column: &mut [f64], done: &[f64]) {
    for _ in 0..2 {
        for other in done.chunks_exact(column.len()) {
            let part = dot(other, column);
            for (x, y) in column.iter_mut().zip(other) {
                *x -= part * y;
            }
        }
    }
}

/// Writes a unit vector orthogonal to the orthonormal vectors `done` to `column`: the orthogonal part of
/// the axis with the smallest component along them.
fn replace(column: &mut [f64], done: &[f64]) {
    let n = column.len();
    let projection =
        |axis: usize| -> f64 { done.iter().skip(axis).step_by(n).map(|x| x * x).sum() };
    let mut least = 0;
    for axis in 1..n {
        if projection(axis) < projection(least) {
            least = axis;
        }
    }
    column.fill(0.0);
    column[least] = 1.0;
    make_orthogonal(column, done);
    let length = length(column);
    column.iter_mut().for_each(|x| *x /= length);
}

fn length(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
