//! The second tone of a torus that is born: its growth, compared with that by the Floquet multipliers.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use crate::analysis::{
    stats::LineFit,
    tones::{Window, line_amplitude},
};
use crate::pipeline::message::{SecondToneGrowth, SecondToneLevel, ToneGrowth, TorusBirth};
use crate::report;

/// Length of a window in periods of the second tone: its lines are then 6 bins from the first tone, whose main lobe has 4.
const PERIODS: f64 = 6.0;
/// Steps of a window.
const STEPS: usize = 10;
/// Smallest ratio of the tones that is fitted: errors of integration and the steps of a ramp make up to a tenth of it.
const SMALLEST: f64 = 5e-4;
/// Largest share of the largest ratio that is fitted: the rate changes with the square of the amplitude, here by half a
/// per cent.
const LINEAR: f64 = 1.0 / 14.0;
/// Least share of the power of the motion in the line of the first tone, for a motion on the predicted branch.
const FIRST: f64 = 0.5;

/// Measures the second tone in windows, and fits its growth relative to the predicted one while it is small.
///
/// The predicted rate varies with the tilt. The slope of `ln ratio` minus the integral of the predicted rate is therefore
/// the difference between the measured and the predicted rate.
#[derive(Default)]
pub struct SecondTone {
    birth: TorusBirth,
    /// Sample spacing, s.
    dt: f64,
    weights: Vec<f64>,
    /// The prediction at the present tilt; `None` beyond the branch.
    now: Option<SecondToneGrowth>,
    /// The last samples, m/s, a window at most.
    velocity: Vec<f64>,
    /// The prediction and the integral of its rate at the end of each step of these samples.
    steps: VecDeque<(SecondToneGrowth, f64)>,
    /// Integral of the predicted rate.
    integral: f64,
    /// Number of windows so far.
    windows: u32,
    /// Successive windows with a predicted rate of one sign.
    stretch: Vec<Measured>,
    found: Option<SecondToneLevel>,
}

/// The second tone in one window.
#[derive(Clone, Copy)]
struct Measured {
    /// Time at its centre relative to that of the first window, s.
    time: f64,
    /// Prediction at its centre.
    predicted: SecondToneGrowth,
    /// Integral of the predicted rate up to its centre.
    integral: f64,
    /// Amplitude of the second tone relative to that of the first.
    ratio: f64,
}

impl SecondTone {
    /// For a prediction, and samples with a spacing (s).
    pub fn new(birth: TorusBirth, dt: f64) -> Self {
        let lowest = birth.course.iter().map(|point| point.second_hz);
        let longest = PERIODS / lowest.fold(f64::INFINITY, f64::min);
        let step = (longest / dt / STEPS as f64).ceil() as usize;
        Self {
            birth,
            dt,
            weights: Window::BlackmanHarris.samples(STEPS * step),
            ..Self::default()
        }
    }

    /// Sets the tilt (rad) of the following samples.
    pub fn set_tilt(&mut self, tilt: f64) {
        self.now = self.birth.at(tilt);
    }

    /// Starts new windows: the motion is disturbed, or is not on the branch.
    pub fn restart(&mut self) {
        self.velocity.clear();
        self.steps.clear();
        self.stretch.clear();
    }

    /// Processes a velocity, m/s.
    pub fn push(&mut self, velocity: f64) {
        let Some(now) = self.now else {
            return self.restart();
        };
        self.velocity.push(velocity);
        self.integral += now.growth_per_s * self.dt;
        let step = self.weights.len() / STEPS;
        if !self.velocity.len().is_multiple_of(step) {
            return;
        }
        self.steps.push_back((now, self.integral));
        if self.velocity.len() < self.weights.len() {
            return;
        }
        self.measure();
        self.velocity.drain(..step);
        self.steps.pop_front();
    }

    /// The measurements so far; `None` before the first window.
    pub fn found(&self) -> Option<SecondToneLevel> {
        self.found
    }

    /// Measures the tones in the window that is complete.
    fn measure(&mut self) {
        let (predicted, integral) = self.steps[STEPS / 2 - 1];
        let SecondToneGrowth {
            frequency_hz: first_hz,
            second_hz,
            ..
        } = predicted;
        let amplitude = |hz: f64| line_amplitude(&self.velocity, &self.weights, TAU * hz * self.dt);
        let [first, lower, upper] =
            [0.0, -1.0, 1.0].map(|side| amplitude(first_hz + side * second_hz));
        let powers = self.velocity.iter().zip(&self.weights);
        let power = powers.map(|(v, w)| w * v * v).sum::<f64>() / self.weights.iter().sum::<f64>();
        let time = f64::from(self.windows) * (self.weights.len() / STEPS) as f64 * self.dt;
        self.windows += 1;
        let is_on_branch = 0.5 * first * first >= FIRST * power && power > 0.0;
        if !is_on_branch {
            self.stretch.clear();
            return;
        }
        let measured = Measured {
            time,
            predicted,
            integral,
            ratio: lower.hypot(upper) / first,
        };
        let grows = predicted.growth_per_s > 0.0;
        let changes = |last: &Measured| (last.predicted.growth_per_s > 0.0) != grows;
        if measured.ratio < SMALLEST || self.stretch.last().is_some_and(changes) {
            self.stretch.clear();
        }
        if measured.ratio >= SMALLEST {
            self.stretch.push(measured);
        }
        let found = self.found.get_or_insert_default();
        found.ratio = measured.ratio;
        let kept = if grows {
            &mut found.growth
        } else {
            &mut found.decay
        };
        let span = self.weights.len() as f64 * self.dt;
        *kept = fitted(&self.stretch, grows, span).or(*kept);
    }
}

/// The growth in the windows of a stretch in which it is linear: before the largest ratio if the second tone should grow,
/// after it if it should decay. `None` if they span less than `span`, s.
fn fitted(stretch: &[Measured], grows: bool, span: f64) -> Option<ToneGrowth> {
    let ratios = stretch.iter().enumerate();
    let (largest, top) = ratios.max_by(|a, b| a.1.ratio.total_cmp(&b.1.ratio))?;
    let part = if grows {
        &stretch[..largest]
    } else {
        &stretch[largest..]
    };
    let linear = || part.iter().filter(|at| at.ratio <= LINEAR * top.ratio);
    let (first, last) = (linear().next()?, linear().next_back()?);
    if last.time - first.time < span {
        return None;
    }
    let mut line = LineFit::default();
    for at in linear() {
        line.push(at.time, at.ratio.ln() - at.integral);
    }
    let fit = line.fit()?;
    let computed_per_s = (last.integral - first.integral) / (last.time - first.time);
    Some(ToneGrowth {
        tilts: [first, last].map(|at| at.predicted.tilt),
        growth: report::Measured::new(computed_per_s + fit.slope, fit.half_width).unit("1/s"),
        computed_per_s,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1e-5;

    fn birth() -> TorusBirth {
        let point = |tilt: f64| SecondToneGrowth {
            tilt,
            frequency_hz: 4100.0 + tilt,
            second_hz: 240.0 + tilt,
            growth_per_s: 50.0 * tilt,
        };
        TorusBirth {
            tilt: 0.0,
            course: [-1.0, 0.0, 1.0].map(point).into(),
        }
    }

    /// A first tone with a second one of `ratio` over time (s), for a tilt over time, and a share of another tone.
    fn measured(
        tilt: impl Fn(f64) -> f64,
        ratio: impl Fn(f64) -> f64,
        other: f64,
        duration: f64,
    ) -> SecondTone {
        let mut tone = SecondTone::new(birth(), DT);
        for k in 0..(duration / DT) as u32 {
            let t = f64::from(k) * DT;
            tone.set_tilt(tilt(t));
            let first = TAU * 4100.0 * t;
            let second = ratio(t) * (TAU * 3860.0 * t).cos();
            tone.push(first.cos() + second + other * (TAU * 9000.0 * t).sin());
        }
        tone
    }

    /// A ramp from -1 to 1 within 0.4 s; the second tone follows a law of Stuart and Landau with the predicted rate times a
    /// factor, which is integrated here.
    fn ramp(factor: f64) -> SecondTone {
        let tilt = |t: f64| 5.0 * t - 1.0;
        let mut amplitudes = vec![0.05];
        for k in 0..40_000 {
            let (a, t) = (amplitudes[k], k as f64 * DT);
            let rate = factor * 50.0 * tilt(t) - 50.0 * (a / 0.1f64).powi(2);
            amplitudes.push(a + a * rate * DT);
        }
        measured(tilt, |t| amplitudes[(t / DT).round() as usize], 0.0, 0.4)
    }

    #[test]
    fn a_tone_with_the_predicted_rates_agrees_within_one_per_cent() {
        let found = ramp(1.0).found().unwrap();
        let (decay, growth) = (found.decay.unwrap(), found.growth.unwrap());
        for part in [decay, growth] {
            assert!(
                (part.growth.value / part.computed_per_s - 1.0).abs() < 0.01,
                "{part:?}"
            );
            assert!(part.growth.half_width < 0.02 * part.computed_per_s.abs());
        }
        assert!(decay.tilts[1] < 0.0 && growth.tilts[0] > 0.0);
    }

    #[test]
    fn a_tone_with_another_rate_has_this_rate() {
        for factor in [0.8, 1.2] {
            let growth = ramp(factor).found().unwrap().growth.unwrap();
            let share = growth.growth.value / growth.computed_per_s;
            assert!((share / factor - 1.0).abs() < 0.01, "{growth:?}");
        }
    }

    #[test]
    fn a_constant_second_tone_or_none_has_no_growth() {
        for ratio in [1e-6, 0.01, 0.3] {
            let found = measured(|_| 0.5, |_| ratio, 0.0, 0.3).found().unwrap();
            assert!((found.ratio - ratio).abs() < 0.01 * ratio + 1e-5);
            assert_eq!((found.decay, found.growth), (None, None), "{ratio}");
        }
    }

    #[test]
    fn another_motion_and_a_tilt_beyond_the_branch_are_not_measured() {
        let grows = |t: f64| 1e-4 * (25.0 * t).exp();
        assert!(measured(|_| 0.5, grows, 0.0, 0.4).found().is_some());
        assert_eq!(measured(|_| 0.5, grows, 1.5, 0.4).found(), None);
        assert_eq!(measured(|_| 1.5, grows, 0.0, 0.4).found(), None);
    }

    #[test]
    fn a_kick_starts_new_windows() {
        let mut tone = ramp(1.0);
        let before = tone.found();
        tone.restart();
        for _ in 0..100 {
            tone.push(1.0);
        }
        assert_eq!(tone.found(), before);
        assert!(tone.stretch.is_empty());
    }
}
