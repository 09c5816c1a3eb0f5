//! Linear stability over a range of tilts: Fig. 4a to 7a of the paper.

use serde::Serialize;

use crate::joint::{AssemblyError, BallJoint, ExplainedMode, NamedMode, StabilityError};

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
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StabilityAt {
    /// Tilt of the load, rad.
    #[serde(rename = "tilt_rad")]
    pub tilt: f64,
    /// The modes by ascending frequency.
    pub modes: Vec<NamedMode>,
}

impl StabilityAt {
    /// The unstable modes.
    pub fn unstable(&self) -> impl Iterator<Item = &NamedMode> {
        self.modes.iter().filter(|mode| mode.unstable)
    }
}

/// Complex eigenvalues of a joint at each of some tilts (rad).
///
/// # Errors
/// If the joint cannot be assembled at a tilt, or its eigenvalues not be found.
pub fn stability(ball: &BallJoint, tilts: &[f64]) -> Result<Vec<StabilityAt>, StudyError> {
    let families = ball.family_labels();
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
            let modes = modes.iter().map(|mode| mode.named(&families)).collect();
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
