//! Certificate of a cubature rule during a simulation: the force of the kept nodes compared with that of all
//! nodes at sampled states.

use serde::{Deserialize, Serialize};

use crate::dynamics::System;
use crate::joint::contact_force::KernelInput;
use crate::joint::{Joint, LANES};

/// Check of the force: force and contact status of the reduced patch compared with the full one at one state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForceCheck {
    /// `|f_reduced - f| / |f|` with the generalised force `f` of all nodes minus that of steady sliding
    /// (Euclidean norm over the modes). Zero if both forces vanish.
    pub relative_error: f64,
    /// Area of the separated nodes of the full patch, as a share of the area of all nodes.
    pub separated: f64,
    /// The same for the kept nodes with their weighted areas.
    pub separated_kept: f64,
}

impl ForceCheck {
    /// Whether nodes of the full patch are separated and no kept node is.
    pub fn missed_separation(&self) -> bool {
        self.separated > 0.0 && self.separated_kept == 0.0
    }
}

/// Checker of the force of reduced joints against that of a full one. One check costs one evaluation of the full
/// force, of the reduced force and of both contact statuses; it allocates nothing. With 1,000 nodes that is as
/// much as about 40 evaluations of 24 nodes: one check in 300 steps of seven evaluations takes 2 % of the time.
#[derive(Clone, Debug)]
pub struct ForceChecker {
    full: Joint,
    exact: Vec<f64>,
    reduced: Vec<f64>,
    status: Vec<u8>,
}

impl ForceChecker {
    /// A checker for the joint with all nodes.
    pub fn new(full: Joint) -> Self {
        let modes = full.modes();
        let bytes = full.contact_nodes().div_ceil(LANES);
        Self {
            full,
            exact: vec![0.0; modes],
            reduced: vec![0.0; modes],
            status: vec![0; bytes],
        }
    }

    /// The joint with all nodes.
    pub fn full(&self) -> &Joint {
        &self.full
    }

    /// Replaces the full joint after a change of tilt, load or rotation.
    pub fn set_full(&mut self, full: Joint) {
        *self = Self::new(full);
    }

    /// Compares a reduced joint with the full one at a state `z`.
    pub fn check(&mut self, reduced: &Joint, z: &[f64]) -> ForceCheck {
        perturbation_force(&self.full, z, &mut self.exact);
        perturbation_force(reduced, z, &mut self.reduced);
        let (mut size, mut error) = (0.0, 0.0);
        for (exact, reduced) in self.exact.iter().zip(&self.reduced) {
            size += exact * exact;
            error += (reduced - exact).powi(2);
        }
        ForceCheck {
            relative_error: if error > 0.0 {
                (error / size).sqrt()
            } else {
                0.0
            },
            separated: separated_share(&self.full, z, &mut self.status),
            separated_kept: separated_share(reduced, z, &mut self.status),
        }
    }
}

/// The generalised force at a state minus that of steady sliding, N/sqrt(kg).
pub(super) fn perturbation_force(joint: &Joint, z: &[f64], force: &mut [f64]) {
    let input = KernelInput {
        contact: joint.lift_off(),
        record: None,
        audited: false,
        z,
        out: force,
    };
    joint.contact_force(input);
}

/// Area of separated nodes divided by the area of all nodes. `status` is scratch for one bit per node.
fn separated_share(joint: &Joint, z: &[f64], status: &mut [u8]) -> f64 {
    if !joint.unilateral {
        return 0.0;
    }
    let status = &mut status[..joint.nodes.blocks.len()];
    joint.separated_nodes(&z[..joint.modes()], status);
    let (mut separated, mut total) = (0.0, 0.0);
    for (block, bits) in joint.nodes.blocks.iter().zip(status) {
        for (lane, area) in block.area.0.iter().enumerate() {
            total += area;
            if *bits >> lane & 1 == 1 {
                separated += area;
            }
        }
    }
    separated / total
}

/// Errors of the reduction over the checks of a simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReductionErrors {
    /// Number of checks.
    pub checks: u64,
    /// Maximum relative error of the force.
    #[serde(rename = "max_relative_error")]
    pub max: f64,
    /// RMS relative error of the force: the root mean square over the checks.
    #[serde(rename = "rms_relative_error")]
    pub rms: f64,
    /// Missed separations: number of checks at which nodes of the full patch were separated and no kept node was.
    pub missed_separations: u64,
    /// Largest difference of the separated shares of the area, full minus kept, in absolute value.
    pub max_separated_difference: f64,
}

impl ReductionErrors {
    /// Adds a check.
    pub fn add(&mut self, check: &ForceCheck) {
        let before = self.checks as f64;
        let squares = before * self.rms.powi(2) + check.relative_error.powi(2);
        self.checks += 1;
        self.rms = (squares / (before + 1.0)).sqrt();
        // A NaN must not be lost.
        if check.relative_error.is_nan() || check.relative_error > self.max {
            self.max = check.relative_error;
        }
        self.missed_separations += u64::from(check.missed_separation());
        let difference = (check.separated - check.separated_kept).abs();
        self.max_separated_difference = self.max_separated_difference.max(difference);
    }

    /// Whether the RMS relative error is within a tolerance, as in the training. False without checks and for an
    /// error that is not a number.
    pub fn within(&self, tolerance: f64) -> bool {
        self.checks > 0 && self.rms <= tolerance
    }
}
