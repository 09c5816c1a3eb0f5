//! Keys of the points of a curve: in the scene, or in a CSV file that the scene names.

use crate::scene::document::Table;
use crate::scene::error::{Location, SceneError};
use crate::scene::schema::Key;

/// Maximum number of knots or steps.
pub const MAX_POINTS: usize = 10_000;

/// Keys of the points of a curve, a function of one variable.
pub struct KnotKeys {
    /// Table of the curve.
    pub table: &'static str,
    /// List of the knots.
    pub knots: &'static Key<usize>,
    /// Variable and value of a knot.
    pub knot: [&'static Key<f64>; 2],
    /// Name of a CSV file with knots.
    pub csv: &'static Key<String>,
    /// Name of the variable in messages, with the comparative for its order: `time`, `later`.
    pub order: [&'static str; 2],
}

/// Reads points of a list in the scene, converted to SI units. Their variable must increase.
pub fn points(
    tables: Vec<Table<'_>>,
    [variable, value]: [&Key<f64>; 2],
    order: [&str; 2],
) -> Result<Vec<[f64; 2]>, SceneError> {
    let mut points: Vec<[f64; 2]> = Vec::with_capacity(tables.len());
    for table in tables {
        let point = [table.get(variable)?, table.get(value)?];
        if points.last().is_some_and(|before| point[0] <= before[0]) {
            return Err(out_of_order(
                &table.path_of(variable.name),
                order,
                table.place(),
            ));
        }
        points.push(point);
    }
    Ok(points)
}

/// Returns the error for a variable that does not increase.
pub fn out_of_order(key: &str, [variable, later]: [&str; 2], place: Location) -> SceneError {
    let problem = format!("this {variable} is not {later} than the previous {variable}");
    let remedy = format!("sort the {variable}s in strictly increasing order");
    SceneError::inconsistent(place, key, problem, remedy)
}
