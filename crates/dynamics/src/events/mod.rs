//! Event location: finds the zeros of guards without evaluations of the right-hand side.
//!
//! The status is frozen during a step, so each step is smooth and keeps the order of the method. After
//! the step the guards are evaluated on its dense output. If a guard has fallen through zero, the first
//! zero is located and the step is shortened to end there. All guards that are negative immediately
//! after it belong to the same event.
//!
//! # Sampling of a step
//!
//! A step with dense output of order 4 is searched as a whole, one with a higher order in two pieces.
//! The following holds for each piece.
//!
//! The guards are evaluated at the middle and at the end; the start is the end of the previous piece.
//! This suffices if each guard is further from zero than it has moved between these points. Otherwise
//! the guards are evaluated at the quarters, too. Five values determine a guard as accurately as the
//! dense output of order 4. A guard that becomes negative and positive again between two samples is
//! detected by a parabola through three samples, with the third differences as its uncertainty. Its
//! minimum is then located on the dense output. A double crossing that the five samples do not indicate
//! is missed; it is smaller than the error of the dense output.
//!
//! A minimum that reaches zero within the rounding of the guard is a grazing: it is counted but not
//! crossed.

mod dip;
mod root;

use super::Switching;
use super::stepper::Stepper;

/// Number of intervals per piece of a step.
const QUARTERS: usize = 4;

/// Relative tolerance, with respect to the largest value of the guard in the step, below which a guard
/// counts as touching zero.
const GRAZING_TOLERANCE: f64 = 1e-12;

/// Default of [`Events::limit`].
const MAX_EVENTS: usize = 10_000;

/// The present status and the search for the next event.
#[derive(Clone, Debug)]
pub(super) struct Events {
    /// The present status.
    pub status: Vec<u8>,
    /// Guards that are negative at the end of the last step, to be crossed before the next one.
    pub pending: Vec<usize>,
    /// Guards crossed at the last event, in order.
    pub crossed: Vec<usize>,
    /// Start and end of the piece being searched, s.
    piece: [f64; 2],
    /// Guard values at the quarters of the piece; those at its start are known in advance.
    samples: [Vec<f64>; QUARTERS + 1],
    /// Guards that may be negative within the piece.
    candidates: Vec<usize>,
    /// Guard values at the two ends of the bracket and at a point between them.
    above: Vec<f64>,
    below: Vec<f64>,
    between: Vec<f64>,
    /// State at a time within the step.
    state: Vec<f64>,
    /// Maximum number of events within the window (s); more count as chattering.
    pub limit: usize,
    pub window: f64,
    /// Number of events since `window_start` (s).
    pub events_in_window: usize,
    window_start: f64,
}

/// The last step of a method, in which events are sought; its dense output is prepared.
pub(super) struct SearchedStep<'a> {
    pub switching: &'a dyn Switching,
    pub stepper: &'a mut dyn Stepper,
}

impl Events {
    /// Workspace for a system, without a status yet, with a window (s) for chattering.
    pub fn new(switching: &dyn Switching, window: f64) -> Self {
        let values = vec![0.0; switching.guards()];
        Self {
            status: vec![0; switching.status_len()],
            pending: Vec::with_capacity(values.len()),
            crossed: Vec::with_capacity(values.len() + MAX_EVENTS),
            piece: [0.0; 2],
            samples: std::array::from_fn(|_| values.clone()),
            candidates: Vec::with_capacity(values.len()),
            above: values.clone(),
            below: values.clone(),
            between: values,
            state: vec![0.0; switching.dim()],
            limit: MAX_EVENTS,
            window,
            events_in_window: 0,
            window_start: f64::NEG_INFINITY,
        }
    }

    /// Determines the status of a state and discards all events.
    pub fn start(&mut self, switching: &dyn Switching, t: f64, z: &[f64]) {
        switching.status_of(t, z, &mut self.status);
        self.find_negative(switching, t, z);
        self.events_in_window = 0;
        self.window_start = t;
    }

    /// Updates the status after a step without event location.
    pub fn skip_events(&mut self, switching: &dyn Switching, t: f64, z: &[f64]) {
        switching.status_of(t, z, &mut self.status);
        self.find_negative(switching, t, z);
        self.pending.clear();
    }

    /// Counts an event at time `t` (s). Returns whether the system chatters.
    pub fn count_event(&mut self, t: f64) -> bool {
        self.update_window(t);
        self.events_in_window += 1;
        self.events_in_window > self.limit
    }

    /// Discards the events of a window that has ended by time `t` (s).
    pub fn update_window(&mut self, t: f64) {
        if t - self.window_start > self.window {
            self.window_start = t;
            self.events_in_window = 0;
        }
    }

    /// Adds a guard to the list of crossed guards.
    pub fn record_crossing(&mut self, guard: usize) {
        // Only chattering fills the list; it must not allocate during a step.
        if self.crossed.len() < self.crossed.capacity() {
            self.crossed.push(guard);
        }
    }

    /// The frozen status for the next step; `None` if the step is taken without event location.
    pub fn frozen_status(&self) -> Option<&[u8]> {
        (self.events_in_window <= self.limit).then_some(self.status.as_slice())
    }

    /// Stores the guards that are negative at a state under the present status in `pending`. The next
    /// step starts there.
    pub fn find_negative(&mut self, switching: &dyn Switching, t: f64, z: &[f64]) {
        switching.guard_values(&self.status, t, z, &mut self.samples[0]);
        self.pending.clear();
        let negative = self.samples[0]
            .iter()
            .enumerate()
            .filter(|(_, h)| **h < 0.0);
        self.pending.extend(negative.map(|(guard, _)| guard));
    }

    /// Whether the system has guards.
    pub fn has_guards(&self) -> bool {
        !self.above.is_empty()
    }

    /// Searches a step for its first event. If an event is found, the step is shortened to end there, and `pending` holds
    /// its guards. Returns whether an event was found.
    pub fn find_first(&mut self, mut searched: SearchedStep<'_>) -> bool {
        self.pending.clear();
        if !self.has_guards() {
            return false;
        }
        let pieces = searched.stepper.traits().pieces;
        let step = searched.stepper.step();
        let (start, end) = (step.start_time, step.end_time);
        (1..=pieces).any(|piece| {
            let boundary = |k: usize| start + (end - start) * k as f64 / pieces as f64;
            self.piece = [
                boundary(piece - 1),
                if piece == pieces {
                    end
                } else {
                    boundary(piece)
                },
            ];
            self.find_first_in_piece(&mut searched)
        })
    }

    /// Searches one piece of the step; earlier pieces contain no event.
    fn find_first_in_piece(&mut self, searched: &mut SearchedStep<'_>) -> bool {
        self.sample_quarter(searched, 2);
        self.sample_quarter(searched, 4);
        if !self.needs_quarters() {
            self.samples.swap(0, QUARTERS);
            return false;
        }
        self.sample_quarter(searched, 1);
        self.sample_quarter(searched, 3);
        self.list_candidates();
        self.clear_touches();
        for quarter in 1..=QUARTERS {
            let high = match self.find_dip(searched, quarter) {
                Some(high) => high,
                None if self.samples[quarter].iter().any(|&h| h < 0.0) => {
                    self.below.copy_from_slice(&self.samples[quarter]);
                    self.quarter_time(quarter)
                }
                None => continue,
            };
            self.above.copy_from_slice(&self.samples[quarter - 1]);
            let low = self.quarter_time(quarter - 1);
            let t = self.locate(searched, low, high);
            searched.stepper.shorten(t);
            let end = &mut searched.stepper.step_mut().end;
            searched
                .switching
                .settle(&self.status, t, end, (&mut [], 0));
            let negative = self.below.iter().enumerate().filter(|(_, h)| **h < 0.0);
            self.pending.extend(negative.map(|(guard, _)| guard));
            return true;
        }
        self.samples.swap(0, QUARTERS);
        false
    }

    /// Evaluates the guards at a quarter of the piece.
    fn sample_quarter(&mut self, searched: &mut SearchedStep<'_>, quarter: usize) {
        self.sample_at(searched, self.quarter_time(quarter));
        std::mem::swap(&mut self.samples[quarter], &mut self.between);
    }

    /// Evaluates the guards at time `t` (s) within the step into `between`.
    fn sample_at(&mut self, searched: &mut SearchedStep<'_>, t: f64) {
        searched.stepper.interpolate(t, &mut self.state);
        let (switching, values) = (searched.switching, &mut self.between);
        switching.guard_values(&self.status, t, &self.state, values);
    }

    /// Whether some guard is closer to zero than it has moved, from its values at the start, the middle
    /// and the end of the piece.
    fn needs_quarters(&self) -> bool {
        let ends = self.samples[0].iter().zip(&self.samples[QUARTERS]);
        let mut doubtful = false;
        // No early exit: the loop is a single pass of vector operations.
        for ((&start, &end), &middle) in ends.zip(&self.samples[QUARTERS / 2]) {
            let low = start.min(middle).min(end);
            let high = start.max(middle).max(end);
            doubtful |= low <= high - low;
        }
        doubtful
    }

    /// Lists the guards that may be negative within the piece. Between two samples a guard can be lower
    /// than both by an eighth of its second difference, plus a small amount if that varies.
    fn list_candidates(&mut self) {
        let [a, b, c, d, e] = &self.samples;
        let n = a.len();
        let (a, b, c, d, e) = (&a[..n], &b[..n], &c[..n], &d[..n], &e[..n]);
        self.candidates.clear();
        for k in 0..n {
            let (a, b, c, d, e) = (a[k], b[k], c[k], d[k], e[k]);
            let low = a.min(b).min(c).min(d).min(e);
            let bend = (a - 2.0 * b + c).max(b - 2.0 * c + d).max(c - 2.0 * d + e);
            if low <= bend.max(0.0) {
                self.candidates.push(k);
            }
        }
    }

    /// Sets a guard to zero at a sample where it touches zero between two positive samples.
    fn clear_touches(&mut self) {
        for quarter in 1..QUARTERS {
            for &guard in &self.candidates {
                let [before, here, after] = [0, 1, 2].map(|k| self.samples[quarter - 1 + k][guard]);
                if here < 0.0
                    && here >= -GRAZING_TOLERANCE * before.abs().max(after.abs())
                    && after > 0.0
                {
                    self.samples[quarter][guard] = 0.0;
                }
            }
        }
    }

    /// Time of a quarter of the piece, s.
    fn quarter_time(&self, quarter: usize) -> f64 {
        let [start, end] = self.piece;
        if quarter == QUARTERS {
            return end;
        }
        start + (end - start) * quarter as f64 / QUARTERS as f64
    }
}
