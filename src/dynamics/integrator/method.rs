//! Which method, and what it needs to know.

use strum::VariantArray;

use crate::dynamics::DynamicsError;
use crate::dynamics::control::{Accuracy, Control, Controller};

/// The choice of method, with its parameters.
#[derive(Clone, Copy, Debug, PartialEq, strum::EnumDiscriminants)]
#[strum_discriminants(
    name(MethodName),
    doc = "A [`Method`] by its name, without parameters.",
    derive(strum::VariantArray, strum::IntoStaticStr, strum::EnumString),
    strum(serialize_all = "kebab-case")
)]
pub enum Method {
    /// Exponential pair of order 5(4), free vibration exact: Lawson's integrating factor with the
    /// pair of Tsitouras. The default.
    Lawson54 {
        /// How accurate a step must be.
        accuracy: Accuracy,
        /// The longest step, s. Needing less than 1e-10 of it counts as a failure.
        max_step: f64,
    },
    /// Exponential pair of order 8(5, 3), free vibration exact: Lawson's integrating factor with the
    /// pair of [`Method::Dop853`], dense output of order 7.
    Lawson853 {
        /// How accurate a step must be.
        accuracy: Accuracy,
        /// The longest step, s. Needing less than 1e-10 of it counts as a failure.
        max_step: f64,
    },
    /// Plain embedded pair of order 5(4) of Tsitouras.
    Tsit54 {
        /// How accurate a step must be.
        accuracy: Accuracy,
        /// The longest step, s. Needing less than 1e-10 of it counts as a failure.
        max_step: f64,
    },
    /// Plain embedded pair of order 8(5, 3) of Dormand and Prince, with dense output of order 7. Pays
    /// below errors of about 1e-8 on a smooth problem.
    Dop853 {
        /// How accurate a step must be.
        accuracy: Accuracy,
        /// The longest step, s. Needing less than 1e-10 of it counts as a failure.
        max_step: f64,
    },
    /// Linearly implicit method of order 5(4), Rodas5P of Rosenbrock's kind: for a law that is stiff
    /// throughout. Needs [`System::differentiable`](crate::dynamics::System::differentiable).
    Rodas5p {
        /// How accurate a step must be.
        accuracy: Accuracy,
        /// The longest step, s. Needing less than 1e-10 of it counts as a failure.
        max_step: f64,
    },
    /// [`Method::Lawson54`], and [`Method::Rodas5p`] where the law makes that one's steps too short:
    /// where slip comes to rest. Needs [`System::differentiable`](crate::dynamics::System::differentiable).
    Auto {
        /// How accurate a step must be.
        accuracy: Accuracy,
        /// The longest step, s. Needing less than 1e-10 of it counts as a failure.
        max_step: f64,
    },
    /// Classical Runge–Kutta method of order 4.
    Rk4 {
        /// The step, s.
        step: f64,
    },
}

impl MethodName {
    /// All of them.
    pub const ALL: &[Self] = Self::VARIANTS;

    /// The name, as a scene file has it: `lawson54`.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Whether its step is given, not chosen by an estimate of the error.
    pub const fn has_fixed_step(self) -> bool {
        matches!(self, Self::Rk4)
    }

    /// The method with its parameters: one of a fixed step takes `max_step` (s) as that.
    pub const fn with(self, accuracy: Accuracy, max_step: f64) -> Method {
        match self {
            Self::Lawson54 => Method::Lawson54 { accuracy, max_step },
            Self::Lawson853 => Method::Lawson853 { accuracy, max_step },
            Self::Tsit54 => Method::Tsit54 { accuracy, max_step },
            Self::Dop853 => Method::Dop853 { accuracy, max_step },
            Self::Rodas5p => Method::Rodas5p { accuracy, max_step },
            Self::Auto => Method::Auto { accuracy, max_step },
            Self::Rk4 => Method::Rk4 { step: max_step },
        }
    }
}

impl Method {
    /// The control of the step, with its parameters checked.
    pub(super) fn control(self) -> Result<Control, DynamicsError> {
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
            | Self::Tsit54 { accuracy, max_step }
            | Self::Dop853 { accuracy, max_step }
            | Self::Lawson853 { accuracy, max_step }
            | Self::Rodas5p { accuracy, max_step }
            | Self::Auto { accuracy, max_step } => {
                accuracy.check()?;
                positive("the longest step", max_step)?;
                Ok(Control::Adaptive(Controller::new(accuracy, max_step)))
            }
            Self::Rk4 { step } => {
                positive("the step", step)?;
                Ok(Control::Fixed(step))
            }
        }
    }
}
