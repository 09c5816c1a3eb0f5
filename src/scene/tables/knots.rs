//! Curves: lists of points in the scene, or in a CSV file that the scene names.

use crate::scene::document::Document;
use crate::scene::error::SceneError;
use crate::scene::schema::{Key, Schema, join};

/// Maximum number of knots or steps.
pub const MAX_POINTS: usize = 10_000;

/// A function of one variable as a list of points.
pub struct Curve {
    /// Table of the list.
    pub table: &'static str,
    /// The list.
    pub list: &'static Key<usize>,
    /// Variable and value of a point.
    pub point: [&'static Key<f64>; 2],
    /// Name of the variable in messages, with the comparative for its order: `time`, `later`.
    pub order: [&'static str; 2],
}

impl Curve {
    /// Dotted path of the list.
    pub fn path(&self) -> String {
        join(self.table, self.list.name)
    }

    /// Adds the keys to the schema.
    pub fn declare(&self, schema: &mut Schema) {
        schema.add(self.table, self.list);
        for key in self.point {
            schema.add(&self.path(), key);
        }
    }

    /// Reads the points of the scene, converted to SI units.
    pub fn points(&self, document: &Document<'_>) -> Result<Vec<[f64; 2]>, SceneError> {
        let [variable, value] = self.point;
        let mut points = Vec::new();
        for table in document.table(self.table).list(self.list)? {
            let point = [table.get(variable)?, table.get(value)?];
            self.append(&mut points, point, || table.place())?;
        }
        Ok(points)
    }

    /// Appends a point, whose variable must be larger than that of the previous one.
    pub fn append(
        &self,
        points: &mut Vec<[f64; 2]>,
        point: [f64; 2],
        place: impl FnOnce() -> String,
    ) -> Result<(), SceneError> {
        if points.last().is_some_and(|before| point[0] <= before[0]) {
            let [variable, later] = self.order;
            let problem = format!("this {variable} is not {later} than the previous {variable}");
            let remedy = format!("sort the {variable}s in strictly increasing order");
            let key = join(&self.path(), self.point[0].name);
            return Err(SceneError::inconsistent(place(), key, problem, remedy));
        }
        points.push(point);
        Ok(())
    }
}
