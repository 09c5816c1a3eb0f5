//! The workspace of a Runge–Kutta method and its step.
//!
//! The step is written once, for any [`Tableau`] and any [`Picture`]; nothing is allocated after
//! [`Stepper::new`].

use super::tableau::Tableau;
use super::{Differentiable, Switching, System};

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
    /// Where the last step ended before it was cut at an event, s.
    reach_time: f64,
    /// State at the end of the last step.
    pub end: Vec<f64>,
    /// Slope of the state at the end of the last step.
    pub end_slope: Vec<f64>,
    /// Estimated error of `end`; zero without an embedded method.
    pub error: Vec<f64>,
    /// Slopes of `y` at the stages, `stages x dim`, row-major.
    pub slopes: Vec<f64>,
    /// A record a stage, where tangent vectors follow the steps; else none.
    pub records: Vec<Vec<f64>>,
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
            reach_time: 0.0,
            end: zeros.clone(),
            end_slope: zeros.clone(),
            error: zeros,
            slopes: vec![0.0; S * dim],
            records: Vec::new(),
        }
    }

    /// Keeps records of so many numbers at the stages from now on.
    pub fn record(&mut self, len: usize) {
        self.records = vec![vec![0.0; len]; S];
    }

    /// The length of the state.
    pub fn dim(&self) -> usize {
        self.start.len()
    }

    /// The length of the step that the stages belong to, s.
    pub fn length(&self) -> f64 {
        self.reach_time - self.start_time
    }

    /// Whether the last step was cut at an event.
    pub fn is_cut(&self) -> bool {
        self.end_time < self.reach_time
    }

    /// Evaluates the system afresh at the present state, and forgets the step that led to it.
    pub fn refresh<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>) {
        self.slope(sys, status, S - 1, self.end_time);
        let dim = self.dim();
        self.end_slope
            .copy_from_slice(&self.slopes[(S - 1) * dim..]);
        self.reach_time = self.end_time;
        // The record stays at the end, where the next step takes it from.
        self.anchor();
    }

    /// Lets the next step start where the last one ended.
    pub fn follow(&mut self) {
        self.anchor();
        self.hand_over_record();
    }

    /// Puts the start of the step at its end.
    fn anchor(&mut self) {
        let dim = self.dim();
        self.start_time = self.end_time;
        self.start.copy_from_slice(&self.end);
        self.slopes[..dim].copy_from_slice(&self.end_slope);
    }

    /// Takes the last step back.
    pub fn rewind(&mut self) {
        let dim = self.dim();
        self.end_time = self.start_time;
        self.reach_time = self.start_time;
        self.end.copy_from_slice(&self.start);
        self.end_slope.copy_from_slice(&self.slopes[..dim]);
        self.hand_over_record();
    }

    /// Exchanges the records at the step's two ends.
    fn hand_over_record(&mut self) {
        if !self.records.is_empty() {
            self.records.swap(0, S - 1);
        }
    }

    /// Tries the step from `start_time` to `end_time`. It overwrites any step tried from there
    /// before, so that a rejected step needs no undoing. Costs `S - 1` calls.
    pub fn attempt<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>, end_time: f64) {
        let dim = self.dim();
        self.end_time = end_time;
        self.reach_time = end_time;
        let h = self.length();
        self.picture.prepare(&self.tableau.nodes, h);
        for stage in 1..S {
            self.end.copy_from_slice(&self.start);
            accumulate(
                &mut self.end,
                h,
                &self.slopes,
                &self.tableau.stages[stage][..stage],
            );
            self.picture.push(stage, &mut self.end, 1);
            let time = self.start_time + self.tableau.nodes[stage] * h;
            if let (true, Some(status)) = (stage == S - 1, status) {
                switching(sys).settle(status, end_time, &mut self.end);
            }
            self.slope(sys, status, stage, time);
            let slope = &mut self.slopes[stage * dim..][..dim];
            if stage == S - 1 {
                self.end_slope.copy_from_slice(slope);
            }
            self.picture.pull(stage, slope, 1);
        }
        self.error.fill(0.0);
        accumulate(&mut self.error, h, &self.slopes, &self.tableau.error);
        self.picture.push(S - 1, &mut self.error, 1);
    }

    /// Writes the slope of the state `end` at `time` (s) as that of a stage, not yet pulled.
    fn slope<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        stage: usize,
        time: f64,
    ) {
        let dim = self.dim();
        let slope = &mut self.slopes[stage * dim..][..dim];
        let force = &mut slope[sys.modes()..];
        match (self.records.get_mut(stage), status) {
            (None, None) => sys.force(time, &self.end, force),
            (None, Some(status)) => switching(sys).force_in(status, time, &self.end, force),
            (Some(record), status) => {
                differentiable(sys).force_recorded(status, time, &self.end, force, record);
            }
        }
        self.picture.complete(sys, &self.end, slope, 1);
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

/// The switching of a system that is known to have it.
pub(super) fn switching<Y: System + ?Sized>(sys: &Y) -> &dyn Switching {
    sys.switching().expect("checked when the system came in")
}

/// The derivative of a system that is known to have it.
pub(super) fn differentiable<Y: System + ?Sized>(sys: &Y) -> &dyn Differentiable {
    sys.differentiable()
        .expect("checked when the system came in")
}
