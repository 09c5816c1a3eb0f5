//! The workspace of a Runge–Kutta method and its step.
//!
//! The step is written once, for any [`Tableau`] and any [`Picture`]; nothing is allocated after
//! [`Stepper::new`].

use super::System;
use super::tableau::Tableau;

/// The coordinates `y` to which a Runge–Kutta method is applied, anchored at the step's start:
/// there `y` and the state `z` are the same.
pub(super) trait Picture {
    /// Writes the part of `dz/dt` at time `t` and state `z` that this picture leaves to the
    /// method; components that it takes exactly are zero.
    fn slope<Y: System + ?Sized>(&self, sys: &Y, t: f64, z: &[f64], out: &mut [f64]);

    /// Makes ready for a step of length `h` (s) with stages at the fractions `nodes` of it.
    fn prepare(&mut self, nodes: &[f64], h: f64);

    /// Turns a slope of `z` at a stage into the slope of `y`, in place.
    fn pull(&self, stage: usize, slope: &mut [f64]);

    /// Turns `y` into the state `z` at a stage, in place.
    fn push(&self, stage: usize, y: &mut [f64]);

    /// Turns `y` into the state `z` at `offset` (s) after the step's start, in place.
    fn push_by(&mut self, offset: f64, y: &mut [f64]);
}

/// One method at work: its last step, from `start` to `end`, with all that a sample in between
/// needs.
#[derive(Clone, Debug)]
pub(super) struct Stepper<P, const S: usize> {
    /// The method's coefficients.
    pub tableau: &'static Tableau<S>,
    /// The method's coordinates.
    pub picture: P,
    /// Start of the last step, s.
    pub start_time: f64,
    /// State at the start of the last step.
    pub start: Vec<f64>,
    /// End of the last step, s.
    pub end_time: f64,
    /// State at the end of the last step.
    pub end: Vec<f64>,
    /// Slope of the state at the end of the last step.
    pub end_slope: Vec<f64>,
    /// Estimated error of `end`; zero without an embedded method.
    pub error: Vec<f64>,
    /// Slopes of `y` at the stages, `stages x dim`, row-major.
    pub slopes: Vec<f64>,
}

impl<P: Picture, const S: usize> Stepper<P, S> {
    /// A workspace for states of length `dim`.
    pub fn new(tableau: &'static Tableau<S>, picture: P, dim: usize) -> Self {
        let zeros = vec![0.0; dim];
        Self {
            tableau,
            picture,
            start_time: 0.0,
            start: zeros.clone(),
            end_time: 0.0,
            end: zeros.clone(),
            end_slope: zeros.clone(),
            error: zeros,
            slopes: vec![0.0; S * dim],
        }
    }

    /// The length of the state.
    pub fn dim(&self) -> usize {
        self.start.len()
    }

    /// Evaluates the system afresh at the present state, and forgets the step that led to it.
    pub fn refresh<Y: System + ?Sized>(&mut self, sys: &Y) {
        self.start_time = self.end_time;
        self.start.copy_from_slice(&self.end);
        self.picture
            .slope(sys, self.end_time, &self.end, &mut self.end_slope);
        self.follow();
    }

    /// Lets the next step start where the last one ended.
    pub fn follow(&mut self) {
        let dim = self.dim();
        self.start_time = self.end_time;
        self.start.copy_from_slice(&self.end);
        self.slopes[..dim].copy_from_slice(&self.end_slope);
    }

    /// Takes the last step back.
    pub fn rewind(&mut self) {
        let dim = self.dim();
        self.end_time = self.start_time;
        self.end.copy_from_slice(&self.start);
        self.end_slope.copy_from_slice(&self.slopes[..dim]);
    }

    /// Tries the step from `start_time` to `end_time`. It overwrites any step tried from there
    /// before, so that a rejected step needs no undoing. Costs `S - 1` calls.
    pub fn attempt<Y: System + ?Sized>(&mut self, sys: &Y, end_time: f64) {
        let dim = self.dim();
        let h = end_time - self.start_time;
        self.end_time = end_time;
        self.picture.prepare(&self.tableau.nodes, h);
        for stage in 1..S {
            let (known, new) = self.slopes.split_at_mut(stage * dim);
            let slope = &mut new[..dim];
            self.end.copy_from_slice(&self.start);
            accumulate(
                &mut self.end,
                h,
                known,
                &self.tableau.stages[stage][..stage],
            );
            self.picture.push(stage, &mut self.end);
            let time = self.start_time + self.tableau.nodes[stage] * h;
            self.picture.slope(sys, time, &self.end, slope);
            if stage == S - 1 {
                self.end_slope.copy_from_slice(slope);
            }
            self.picture.pull(stage, slope);
        }
        self.error.fill(0.0);
        accumulate(&mut self.error, h, &self.slopes, &self.tableau.error);
        self.picture.push(S - 1, &mut self.error);
    }
}

/// Adds `h sum_j weights[j] slopes[j]` to `y`.
pub(super) fn accumulate(y: &mut [f64], h: f64, slopes: &[f64], weights: &[f64]) {
    // The number of terms as a constant lets the compiler keep each component's sum in a register.
    match weights.len() {
        1 => accumulate_terms::<1>(y, h, slopes, weights),
        2 => accumulate_terms::<2>(y, h, slopes, weights),
        3 => accumulate_terms::<3>(y, h, slopes, weights),
        4 => accumulate_terms::<4>(y, h, slopes, weights),
        5 => accumulate_terms::<5>(y, h, slopes, weights),
        6 => accumulate_terms::<6>(y, h, slopes, weights),
        7 => accumulate_terms::<7>(y, h, slopes, weights),
        terms => unreachable!("no tableau has {terms} terms"),
    }
}

/// [`accumulate`] with `N` terms.
fn accumulate_terms<const N: usize>(y: &mut [f64], h: f64, slopes: &[f64], weights: &[f64]) {
    let dim = y.len();
    let weights: [f64; N] = std::array::from_fn(|j| weights[j]);
    let slopes: [&[f64]; N] = std::array::from_fn(|j| &slopes[j * dim..][..dim]);
    for (i, y) in y.iter_mut().enumerate() {
        let mut sum = weights[0] * slopes[0][i];
        for j in 1..N {
            sum += weights[j] * slopes[j][i];
        }
        *y += h * sum;
    }
}
