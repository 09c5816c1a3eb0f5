//! Explicit Runge–Kutta methods: the step and the states between its ends.
//!
//! The step is written once, for any [`Tableau`] and any [`Picture`].
//!
//! The stages of a step determine a polynomial in the picture's coordinates,
//! `y(t_n + theta h) = y_n + h sum_i b_i(theta) k_i`. In the interaction picture the polynomial has
//! only the effect of the force to follow; the free vibration at the sample's own time is then put
//! back exactly. With some tableaus it needs stages of its own, which are evaluated where a state
//! between the ends is asked for.

use super::control::{Rule, Size};
use super::stepper::{Step, Stepper, differentiable, force, switching};
use super::tableau::Tableau;
use super::tangents::Bundle;
use super::{System, Tally};

/// The coordinates `y` to which a Runge–Kutta method is applied, anchored at the step's start:
/// there `y` and the state `z` are the same.
///
/// What applies to a state applies to tangent vectors, too, since a picture is linear: `width` of
/// them side by side, component after component. A width of 1 is a state.
pub(super) trait Picture {
    /// Completes a slope `[. | f | g]` at `z` by the part that this picture leaves to the method;
    /// components that it takes exactly become zero.
    fn complete<Y: System + ?Sized>(&self, sys: &Y, z: &[f64], slope: &mut [f64], width: usize);

    /// Makes ready for a step of length `h` (s) with stages at the fractions `nodes` of it.
    fn prepare(&mut self, nodes: &[f64], h: f64);

    /// Turns a slope of `z` at a stage into the slope of `y`, in place.
    fn pull(&self, stage: usize, slope: &mut [f64], width: usize);

    /// Turns `y` into the state `z` at a stage, in place.
    fn push(&self, stage: usize, y: &mut [f64], width: usize);

    /// Turns `y` into the state `z` at `offset` (s) after the step's start, in place.
    fn push_by(&mut self, offset: f64, y: &mut [f64], width: usize);

    /// Takes over the linear part of a changed system with as many modes.
    fn reread<Y: System + ?Sized>(&mut self, _sys: &Y) {}

    /// The longest step that the linear part allows, s.
    fn longest_step(&self) -> f64 {
        f64::INFINITY
    }
}

/// A tableau in a picture.
#[derive(Clone, Debug)]
pub(super) struct RungeKutta<P, const S: usize> {
    /// The method's coefficients.
    pub tableau: &'static Tableau<S>,
    /// The method's coordinates.
    pub picture: P,
    pub step: Step,
    /// Slopes of `y` at the stages, `stages x dim`, row-major.
    pub slopes: Vec<f64>,
    /// The state at a stage beside the step.
    beside: Vec<f64>,
    /// The second estimate of the error, where there is one.
    coarse_error: Vec<f64>,
    /// Whether the stages of the dense output are those of the last step.
    is_dense: bool,
    /// A record a stage, where tangent vectors follow the steps; else none.
    records: Vec<Vec<f64>>,
}

impl<P: Picture, const S: usize> RungeKutta<P, S> {
    /// A workspace for states of length `dim`.
    pub fn new(tableau: &'static Tableau<S>, picture: P, dim: usize) -> Self {
        Self {
            tableau,
            picture,
            step: Step::new(dim),
            slopes: vec![0.0; S * dim],
            beside: vec![0.0; dim],
            coarse_error: vec![0.0; dim],
            is_dense: false,
            records: Vec::new(),
        }
    }

    /// Exchanges the records at the step's two ends.
    fn hand_over_record(&mut self) {
        if !self.records.is_empty() {
            self.records.swap(0, self.tableau.end);
        }
    }

    /// Makes the slope at the step's end that at its start.
    fn hand_over_slope(&mut self) {
        let dim = self.step.dim();
        self.slopes[..dim].copy_from_slice(&self.step.end_slope);
    }

    /// Writes the slope of the state `z` at `time` (s) as that of a stage, not yet pulled.
    fn slope<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        stage: usize,
        time: f64,
        place: Place,
    ) {
        let z = match place {
            Place::End => &self.step.end,
            Place::Beside => &self.beside,
        };
        let dim = z.len();
        let slope = &mut self.slopes[stage * dim..][..dim];
        let out = &mut slope[sys.modes()..];
        match self.records.get_mut(stage) {
            None => force(sys, status, time, z, out),
            Some(record) => differentiable(sys).force_recorded(status, time, z, out, record),
        }
        self.picture.complete(sys, z, slope, 1);
    }
}

/// Where the state of a stage stands.
#[derive(Clone, Copy)]
enum Place {
    /// At the end of the step, which it may become.
    End,
    /// Beside the step.
    Beside,
}

impl<P: Picture, const S: usize> Stepper for RungeKutta<P, S> {
    fn step(&self) -> &Step {
        &self.step
    }

    fn step_mut(&mut self) -> &mut Step {
        &mut self.step
    }

    fn rule(&self) -> &'static Rule {
        &self.tableau.rule
    }

    fn reread<Y: System + ?Sized>(&mut self, sys: &Y) {
        self.picture.reread(sys);
    }

    fn longest_step(&self) -> f64 {
        self.picture.longest_step()
    }

    fn refresh<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>, tally: &mut Tally) {
        let end = self.tableau.end;
        tally.calls += 1;
        self.slope(sys, status, end, self.step.end_time, Place::End);
        let dim = self.step.dim();
        self.step
            .end_slope
            .copy_from_slice(&self.slopes[end * dim..][..dim]);
        self.step.reach_time = self.step.end_time;
        // The record stays at the end, where the next step takes it from.
        self.step.anchor();
        self.hand_over_slope();
    }

    fn follow<Y: System + ?Sized>(&mut self, _sys: &Y, _status: Option<&[u8]>, _tally: &mut Tally) {
        self.step.anchor();
        self.hand_over_slope();
        self.hand_over_record();
    }

    fn rewind(&mut self) {
        let dim = self.step.dim();
        self.step.undo();
        self.step.end_slope.copy_from_slice(&self.slopes[..dim]);
        self.hand_over_record();
    }

    fn attempt<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        end_time: f64,
        tally: &mut Tally,
    ) {
        let dim = self.step.dim();
        self.step.end_time = end_time;
        self.step.reach_time = end_time;
        self.is_dense = false;
        let h = self.step.length();
        let tableau = self.tableau;
        self.picture.prepare(&tableau.nodes, h);
        for stage in 1..=tableau.end {
            self.step.end.copy_from_slice(&self.step.start);
            let weights = &tableau.stages[stage][..stage];
            accumulate(&mut self.step.end, h, &self.slopes, weights);
            self.picture.push(stage, &mut self.step.end, 1);
            let time = self.step.start_time + tableau.nodes[stage] * h;
            if let (true, Some(status)) = (stage == tableau.end, status) {
                switching(sys).settle(status, end_time, &mut self.step.end);
            }
            self.slope(sys, status, stage, time, Place::End);
            let slope = &mut self.slopes[stage * dim..][..dim];
            if stage == tableau.end {
                self.step.end_slope.copy_from_slice(slope);
            }
            self.picture.pull(stage, slope, 1);
        }
        let stages = tableau.end + 1;
        self.step.error.fill(0.0);
        accumulate(
            &mut self.step.error,
            h,
            &self.slopes,
            &tableau.error[..stages],
        );
        self.picture.push(tableau.end, &mut self.step.error, 1);
        if let Some(weights) = &tableau.coarse_error {
            self.coarse_error.fill(0.0);
            accumulate(&mut self.coarse_error, h, &self.slopes, &weights[..stages]);
            self.picture.push(tableau.end, &mut self.coarse_error, 1);
        }
        tally.calls += tableau.end as u64;
    }

    fn error(&self, omega: &[f64]) -> Size {
        let error = Size::of(&self.step.error, omega);
        match self.tableau.coarse_error {
            None => error,
            Some(_) => error.sharpened(Size::of(&self.coarse_error, omega)),
        }
    }

    fn densify<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>, tally: &mut Tally) {
        let tableau = self.tableau;
        if self.is_dense || self.step.length() == 0.0 {
            return;
        }
        self.is_dense = true;
        let (dim, h) = (self.step.dim(), self.step.length());
        for stage in tableau.end + 1..S {
            self.beside.copy_from_slice(&self.step.start);
            let weights = &tableau.stages[stage][..stage];
            accumulate(&mut self.beside, h, &self.slopes, weights);
            self.picture.push(stage, &mut self.beside, 1);
            let time = self.step.start_time + tableau.nodes[stage] * h;
            self.slope(sys, status, stage, time, Place::Beside);
            self.picture
                .pull(stage, &mut self.slopes[stage * dim..][..dim], 1);
        }
        tally.calls += (S - 1 - tableau.end) as u64;
    }

    fn interpolate(&mut self, t: f64, out: &mut [f64]) {
        if let Some(state) = self.step.at_end(t) {
            out.copy_from_slice(state);
            return;
        }
        out.copy_from_slice(&self.step.start);
        let h = self.step.length();
        let offset = t - self.step.start_time;
        accumulate(out, h, &self.slopes, &self.tableau.weights(offset / h));
        self.picture.push_by(offset, out, 1);
    }

    fn record<Y: System + ?Sized>(&mut self, sys: &Y) -> usize {
        self.records = vec![vec![0.0; differentiable(sys).record_len()]; S];
        S
    }

    fn forget_records(&mut self) {
        self.records.clear();
    }

    /// The vectors go through the very stages of the step that the state has taken, so that what they
    /// give is the derivative of the numerical flow itself, whatever its tolerance.
    fn carry<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        bundle: &mut Bundle,
        _tally: &mut Tally,
    ) {
        let width = bundle.width;
        let numbers = bundle.end.len();
        let derivative = differentiable(sys);
        let tableau = self.tableau;
        let h = self.step.length();
        let is_cut = self.step.is_cut();
        // Only the dense output needs the slope at the end of the step, and those beyond.
        let stages = if is_cut { S } else { tableau.end };
        for stage in 0..stages {
            bundle.stage.copy_from_slice(&bundle.start);
            if stage > 0 {
                let weights = &tableau.stages[stage][..stage];
                accumulate(&mut bundle.stage, h, &bundle.slopes, weights);
                self.picture.push(stage, &mut bundle.stage, width);
            }
            let slope = &mut bundle.slopes[stage * numbers..][..numbers];
            derivative.product(
                status,
                &mut self.records[stage],
                &bundle.stage,
                width,
                &mut slope[sys.modes() * width..],
            );
            self.picture.complete(sys, &bundle.stage, slope, width);
            if stage > 0 {
                self.picture.pull(stage, slope, width);
            }
        }
        bundle.end.copy_from_slice(&bundle.start);
        if is_cut {
            let offset = self.step.end_time - self.step.start_time;
            let weights = tableau.weights(offset / h);
            accumulate(&mut bundle.end, h, &bundle.slopes, &weights);
            self.picture.push_by(offset, &mut bundle.end, width);
        } else {
            let weights = &tableau.stages[tableau.end][..tableau.end];
            accumulate(&mut bundle.end, h, &bundle.slopes, weights);
            self.picture.push(tableau.end, &mut bundle.end, width);
        }
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
        _ => {
            let (slopes, rest) = slopes.split_at(8 * y.len());
            accumulate_terms::<8>(y, h, slopes, &weights[..8]);
            if weights.len() > 8 {
                accumulate(y, h, rest, &weights[8..]);
            }
        }
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
