//! Edits of a scene's text that preserve layout and comments.

use toml_edit::{Array, DocumentMut, InlineTable, Item, Key, Table, TableLike, Value};

use super::error::{Fault, Location, SceneError};
use super::schema::{Schema, join, split};
use super::tables::knots::FileKnots;

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

/// Replaces old names of keys and tables in a scene's text by the current ones.
///
/// # Errors
/// If the text is not valid TOML.
pub fn with_current_names(
    text: &str,
    schema: &Schema,
    place: impl FnOnce() -> Location,
) -> Result<String, SceneError> {
    let mut document: DocumentMut = text.parse().map_err(|error| syntax(&error).at(place()))?;
    rename_keys(document.as_table_mut(), "", schema);
    Ok(document.to_string())
}

/// Replaces old names in a table. All entries are removed and inserted again, which preserves their order.
fn rename_keys(table: &mut Table, path: &str, schema: &Schema) {
    let names: Vec<String> = table.iter().map(|(name, _)| name.to_owned()).collect();
    for name in names {
        let Some((key, mut item)) = table.remove_entry(&name) else {
            continue;
        };
        let current = schema.current(&join(path, &name));
        match &mut item {
            Item::Table(inner) => rename_keys(inner, &current, schema),
            Item::Value(Value::InlineTable(inner)) => rename_inline_keys(inner, &current, schema),
            _ => {}
        }
        table.insert_formatted(&renamed(key, path, &current), item);
    }
}

/// [`rename_keys`] of an inline table.
fn rename_inline_keys(table: &mut InlineTable, path: &str, schema: &Schema) {
    let names: Vec<String> = table.iter().map(|(name, _)| name.to_owned()).collect();
    for name in names {
        let Some((key, mut value)) = table.remove_entry(&name) else {
            continue;
        };
        let current = schema.current(&join(path, &name));
        if let Value::InlineTable(inner) = &mut value {
            rename_inline_keys(inner, &current, schema);
        }
        table.insert_formatted(&renamed(key, path, &current), value);
    }
}

/// The key with its current path; the formatting is preserved. `table` is the path of its table.
fn renamed(key: Key, table: &str, current: &str) -> Key {
    if join(table, key.get()) == current {
        return key;
    }
    Key::new(split(current).1)
        .with_leaf_decor(key.leaf_decor().clone())
        .with_dotted_decor(key.dotted_decor().clone())
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
