//! Orthonormal frames of tangent vectors, and when to make them.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::dynamics::System;

/// Growth, as the natural logarithm of the largest ratio of two vectors' growth, at which the
/// vectors are made orthonormal anew: three of sixteen digits are given up at most places.
const TARGET: f64 = 7.0;

/// Steps after which the vectors are made orthonormal whatever the last growth was. Within a step an
/// explicit method shrinks nothing by much more than a factor of `e^3`, so that a sudden contraction
/// leaves some digits even so.
const MOST_STEPS: u32 = 8;

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
    /// Steps since the last frame.
    steps: u32,
    /// Steps from one frame to the next.
    interval: u32,
}

impl Frame {
    pub fn new<Y: System + ?Sized>(sys: &Y, width: usize, seed: u64) -> Self {
        let omega = sys.omega().iter();
        let mut scale: Vec<f64> = omega.map(|&w| if w > 0.0 { w } else { 1.0 }).collect();
        scale.resize(sys.tangent_dim(), 1.0);
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

    /// Writes the orthonormal vectors of the seed.
    pub fn start(&mut self, vectors: &mut [f64]) {
        vectors.copy_from_slice(&self.first);
        self.steps = 0;
        self.interval = 1;
    }

    /// The natural logarithm of each vector's growth up to the last frame, from the one before it;
    /// minus infinity for a direction that has collapsed.
    pub fn logarithms(&self) -> &[f64] {
        &self.logarithms
    }

    /// Counts a step; whether it is time for a new frame.
    pub fn is_due(&mut self) -> bool {
        self.steps += 1;
        self.steps >= self.interval
    }

    /// Makes a new frame due at the next step: a jump may have pressed the vectors together.
    pub fn hasten(&mut self) {
        self.steps = self.interval;
    }

    /// Makes the vectors orthonormal by the method of Gram and Schmidt (modified, done twice), and
    /// chooses the number of steps to the next frame.
    ///
    /// A vector of which only rounding errors are left is a direction that has collapsed. Its growth
    /// is minus infinity, and a fresh vector takes its place.
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

    /// So many steps that the vectors grow apart by about [`TARGET`], at their last rate.
    fn choose_interval(&mut self) {
        let finite = self.logarithms.iter().copied().filter(|x| x.is_finite());
        let low = finite.clone().fold(0.0, f64::min);
        let high = finite.fold(0.0, f64::max);
        let apart = (high - low) / f64::from(self.steps.max(1));
        let wanted = (TARGET / apart).min(f64::from(MOST_STEPS)) as u32;
        self.interval = wanted.clamp(1, 2 * self.interval);
        self.steps = 0;
    }
}

/// Takes from `column` its parts along the orthonormal vectors `done`. Twice is enough: the second
/// pass removes what rounding left of the first.
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

/// Puts a unit vector orthogonal to the orthonormal vectors `done` into `column`: what is left of
/// the axis that they cover least.
fn replace(column: &mut [f64], done: &[f64]) {
    let n = column.len();
    let covered = |axis: usize| -> f64 { done.iter().skip(axis).step_by(n).map(|x| x * x).sum() };
    let mut least = 0;
    for axis in 1..n {
        if covered(axis) < covered(least) {
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
