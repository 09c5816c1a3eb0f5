//! A quantity as a function of time.

use std::f64::consts::TAU;

use crate::number::degrees;

/// A scalar function of time: piecewise linear, a step function or a sine.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule(Form);

/// Forms of a schedule.
#[derive(Clone, Debug, PartialEq)]
enum Form {
    /// Points [time in s, value] with strictly increasing times, at least one. The first value also holds before its
    /// time, and the last one after its time.
    Points {
        points: Vec<[f64; 2]>,
        /// Whether each value holds up to the next point; otherwise the function is linear between the points.
        is_stepped: bool,
    },
    /// A sine with an offset.
    Sine(Sine),
}

/// `mean + amplitude sin(2 pi frequency t + phase)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sine {
    /// Mean value.
    pub mean: f64,
    /// Amplitude.
    pub amplitude: f64,
    /// Frequency, Hz.
    pub frequency: f64,
    /// Phase at time 0, rad.
    pub phase: f64,
}

impl Schedule {
    /// Builds a constant function.
    pub fn constant(value: f64) -> Self {
        Self(Form::Points {
            points: vec![[0.0, value]],
            is_stepped: false,
        })
    }

    /// Builds the piecewise linear function through the given knots [time in s, value], constant before the
    /// first and after the last. Returns `None` if there is no knot, a number is not finite, or the times do
    /// not increase strictly.
    pub fn piecewise_linear(knots: Vec<[f64; 2]>) -> Option<Self> {
        Self::through(knots, false)
    }

    /// Builds a step function from [time in s, value]. The first value also holds before its time. Returns
    /// `None` as [`Schedule::piecewise_linear`].
    pub fn steps(steps: Vec<[f64; 2]>) -> Option<Self> {
        Self::through(steps, true)
    }

    fn through(points: Vec<[f64; 2]>, is_stepped: bool) -> Option<Self> {
        let finite = points.as_flattened().iter().all(|x| x.is_finite());
        let increasing = points.windows(2).all(|w| w[0][0] < w[1][0]);
        let is_valid = finite && increasing && !points.is_empty();
        is_valid.then_some(Self(Form::Points { points, is_stepped }))
    }

    /// Builds a sine; `None` if a parameter is not finite.
    pub fn sine(sine: Sine) -> Option<Self> {
        let numbers = [sine.mean, sine.amplitude, sine.frequency, sine.phase];
        let finite = numbers.iter().all(|x| x.is_finite());
        finite.then_some(Self(Form::Sine(sine)))
    }

    /// Value at time `t` (s).
    pub fn at(&self, t: f64) -> f64 {
        match &self.0 {
            Form::Points { points, is_stepped } => {
                let after = points.partition_point(|[time, _]| *time <= t);
                let [t0, x0] = points[after.saturating_sub(1)];
                match points.get(after) {
                    Some(&[t1, x1]) if after > 0 && !is_stepped => {
                        x0 + (x1 - x0) * (t - t0) / (t1 - t0)
                    }
                    _ => x0,
                }
            }
            Form::Sine(sine) => {
                let angle = TAU * sine.frequency * t + sine.phase;
                sine.mean + sine.amplitude * angle.sin()
            }
        }
    }

    /// Integral over time from 0 to `t` (s, not negative).
    pub fn integral(&self, t: f64) -> f64 {
        match &self.0 {
            Form::Points { points, is_stepped } => {
                let [[first, before], [last, after]] = [points[0], points[points.len() - 1]];
                let reached = points.windows(2).take_while(|pair| pair[0][0] < t);
                let parts = reached.map(|pair| {
                    let [[t0, x0], [t1, x1]] = [pair[0], pair[1]];
                    let end = t.min(t1);
                    let slope = if *is_stepped { 0.0 } else { 0.5 * (x1 - x0) };
                    (end - t0) * (x0 + slope * (end - t0) / (t1 - t0))
                });
                let outside = before * t.min(first) + after * (t - last).max(0.0);
                outside + parts.sum::<f64>()
            }
            Form::Sine(sine) => {
                let rate = TAU * sine.frequency;
                let swing = sine.phase.cos() - (rate * t + sine.phase).cos();
                sine.mean * t + sine.amplitude * swing / rate
            }
        }
    }

    /// Values of the knots or steps; for a sine minimum, mean and maximum.
    pub fn values(&self) -> Vec<f64> {
        match &self.0 {
            Form::Points { points, .. } => points.iter().map(|p| p[1]).collect(),
            Form::Sine(sine) => {
                let swing = sine.amplitude.abs();
                vec![sine.mean - swing, sine.mean, sine.mean + swing]
            }
        }
    }

    /// The distinct [`Schedule::values`] of an angle, degrees, in ascending order.
    pub fn degrees(&self) -> Vec<f64> {
        let mut values: Vec<f64> = self.values().into_iter().map(degrees).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    }

    /// Minimum.
    pub fn min(&self) -> f64 {
        self.values().into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Maximum.
    pub fn max(&self) -> f64 {
        self.values().into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether the value changes with time.
    pub fn varies(&self) -> bool {
        self.min() != self.max()
    }

    /// Pairs of points with different values, of steps or of knots.
    fn changes(&self, of_steps: bool) -> impl Iterator<Item = [[f64; 2]; 2]> {
        let points = match &self.0 {
            Form::Points { points, is_stepped } if *is_stepped == of_steps => &points[..],
            _ => &[],
        };
        let pairs = points.windows(2).map(|pair| [pair[0], pair[1]]);
        pairs.filter(|[before, after]| before[1] != after[1])
    }

    /// Times of the discontinuities, s, ascending.
    pub fn jumps(&self) -> impl Iterator<Item = f64> {
        self.changes(true).map(|[_, [time, _]]| time)
    }

    /// Time (s) of the first knot that differs in value from the previous one and follows it by less than
    /// `span` (s). Always `None` for steps: frames end exactly at steps.
    pub fn first_knot_within(&self, span: f64) -> Option<f64> {
        // One knot per frame is permitted, within rounding.
        let is_close = |pair: &[[f64; 2]; 2]| pair[1][0] - pair[0][0] < span * (1.0 - 1e-9);
        let [_, [time, _]] = self.changes(false).find(is_close)?;
        Some(time)
    }

    /// Time of the last knot or step, s; `None` for a sine.
    pub fn last_point(&self) -> Option<f64> {
        match &self.0 {
            Form::Points { points, .. } => points.last().map(|p| p[0]),
            Form::Sine(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [[f64; 2]; 3] = [[1.0, 2.0], [3.0, 6.0], [4.0, -1.0]];

    #[test]
    fn lines_join_their_knots_and_stay_beyond_them() {
        let lines = Schedule::piecewise_linear(POINTS.to_vec()).unwrap();
        let at = [0.0, 1.0, 2.0, 3.0, 3.5, 4.0, 9.0].map(|t| lines.at(t));
        assert_eq!(at, [2.0, 2.0, 4.0, 6.0, 2.5, -1.0, -1.0]);
        assert_eq!((lines.min(), lines.max()), (-1.0, 6.0));
        assert_eq!(lines.values(), [2.0, 6.0, -1.0]);
        assert_eq!(lines.jumps().count(), 0);
        assert_eq!(lines.last_point(), Some(4.0));
    }

    #[test]
    fn steps_hold_from_their_time_on() {
        let steps = Schedule::steps(POINTS.to_vec()).unwrap();
        let at = [0.0, 1.0, 3.0_f64.next_down(), 3.0, 4.0, 9.0].map(|t| steps.at(t));
        assert_eq!(at, [2.0, 2.0, 2.0, 6.0, -1.0, -1.0]);
        assert_eq!((steps.min(), steps.max()), (-1.0, 6.0));
        assert_eq!(steps.jumps().collect::<Vec<_>>(), [3.0, 4.0]);
        let level = Schedule::steps(vec![[0.0, 1.0], [2.0, 1.0], [3.0, 4.0]]).unwrap();
        assert_eq!(level.jumps().collect::<Vec<_>>(), [3.0], "no jump at 2");
    }

    #[test]
    fn a_sine_swings_about_its_mean() {
        let sine = Sine {
            mean: 3.0,
            amplitude: 2.0,
            frequency: 0.25,
            phase: std::f64::consts::FRAC_PI_2,
        };
        let swings = Schedule::sine(sine).unwrap();
        for (time, value) in [(0.0, 5.0), (1.0, 3.0), (2.0, 1.0), (4.0, 5.0)] {
            assert!((swings.at(time) - value).abs() < 1e-14, "{time}");
        }
        assert_eq!(swings.values(), [1.0, 3.0, 5.0]);
        assert_eq!((swings.min(), swings.max()), (1.0, 5.0));
        assert_eq!(swings.last_point(), None);
        let upside_down = Sine {
            amplitude: -2.0,
            ..sine
        };
        let upside_down = Schedule::sine(upside_down).unwrap();
        assert_eq!((upside_down.min(), upside_down.max()), (1.0, 5.0));
    }

    #[test]
    fn integrals_are_those_of_the_values() {
        let lines = Schedule::piecewise_linear(POINTS.to_vec()).unwrap();
        let at = [0.0, 0.5, 1.0, 2.0, 3.0, 3.5, 4.0, 6.0];
        assert_eq!(
            at.map(|t| lines.integral(t)),
            [0.0, 1.0, 2.0, 5.0, 10.0, 12.125, 12.5, 10.5]
        );
        let steps = Schedule::steps(POINTS.to_vec()).unwrap();
        assert_eq!(
            at.map(|t| steps.integral(t)),
            [0.0, 1.0, 2.0, 4.0, 6.0, 9.0, 12.0, 10.0]
        );
        assert_eq!(Schedule::constant(2.5).integral(3.0), 7.5);
        let sine = Sine {
            mean: 0.3,
            amplitude: 2.0,
            frequency: 0.7,
            phase: 1.1,
        };
        let sine = Schedule::sine(sine).unwrap();
        for end in at {
            let middles = (0..1000).map(|k| end * (f64::from(k) + 0.5) / 1000.0);
            let sum = middles.map(|t| sine.at(t)).sum::<f64>() * end / 1000.0;
            assert!((sine.integral(end) - sum).abs() < 1e-4, "{end}");
        }
    }

    #[test]
    fn what_does_not_change_does_not_vary_to_the_last_bit() {
        let value = 0.1 + 0.2;
        let sine = Sine {
            mean: value,
            amplitude: 0.0,
            frequency: 7.3,
            phase: 0.4,
        };
        let points = || vec![[0.0, value], [0.7, value]];
        for level in [
            Schedule::constant(value),
            Schedule::piecewise_linear(points()).unwrap(),
            Schedule::steps(points()).unwrap(),
            Schedule::sine(sine).unwrap(),
        ] {
            assert!(!level.varies());
            assert!((0..100).all(|k| level.at(0.0137 * f64::from(k)) == value));
        }
    }

    #[test]
    fn points_out_of_order_and_numbers_that_are_none_give_no_schedule() {
        for points in [
            vec![],
            vec![[1.0, 0.0], [1.0, 2.0]],
            vec![[f64::NAN, 0.0]],
            vec![[0.0, f64::INFINITY]],
        ] {
            assert_eq!(Schedule::piecewise_linear(points.clone()), None);
            assert_eq!(Schedule::steps(points), None);
        }
        let endless = Sine {
            mean: 0.0,
            amplitude: f64::INFINITY,
            frequency: 1.0,
            phase: 0.0,
        };
        assert_eq!(Schedule::sine(endless), None);
    }
}
