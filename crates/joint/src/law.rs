//! The friction law of a joint, chosen from those that the hot loop knows.

use std::sync::Arc;

use super::dynamic_friction::DynamicFriction;
use super::friction::{Constant, FrictionLaw, Stribeck};
use super::friction_table::FrictionTable;

/// Friction law of a joint.
#[derive(Clone, Debug, PartialEq)]
pub enum Friction {
    /// No friction.
    None,
    /// Coulomb friction with constant coefficient, regularised at zero slip.
    Constant {
        /// The law.
        law: Constant,
        /// Whether the radial part `(V . e_r) Phi_r` of Eq. (8) is included.
        radial: bool,
    },
    /// A Stribeck curve, regularised at zero slip.
    Stribeck {
        /// The law.
        law: Stribeck,
        /// Whether the radial part `(V . e_r) Phi_r` of Eq. (8) is included.
        radial: bool,
    },
    /// A measured curve, regularised at zero slip.
    Table {
        /// The law.
        law: Arc<FrictionTable>,
        /// Whether the radial part `(V . e_r) Phi_r` of Eq. (8) is included.
        radial: bool,
    },
    /// A law with an internal state at each node.
    Dynamic {
        /// The law.
        law: DynamicFriction,
        /// Whether the radial part `(V . e_r) Phi_r` of Eq. (8) is included.
        radial: bool,
    },
}

impl Friction {
    /// The law as a function of the slip velocity alone; `None` without friction, and with an internal state.
    pub fn law(&self) -> Option<&dyn FrictionLaw> {
        match self {
            Self::None | Self::Dynamic { .. } => None,
            Self::Constant { law, .. } => Some(law),
            Self::Stribeck { law, .. } => Some(law),
            Self::Table { law, .. } => Some(law.as_ref()),
        }
    }

    /// Number of internal states per contact node.
    pub fn states(&self) -> usize {
        match self {
            Self::Dynamic { law, radial } => law.states(if *radial { 3 } else { 2 }),
            _ => 0,
        }
    }

    /// Whether friction includes the radial slip velocity.
    pub fn radial(&self) -> bool {
        match *self {
            Self::None => false,
            Self::Constant { radial, .. }
            | Self::Stribeck { radial, .. }
            | Self::Table { radial, .. }
            | Self::Dynamic { radial, .. } => radial,
        }
    }
}
