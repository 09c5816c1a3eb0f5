//! The choice of the step: how an error is measured, and what follows from it.
//!
//! # The measure
//!
//! Modes differ by orders of magnitude in frequency and amplitude, and the vibration as a whole
//! grows over many decades. Errors are therefore measured like the vibration itself:
//!
//! * The modes together: `size = sum_i (omega_i |q_i| + |q_i'|)`, which is between the square root
//!   of twice the vibration's energy and `sqrt(2 m)` times that. It is in the units of a velocity,
//!   and the free vibration hardly changes it.
//! * The first-order components together: `size = sum_j |w_j|`, at its largest since the start. A
//!   quadrature such as a work passes through zero without being less accurate there. Give
//!   several such components comparable units.
//!
//! An error passes where each of the two is at most `relative * (size + floor)`. At exact rest
//! with no force, the error is exactly zero and passes too.
//!
//! # The controller
//!
//! A proportional-integral controller (K. Gustafsson, ACM Trans. Math. Softw. 17 (1991) 533–554;
//! constants of Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
//! Section II.4 and their code DOPRI5): after a step with error ratio `e` following one with ratio
//! `e'`, the step is multiplied by `0.9 e^-a e'^b`, within 0.2 and 5, where `a = 0.17` and `b = 0.04`
//! for pairs of order 5(4) ([`Gain`]). A step is kept as it is when the change would be small, since the exponential methods then keep their tables.

use super::DynamicsError;

/// How accurate a step must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Error allowed in a step relative to the present size of the vibration, and of the
    /// first-order components; 1e-13 to 0.1.
    pub relative: f64,
    /// Size below which the error allowed shrinks no further, in the units of a modal velocity and
    /// of the first-order components; positive. Raise it where the force has rounding noise that
    /// does not vanish with the state: no step resolves noise.
    pub floor: f64,
}

impl Accuracy {
    /// A relative accuracy at every size of the vibration, down to 1e-290.
    pub const fn relative(relative: f64) -> Self {
        Self {
            relative,
            floor: 1e-290,
        }
    }

    /// Checks the ranges.
    pub(super) fn check(&self) -> Result<(), DynamicsError> {
        if !(1e-13..=0.1).contains(&self.relative) {
            return Err(DynamicsError::Parameter {
                name: "the relative accuracy",
                value: self.relative,
                allowed: "from 1e-13 to 0.1",
            });
        }
        if !(self.floor >= f64::MIN_POSITIVE && self.floor.is_finite()) {
            return Err(DynamicsError::Parameter {
                name: "the floor of the accuracy",
                value: self.floor,
                allowed: "positive and finite (1e-290 where nothing else is known)",
            });
        }
        Ok(())
    }
}

/// What the choice of the step and the search for events have to know of a method.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rule {
    /// How the step follows the error.
    pub gain: Gain,
    /// Parts of a step that are each searched for events by five looks at the dense output: one for a
    /// dense output of order 4, which five values determine, and more for a higher one.
    pub pieces: usize,
    /// Whether a step may shrink something by orders of magnitude.
    pub is_stiff: bool,
}

/// How the step follows the error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gain {
    /// Exponent of the error of a step accepted.
    pub error: f64,
    /// Exponent of the error of the step before it.
    pub previous: f64,
    /// Exponent of the error of a step rejected.
    pub rejection: f64,
}

/// Sizes of the two parts of a state, or of an error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Size {
    /// The modes together.
    pub vibration: f64,
    /// The first-order components together.
    pub first_order: f64,
}

impl Size {
    /// The size of `z = [q | q' | w]`, or of a difference of two.
    pub fn of(z: &[f64], omega: &[f64]) -> Self {
        let (q, rest) = z.split_at(omega.len());
        let (v, w) = rest.split_at(omega.len());
        let modes = q.iter().zip(v).zip(omega);
        Self {
            vibration: modes.map(|((q, v), omega)| omega * q.abs() + v.abs()).sum(),
            first_order: w.iter().map(|w| w.abs()).sum(),
        }
    }

    /// The larger of each part.
    pub fn max(self, other: Self) -> Self {
        Self {
            vibration: self.vibration.max(other.vibration),
            first_order: self.first_order.max(other.first_order),
        }
    }

    /// An estimate that falls faster than this one with the step, from this and a coarser one:
    /// `e^2 / sqrt(e^2 + (f / 10)^2)`, as in DOP853.
    pub fn sharpened(self, coarse: Self) -> Self {
        let sharpen = |error: f64, coarse: f64| {
            let scale = error.hypot(0.1 * coarse);
            if scale == 0.0 {
                0.0
            } else {
                error * (error / scale)
            }
        };
        Self {
            vibration: sharpen(self.vibration, coarse.vibration),
            first_order: sharpen(self.first_order, coarse.first_order),
        }
    }

    /// Whether all that was summed is finite.
    pub fn is_finite(self) -> bool {
        self.vibration.is_finite() && self.first_order.is_finite()
    }
}

/// Chooses the steps.
#[derive(Clone, Copy, Debug)]
pub(super) enum Control {
    /// Every step has the same length, s.
    Fixed(f64),
    /// Steps follow the error.
    Adaptive(Controller),
}

impl Control {
    /// The step to try next, s.
    pub fn step(&self) -> f64 {
        match self {
            Self::Fixed(step) => *step,
            Self::Adaptive(controller) => controller.step,
        }
    }

    /// Takes note of the step actually tried, s, which differs from the one wanted by the rounding
    /// of its end's time. From one step to the next that is the same number again, bit for bit, so
    /// that tables made for it stay valid.
    pub fn realise(&mut self, h: f64) {
        if let Self::Adaptive(controller) = self {
            controller.step = h;
        }
    }
}

/// A proportional-integral controller of the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Controller {
    accuracy: Accuracy,
    max_step: f64,
    /// The step to try next, s.
    pub step: f64,
    /// Error ratio of the last accepted step.
    previous: f64,
    /// Whether the step being tried follows a rejected one.
    rejected: bool,
}

impl Controller {
    /// Steps are multiplied by at least this.
    const SHRINK: f64 = 0.2;
    /// Steps are multiplied by at most this.
    const GROW: f64 = 5.0;
    /// Changes within these factors are not worth new tables.
    const KEEP: std::ops::Range<f64> = 0.95..1.15;

    /// A controller that starts with the longest step.
    pub fn new(accuracy: Accuracy, max_step: f64) -> Self {
        Self {
            accuracy,
            max_step,
            step: max_step,
            previous: 1e-4,
            rejected: false,
        }
    }

    /// Starts afresh at time `t` (s), with a step that changes the state by a hundredth of its
    /// size, or the longest one where nothing is known. `rate` is the size of the slope.
    pub fn start(&mut self, t: f64, size: Size, rate: Size) {
        let time = |size: f64, rate: f64| {
            if size > 0.0 && rate > 0.0 {
                size / rate
            } else {
                f64::INFINITY
            }
        };
        let change =
            time(size.vibration, rate.vibration).min(time(size.first_order, rate.first_order));
        *self = Self::new(self.accuracy, self.max_step);
        self.step = (0.01 * change).min(self.max_step).max(self.shortest(t));
    }

    /// The shortest step worth taking at time `t` (s): one that the time resolves, and that does
    /// not stall the integration for good.
    pub fn shortest(&self, t: f64) -> f64 {
        (16.0 * f64::EPSILON * t.abs()).max(1e-10 * self.max_step)
    }

    /// The mean step (s) below which an integration crawls: a million of them cover no more than ten of
    /// the longest.
    pub fn crawl(&self) -> f64 {
        1e-5 * self.max_step
    }

    /// The relative error allowed in a step.
    pub fn tolerance(&self) -> f64 {
        self.accuracy.relative
    }

    /// Allows another relative error in a step.
    pub fn allow(&mut self, relative: f64) -> Result<(), DynamicsError> {
        let accuracy = Accuracy {
            relative,
            ..self.accuracy
        };
        accuracy.check()?;
        self.accuracy = accuracy;
        Ok(())
    }

    /// Forbids steps longer than `max_step` (s).
    pub fn limit(&mut self, max_step: f64) {
        self.max_step = max_step;
        self.step = self.step.min(max_step);
    }

    /// The error over what the accuracy allows, for a state of some size: the step passes up to 1.
    pub fn ratio(&self, error: Size, size: Size) -> f64 {
        let part =
            |error: f64, size: f64| error / (self.accuracy.relative * (size + self.accuracy.floor));
        part(error.vibration, size.vibration).max(part(error.first_order, size.first_order))
    }

    /// Takes note of a step of full length that passed.
    pub fn accept(&mut self, ratio: f64, gain: Gain) {
        let mut factor = (0.9 * ratio.powf(-gain.error) * self.previous.powf(gain.previous))
            .clamp(Self::SHRINK, Self::GROW);
        if self.rejected {
            factor = factor.min(1.0);
        }
        let step = (self.step * factor).min(self.max_step);
        if !Self::KEEP.contains(&(step / self.step)) {
            self.step = step;
        }
        self.previous = ratio.max(1e-4);
        self.rejected = false;
    }

    /// Shortens the step after one of length `h` (s) that failed; the ratio may be infinite or not
    /// a number.
    pub fn reject(&mut self, h: f64, ratio: f64, gain: Gain) {
        let factor = 0.9 * ratio.powf(-gain.rejection);
        self.step = h * if factor > Self::SHRINK {
            factor
        } else {
            Self::SHRINK
        };
        self.rejected = true;
    }
}

/// The longest step (s) with which the classical Runge-Kutta method keeps `exp(rate t)` from growing,
/// for a rate `[real, imaginary]` (1/s). What grows by itself may grow: its real part counts as zero.
/// Infinite for a rate of zero.
///
/// The method multiplies by `R(x) = 1 + x + x^2/2 + x^3/6 + x^4/24`, `x = rate h`, which stays within the
/// unit circle up to `h |rate| = 2.785` on the real axis and `2 sqrt(2)` on the imaginary one.
pub fn longest_rk4_step(rate: [f64; 2]) -> f64 {
    let [re, im] = [rate[0].min(0.0), rate[1]];
    let size = re.hypot(im);
    if size == 0.0 {
        return f64::INFINITY;
    }
    let [re, im] = [re / size, im / size];
    let growth = |x: f64| {
        // Horner's scheme of R at x (re + i im).
        let (mut a, mut b) = (1.0, 0.0);
        for k in [4.0, 3.0, 2.0, 1.0] {
            (a, b) = (1.0 + x / k * (re * a - im * b), x / k * (re * b + im * a));
        }
        a.hypot(b)
    };
    // The border is crossed once, beyond 2.5 and before 3.5 in all directions of the left half plane.
    let (mut low, mut high) = (2.5, 3.5);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if growth(middle) <= 1.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    low / size
}

#[cfg(test)]
mod tests {
    use super::longest_rk4_step;

    #[test]
    fn fixed_steps_end_at_the_border_of_stability() {
        let close = |got: f64, want: f64| assert!((got / want - 1.0).abs() < 1e-6, "{got} {want}");
        close(longest_rk4_step([0.0, 2.0]), 2.0_f64.sqrt());
        close(longest_rk4_step([-10.0, 0.0]), 0.278_529_356_3);
        // What grows is followed as if it did not.
        assert_eq!(longest_rk4_step([7.0, 2.0]), longest_rk4_step([0.0, 2.0]));
        assert_eq!(longest_rk4_step([0.0, 0.0]), f64::INFINITY);
        // Everywhere in between the method just neither grows nor shrinks there.
        for k in 0..=90 {
            let (im, re) = f64::from(k).to_radians().sin_cos();
            let h = longest_rk4_step([-re, im]);
            assert!((2.5..3.5).contains(&h), "{k}: {h}");
        }
    }
}
