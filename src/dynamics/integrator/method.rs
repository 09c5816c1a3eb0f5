//! The integration methods and their parameters.

use strum::VariantArray;

use crate::dynamics::DynamicsError;
use crate::dynamics::error_control::{Accuracy, PiController, StepSizeControl};

/// An integration method with its parameters.
#[derive(Clone, Copy, Debug, PartialEq, strum::EnumDiscriminants)]
#[strum_discriminants(
    name(MethodName),
    doc = "The name of a [`Method`], without parameters.",
    derive(strum::VariantArray, strum::IntoStaticStr, strum::EnumString),
    strum(serialize_all = "kebab-case")
)]
pub enum Method {
    /// Exponential pair of order 5(4) with exact free vibration: Lawson's integrating factor with the
    /// pair of Tsitouras. The default.
    Lawson54 {
        /// Error tolerance per step.
        accuracy: Accuracy,
        /// Maximum step, s. The integration fails if it needs less than 1e-10 of this.
        max_step: f64,
    },
    /// Exponential method of order 8(5, 3) with exact free vibration: Lawson's integrating factor with
    /// the tableau of [`Method::Dop853`]; dense output of order 7.
    Lawson853 {
        /// Error tolerance per step.
        accuracy: Accuracy,
        /// Maximum step, s. The integration fails if it needs less than 1e-10 of this.
        max_step: f64,
    },
    /// Embedded pair of order 5(4) of Tsitouras, plain form.
    Tsit5 {
        /// Error tolerance per step.
        accuracy: Accuracy,
        /// Maximum step, s. The integration fails if it needs less than 1e-10 of this.
        max_step: f64,
    },
    /// Embedded method of order 8(5, 3) of Dormand and Prince, plain form, with dense output of order 7.
    /// More efficient than order 5 below relative errors of about 1e-8 on a smooth problem.
    Dop853 {
        /// Error tolerance per step.
        accuracy: Accuracy,
        /// Maximum step, s. The integration fails if it needs less than 1e-10 of this.
        max_step: f64,
    },
    /// Rodas5P, a linearly implicit (Rosenbrock) method of order 5(4), for systems that are stiff throughout.
    /// Needs [`System::differentiable`](crate::dynamics::System::differentiable).
    #[strum_discriminants(strum(to_string = "rodas5p"))]
    Rodas5P {
        /// Error tolerance per step.
        accuracy: Accuracy,
        /// Maximum step, s. The integration fails if it needs less than 1e-10 of this.
        max_step: f64,
    },
    /// [`Method::Lawson54`], and [`Method::Rodas5P`] while stiffness limits the explicit step, for
    /// example during the transition from sliding to sticking. Needs
    /// [`System::differentiable`](crate::dynamics::System::differentiable).
    Auto {
        /// Error tolerance per step.
        accuracy: Accuracy,
        /// Maximum step, s. The integration fails if it needs less than 1e-10 of this.
        max_step: f64,
    },
    /// Classical Runge–Kutta method of order 4.
    Rk4 {
        /// Step length, s.
        step: f64,
    },
}

impl MethodName {
    /// All method names.
    pub const ALL: &[Self] = Self::VARIANTS;

    /// The name on the command line and in scene files, for example `lawson54`.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Whether the method takes fixed steps, without error estimate.
    pub const fn has_fixed_step(self) -> bool {
        matches!(self, Self::Rk4)
    }

    /// The method with the given parameters. A fixed-step method uses `max_step` (s) as its step.
    pub const fn with(self, accuracy: Accuracy, max_step: f64) -> Method {
        match self {
            Self::Lawson54 => Method::Lawson54 { accuracy, max_step },
            Self::Lawson853 => Method::Lawson853 { accuracy, max_step },
            Self::Tsit5 => Method::Tsit5 { accuracy, max_step },
            Self::Dop853 => Method::Dop853 { accuracy, max_step },
            Self::Rodas5P => Method::Rodas5P { accuracy, max_step },
            Self::Auto => Method::Auto { accuracy, max_step },
            Self::Rk4 => Method::Rk4 { step: max_step },
        }
    }
}

impl Method {
    /// The step-size control, with checked parameters.
    pub(super) fn control(self) -> Result<StepSizeControl, DynamicsError> {
        let positive = |name, value: f64| {
            if value > 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(DynamicsError::Parameter {
                    name,
                    value,
                    allowed: "positive and finite",
                })
            }
        };
        match self {
            Self::Lawson54 { accuracy, max_step }
            | Self::Tsit5 { accuracy, max_step }
            | Self::Dop853 { accuracy, max_step }
            | Self::Lawson853 { accuracy, max_step }
            | Self::Rodas5P { accuracy, max_step }
            | Self::Auto { accuracy, max_step } => {
                accuracy.check()?;
                positive("the maximum step", max_step)?;
                Ok(StepSizeControl::Adaptive(PiController::new(
                    accuracy, max_step,
                )))
            }
            Self::Rk4 { step } => {
                positive("the step", step)?;
                Ok(StepSizeControl::Fixed(step))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::MethodName;

    #[test]
    fn names_are_parsed() {
        for method in MethodName::ALL {
            assert_eq!(method.name().parse(), Ok(*method));
        }
        assert_eq!(MethodName::Tsit5.name(), "tsit5");
        assert_eq!(MethodName::Rodas5P.name(), "rodas5p");
    }
}
