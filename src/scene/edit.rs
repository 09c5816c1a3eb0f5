//! Edits of a scene's text that preserve layout and comments.

use toml_edit::{DocumentMut, InlineTable, Item, Table, TableLike, Value};

use super::error::SceneError;
use super::schema::split;
use super::spec::Scene;
use super::tables::knots::Curve;
use super::tables::load::{ScheduleKeys, schedules};

impl Scene {
    /// The scene with other values of some keys in its text; `None` removes a key or a table. A form of the tilt, the
    /// load or the rotation replaces its other forms.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub(super) fn edited(
        &self,
        entries: impl IntoIterator<Item = (impl AsRef<str>, Option<Value>)>,
    ) -> Result<Self, SceneError> {
        let mut document = self.document()?;
        for (path, value) in entries {
            let path = path.as_ref();
            for forms in schedules().map(ScheduleKeys::paths) {
                if forms.contains(&path) {
                    for other in forms.into_iter().filter(|form| *form != path) {
                        put(&mut document, other, None);
                    }
                }
            }
            put(&mut document, path, value);
        }
        // The file of modes is unchanged and is not read again. A line number would be that of the changed text, which
        // the user has not seen.
        let file = format!("{}.toml", self.name);
        Self::parse_changed(&file, &document.to_string(), self.imported_modes())
            .map_err(|error| error.moved_to(self.place_of_override()))
    }

    /// The text of the scene for editing.
    pub(super) fn document(&self) -> Result<DocumentMut, SceneError> {
        let document = self.text.parse();
        document.map_err(|error| SceneError::syntax(self.place_of_override(), &error))
    }

    /// Position of an override in messages.
    pub(super) fn place_of_override(&self) -> String {
        format!("override of scene {}", self.name)
    }
}

/// The list of knots, in the units of the scene.
pub fn knot_list(curve: &Curve, knots: &[[f64; 2]]) -> Value {
    let tables = knots.iter().map(|knot| {
        let mut table = InlineTable::new();
        for (column, value) in curve.point.iter().zip(knot) {
            table.insert(column.name, number(*value));
        }
        table
    });
    Value::Array(tables.collect())
}

/// TOML literal of a number. Integral values are written as integers, which count and float keys both accept.
pub fn number(value: f64) -> Value {
    if value.fract() == 0.0 && value.abs() < 1e15 {
        Value::from(value as i64)
    } else {
        Value::from(value)
    }
}

/// Sets the value at a dotted path and creates missing tables; `None` removes a key or a whole table.
pub fn put(document: &mut DocumentMut, path: &str, value: Option<Value>) {
    let Some((table, name)) = enclosing(document, path) else {
        return;
    };
    let Some(mut value) = value else {
        table.remove(name);
        return;
    };
    if let Some(before) = table.get(name).and_then(Item::as_value) {
        *value.decor_mut() = before.decor().clone();
    }
    table.insert(name, Item::Value(value));
}

/// The table of a key, with the name of the key. Missing tables are created, without a heading until they have keys;
/// `None` if a value is in the place of a table, which a valid scene excludes.
fn enclosing<'d, 'p>(
    document: &'d mut DocumentMut,
    path: &'p str,
) -> Option<(&'d mut dyn TableLike, &'p str)> {
    let (tables, name) = split(path);
    let mut table: &mut dyn TableLike = document.as_table_mut();
    for part in tables.split('.').filter(|part| !part.is_empty()) {
        let new = || {
            let mut new = Table::new();
            new.set_implicit(true);
            Item::Table(new)
        };
        table = table.entry(part).or_insert_with(new).as_table_like_mut()?;
    }
    Some((table, name))
}
