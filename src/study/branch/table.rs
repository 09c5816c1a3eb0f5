//! The points of branches as a table: one row per point.

use std::io;
use std::path::Path;

use arrow_schema::FieldRef;
use serde::Serialize;
use serde_arrow::schema::{SchemaLike, TracingOptions};

use super::at::At;
use super::result::Branch;
use crate::export::OutputError;
use crate::study::table;

/// A row: an equilibrium or a periodic orbit. Values that one of them does not have are null.
#[derive(Serialize)]
struct Row {
    /// `equilibrium` or `periodic orbit`.
    kind: &'static str,
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
    /// Value of the parameter, under the name of its key.
    #[serde(flatten)]
    at: At,
}

/// Writes the points of branches: Parquet or CSV if the name ends so, otherwise an Arrow file. An existing file is
/// replaced.
///
/// # Errors
/// If the file cannot be written; an existing file is then unchanged.
pub fn write_branch(path: &Path, branch: &Branch) -> Result<(), OutputError> {
    let batch = || {
        let options = TracingOptions::default().map_as_struct(true);
        let fields = Vec::<FieldRef>::from_samples(samples(branch), options)?;
        let fields = table::columns(fields);
        serde_arrow::to_record_batch(&fields, &rows(branch))
    };
    let batch = batch().map_err(|error| OutputError {
        path: path.to_owned(),
        source: io::Error::other(error),
    })?;
    table::write(path, &batch.schema(), &[batch])
}

fn rows(branch: &Branch) -> Vec<Row> {
    let equilibria = branch.equilibria.iter().map(|point| Row {
        kind: "equilibrium",
        stable: point.unstable_modes == 0,
        unstable: point.unstable_modes as u32,
        mode_hz: point.modes.iter().map(|m| m.mode.frequency_hz).collect(),
        mode_growth_per_s: point.modes.iter().map(|m| m.mode.growth).collect(),
        mode_number: point.modes.iter().map(|m| m.number as u32).collect(),
        ..empty(point.at.clone())
    });
    let orbits = branch.points.iter().map(|point| Row {
        kind: "periodic orbit",
        branch: Some(point.branch as u32),
        stable: point.orbit.stable,
        unstable: point.orbit.unstable_multipliers as u32,
        period_s: Some(point.orbit.period_s),
        amplitude_m: Some(point.orbit.amplitude),
        multiplier_real: point.orbit.multipliers.iter().map(|m| m.re()).collect(),
        multiplier_imaginary: point.orbit.multipliers.iter().map(|m| m.im()).collect(),
        state: point.orbit.state.clone(),
        ..empty(point.at.clone())
    });
    equilibria.chain(orbits).collect()
}

/// A row without values.
fn empty(at: At) -> Row {
    Row {
        kind: "equilibrium",
        branch: None,
        stable: false,
        unstable: 0,
        period_s: None,
        amplitude_m: None,
        multiplier_real: Vec::new(),
        multiplier_imaginary: Vec::new(),
        state: Vec::new(),
        mode_hz: Vec::new(),
        mode_growth_per_s: Vec::new(),
        mode_number: Vec::new(),
        at,
    }
}

/// Rows with and without values, which determine the types of the columns.
fn samples(branch: &Branch) -> [Row; 2] {
    let at = At {
        name: branch.name().to_owned(),
        value: 0.0,
    };
    let full = Row {
        branch: Some(0),
        period_s: Some(0.0),
        amplitude_m: Some(0.0),
        multiplier_real: vec![0.0],
        multiplier_imaginary: vec![0.0],
        state: vec![0.0],
        mode_hz: vec![0.0],
        mode_growth_per_s: vec![0.0],
        mode_number: vec![0],
        ..empty(at.clone())
    };
    [full, empty(at)]
}
