//! The points of branches as a table: one row per point.

use std::path::Path;

use arrow_schema::{DataType, Field, FieldRef};
use serde::{Deserialize, Serialize};
use serde_arrow::schema::{SchemaLike, TracingOptions};

use super::result::{At, Branch};
use crate::export::OutputError;
use crate::study::table;

/// A row: an equilibrium or a periodic orbit. Values that one of them does not have are null.
#[derive(Default, Serialize, Deserialize)]
struct Row {
    /// `equilibrium` or `periodic orbit`.
    kind: String,
    /// Number of the branch of periodic orbits.
    branch: Option<u32>,
    /// Whether the motion is stable: it attracts.
    stable: bool,
    /// Number of unstable modes, or of multipliers outside the unit circle.
    unstable: u32,
    /// Period, s.
    period_s: Option<f64>,
    /// Half the range of the displacement at the probe, m.
    amplitude_m: Option<f64>,
    /// Multipliers, largest first: real parts.
    multiplier_real: Vec<f64>,
    /// Multipliers, largest first: imaginary parts.
    multiplier_imaginary: Vec<f64>,
    /// State at phase zero.
    state: Vec<f64>,
    /// Frequencies of the modes of an equilibrium, Hz.
    mode_hz: Vec<f64>,
    /// Growth rates of the modes of an equilibrium, 1/s.
    mode_growth_per_s: Vec<f64>,
    /// Numbers of the modes of an equilibrium.
    mode_number: Vec<u32>,
}

/// A row with the value of the parameter, under the name of its key.
#[derive(Serialize)]
struct RowAt<'a> {
    #[serde(flatten)]
    row: Row,
    #[serde(flatten)]
    at: &'a At,
}

/// Writes the points of branches: Parquet or CSV if the name ends so, otherwise an Arrow file. An existing file is
/// replaced.
///
/// # Errors
/// If the file cannot be written; an existing file is then unchanged.
pub fn write_branch(path: &Path, branch: &Branch) -> Result<(), OutputError> {
    let fields = Vec::<FieldRef>::from_type::<Row>(TracingOptions::default());
    let fields = fields.map(|mut fields| {
        fields.push(Field::new(branch.name(), DataType::Float64, false).into());
        fields
    });
    table::write(path, table::schema(fields), &rows(branch))
}

fn rows(branch: &Branch) -> Vec<RowAt<'_>> {
    let equilibria = branch.equilibria.iter().map(|point| RowAt {
        at: &point.at,
        row: Row {
            kind: "equilibrium".to_owned(),
            stable: point.unstable_modes == 0,
            unstable: point.unstable_modes as u32,
            mode_hz: point.modes.iter().map(|m| m.mode.frequency_hz).collect(),
            mode_growth_per_s: point.modes.iter().map(|m| m.mode.growth).collect(),
            mode_number: point.modes.iter().map(|m| m.number as u32).collect(),
            ..Row::default()
        },
    });
    let orbits = branch.points.iter().map(|point| RowAt {
        at: &point.at,
        row: Row {
            kind: "periodic orbit".to_owned(),
            branch: Some(point.branch as u32),
            stable: point.orbit.stable,
            unstable: point.orbit.unstable_multipliers as u32,
            period_s: Some(point.orbit.period_s),
            amplitude_m: Some(point.orbit.amplitude),
            multiplier_real: point.orbit.multipliers.iter().map(|m| m.re()).collect(),
            multiplier_imaginary: point.orbit.multipliers.iter().map(|m| m.im()).collect(),
            state: point.orbit.state.clone(),
            ..Row::default()
        },
    });
    equilibria.chain(orbits).collect()
}
