//! Edits of a scene's text that preserve layout and comments.

use toml_edit::{DocumentMut, InlineTable, Item, Table, TableLike, Value};

use super::error::{Fault, Location, SceneError};
use super::schema::{join, split};
use super::tables::knots::{FileKnots, KnotKeys};

/// Removes a key or a whole table if it is present.
pub fn remove(document: &mut DocumentMut, path: &str) {
    let (tables, name) = split(path);
    let mut tables = tables.split('.').filter(|table| !table.is_empty());
    let table = tables.try_fold(
        document.as_table_mut() as &mut dyn TableLike,
        |table, name| table.get_mut(name)?.as_table_like_mut(),
    );
    if let Some(table) = table {
        table.remove(name);
    }
}

/// Replaces the name of a CSV file in a scene's text by the knots (variable and value) of that file. The text
/// is then self-contained and can be recorded and edited without the file.
///
/// # Errors
/// If the text is not valid TOML.
pub fn with_knots(
    text: &str,
    FileKnots { keys, knots }: &FileKnots,
    place: impl FnOnce() -> Location,
) -> Result<String, SceneError> {
    let mut document: DocumentMut = text.parse().map_err(|error| syntax(&error).at(place()))?;
    let list = knot_list(keys, knots);
    let table = document
        .get_mut(keys.table)
        .and_then(Item::as_table_like_mut);
    let file = table.and_then(|table: &mut dyn TableLike| {
        let file = table.remove(keys.csv.name);
        table.insert(keys.knots.name, Item::Value(list));
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

/// The list of knots, in the units of the keys.
pub fn knot_list(keys: &KnotKeys, knots: &[[f64; 2]]) -> Value {
    let tables = knots.iter().map(|knot| {
        let mut table = InlineTable::new();
        for (column, value) in keys.knot.iter().zip(knot) {
            table.insert(column.name, number(*value));
        }
        table
    });
    Value::Array(tables.collect())
}

pub fn syntax(error: &toml_edit::TomlError) -> Fault {
    Fault::Syntax {
        message: error.message().replace('\n', " "),
    }
}

/// TOML literal of a number. Integral values are written as integers, which count and float keys both accept.
pub fn number(value: f64) -> Value {
    if value.fract() == 0.0 && value.abs() < 1e15 {
        Value::from(value as i64)
    } else {
        Value::from(value)
    }
}

/// Sets the value at a dotted path and creates missing tables.
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
            // Not reached: the scene is valid, so this entry is a table.
            None => return,
        }
    }
    if let Some(before) = table.get(name).and_then(Item::as_value) {
        *value.decor_mut() = before.decor().clone();
    }
    table.insert(name, Item::Value(value));
}
