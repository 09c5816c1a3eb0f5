//! Changes to the text of a scene that leave the rest of it as it is, comments included.

use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, TableLike, Value};

use super::error::{Fault, Place, SceneError};
use super::schema::{join, split};
use super::tables::course::FileKnots;

/// Takes a key out of its table, if it is there.
pub fn remove(document: &mut DocumentMut, path: &str) {
    let (table, name) = split(path);
    if let Some(table) = document.get_mut(table).and_then(Item::as_table_like_mut) {
        table.remove(name);
    }
}

/// A scene's text with knots (time in ms, value) in place of the file that holds them, so that it says
/// all by itself: in a recording, and for whoever changes a value of it.
///
/// # Errors
/// When the text is no TOML.
pub fn with_knots(
    text: &str,
    FileKnots { keys, knots }: &FileKnots,
    place: impl FnOnce() -> Place,
) -> Result<String, SceneError> {
    let mut document: DocumentMut = text.parse().map_err(|error| syntax(&error).at(place()))?;
    let mut list = Array::new();
    for knot in knots {
        let mut table = InlineTable::new();
        for (column, value) in keys.knot.iter().zip(knot) {
            table.insert(column.name, number(*value));
        }
        list.push(table);
    }
    let table = document
        .get_mut(keys.table)
        .and_then(Item::as_table_like_mut);
    let file = table.and_then(|table: &mut dyn TableLike| {
        let file = table.remove(keys.csv.name);
        table.insert(keys.knots.name, Item::Value(list.into()));
        file
    });
    let file = file.as_ref().and_then(Item::as_str).unwrap_or_default();
    let mut text = document.to_string();
    if !text.ends_with('\n') {
        text.push('\n');
    }
    let path = join(keys.table, keys.knots.name);
    text.push_str(&format!("# {path} was read from {file:?}\n"));
    Ok(text)
}

pub fn syntax(error: &toml_edit::TomlError) -> Fault {
    Fault::Syntax {
        message: error.message().replace('\n', " "),
    }
}

/// A number as a scene file has it: a whole one stands for a count as well as for a number.
pub fn number(value: f64) -> Value {
    if value.fract() == 0.0 && value.abs() < 1e15 {
        Value::from(value as i64)
    } else {
        Value::from(value)
    }
}

/// Sets the value at a dotted path and makes the tables on the way to it.
pub fn set(root: &mut Table, path: &str, mut value: Value) {
    let (tables, name) = split(path);
    let mut table: &mut dyn TableLike = root;
    for part in tables.split('.').filter(|part| !part.is_empty()) {
        let item = table.entry(part).or_insert_with(|| {
            let mut new = Table::new();
            new.set_implicit(true);
            Item::Table(new)
        });
        match item.as_table_like_mut() {
            Some(inner) => table = inner,
            // The scene was valid: this is a table.
            None => return,
        }
    }
    if let Some(before) = table.get(name).and_then(Item::as_value) {
        *value.decor_mut() = before.decor().clone();
    }
    table.insert(name, Item::Value(value));
}
