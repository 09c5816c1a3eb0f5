//! Linear stability over a range of tilts: Fig. 4a to 7a of the paper.

use crate::joint::{AssemblyError, BallJoint, ExplainedMode, LinearMode, StabilityError};

/// Why a study failed.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The joint cannot be assembled at one of the tilts.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The eigenvalues at one of the tilts could not be found.
    #[error("at a tilt of {tilt_deg} deg")]
    Eigenvalues {
        /// The tilt, degrees.
        tilt_deg: f64,
        /// What went wrong.
        source: StabilityError,
    },
}

/// The linear modes at one tilt.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityAt {
    /// Tilt of the load, rad.
    pub tilt: f64,
    /// The modes by ascending frequency.
    pub modes: Vec<StabilityMode>,
}

impl StabilityAt {
    /// The unstable modes.
    pub fn unstable(&self) -> impl Iterator<Item = &StabilityMode> {
        self.modes.iter().filter(|mode| mode.unstable)
    }
}

/// One mode of the linearised joint.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityMode {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Growth rate, 1/s; positive means that steady sliding is unstable.
    pub growth: f64,
    /// Which mode of the body it is, such as `2nd bending`.
    pub label: String,
    /// Whether it grows.
    pub unstable: bool,
}

/// Complex eigenvalues of a joint at each of some tilts (rad).
///
/// # Errors
/// If the joint cannot be assembled at a tilt, or its eigenvalues not be found.
pub fn stability(ball: &BallJoint, tilts: &[f64]) -> Result<Vec<StabilityAt>, StudyError> {
    tilts
        .iter()
        .map(|&tilt| {
            let joint = ball.joint(tilt)?;
            let modes = joint
                .linear_modes()
                .map_err(|source| StudyError::Eigenvalues {
                    tilt_deg: tilt.to_degrees(),
                    source,
                })?;
            let modes = modes.iter().map(|mode| describe(ball, mode)).collect();
            Ok(StabilityAt { tilt, modes })
        })
        .collect()
}

/// The oscillating modes at each of some tilts (rad) with the causes of their growth, by ascending
/// frequency.
///
/// # Errors
/// As [`stability`].
pub fn growth_causes(
    ball: &BallJoint,
    tilts: &[f64],
) -> Result<Vec<Vec<ExplainedMode>>, StudyError> {
    let explained = tilts.iter().map(|&tilt| {
        let modes = ball.model(tilt)?.explained_modes();
        modes.map_err(|source| StudyError::Eigenvalues {
            tilt_deg: tilt.to_degrees(),
            source,
        })
    });
    explained.collect()
}

fn describe(ball: &BallJoint, mode: &LinearMode) -> StabilityMode {
    let labels = ball.family_labels();
    // The two members of a bending pair may mix in any proportion: their shares count together.
    let share = |label: &str| -> f64 {
        let of_family = labels
            .iter()
            .zip(&mode.shares)
            .filter(|(of, _)| *of == label);
        of_family.map(|(_, share)| share).sum()
    };
    let label = labels
        .iter()
        .max_by(|a, b| share(a).total_cmp(&share(b)))
        .cloned()
        .unwrap_or_default();
    StabilityMode {
        frequency_hz: mode.frequency_hz,
        growth: mode.growth,
        label,
        unstable: mode.unstable(),
    }
}
