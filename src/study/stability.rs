//! Linear stability over a range of tilts: Fig. 4a to 7a of the paper.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::joint::{AssemblyError, BallJoint, ExplainedMode, NamedMode, StabilityError};

/// Error of a stability study.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The joint cannot be assembled at one of the tilts.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The causes of growth are not defined for the friction law.
    #[error(
        "the causes of growth are computed for friction that depends on the slip velocity alone; omit --causes for \
         friction with a state"
    )]
    NoCauses,
    /// The eigenvalues at one of the tilts could not be computed.
    #[error("the eigenvalues at a tilt of {tilt_deg} deg could not be computed")]
    Eigenvalues {
        /// The tilt, degrees.
        tilt_deg: f64,
        /// The cause.
        source: StabilityError,
    },
}

/// Linear stability at one tilt of the load: the linear modes of steady sliding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StabilityAt {
    /// Tilt of the load, rad.
    #[serde(rename = "tilt_rad")]
    pub tilt: f64,
    /// The modes in ascending order of frequency.
    pub modes: Vec<NamedMode>,
}

impl StabilityAt {
    /// The unstable modes.
    pub fn unstable(&self) -> impl Iterator<Item = &NamedMode> {
        self.modes.iter().filter(|mode| mode.unstable)
    }
}

/// Linear modes of a joint, from its complex eigenvalues, at each of `tilts` (rad).
///
/// # Errors
/// If the joint cannot be assembled at a tilt, or its eigenvalues cannot be computed.
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

/// Oscillating modes at each of `tilts` (rad) with the causes of their growth, in ascending order of
/// frequency.
///
/// # Errors
/// As [`stability`], and if the friction law has states.
pub fn growth_causes(
    ball: &BallJoint,
    tilts: &[f64],
) -> Result<Vec<Vec<ExplainedMode>>, StudyError> {
    if ball.spec().friction.states() > 0 {
        return Err(StudyError::NoCauses);
    }
    let explained = tilts.iter().map(|&tilt| {
        let modes = ball.model(tilt)?.explained_modes();
        modes.map_err(|source| StudyError::Eigenvalues {
            tilt_deg: tilt.to_degrees(),
            source,
        })
    });
    explained.collect()
}
