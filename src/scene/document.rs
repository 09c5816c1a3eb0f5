//! A parsed scene file: TOML in which every key and value keeps its position in the text.
//!
//! Values are read by [`Key`]: a [`Table`] finds the value, and the kind of the key converts it. A fault
//! becomes a [`SceneError`] with file, line and key.

use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use toml_edit::{Item, TableLike, Value};

use super::error::{SceneError, did_you_mean, nearest_path};
use super::schema::kind::Mismatch;
use super::schema::{Declared, IfAbsent, Key, Schema, join, split};
use super::tables::SCHEMA;
use super::tables::load::constant_of;
use crate::joint::ImportedModes;

/// A parsed scene file that contains declared keys only.
pub(super) struct Document<'t> {
    file: &'t str,
    /// Imported modes that need not be read again.
    pub known_modes: Option<&'t Arc<ImportedModes>>,
    toml: toml_edit::Document<&'t str>,
}

/// A table of a scene file, present or absent, or an element of a list of tables such as `[[load.tilt]]`.
#[derive(Clone, Copy)]
pub(super) struct Table<'d> {
    pub document: &'d Document<'d>,
    /// Dotted path.
    path: &'d str,
    given: Option<&'d dyn TableLike>,
    /// Byte offset of the table, or of the nearest enclosing table that is present.
    offset: usize,
}

impl<'t> Document<'t> {
    /// Parses a text and rejects undeclared keys. `file` names the source in messages.
    pub fn parse(file: &'t str, text: &'t str) -> Result<Self, SceneError> {
        let toml = toml_edit::Document::parse(text).map_err(|error| {
            let start = error.span().unwrap_or_default().start;
            SceneError::syntax(place_in(file, text, start), &error)
        })?;
        let document = Self {
            file,
            known_modes: None,
            toml,
        };
        document.reject_unknown(document.toml.as_table(), "")?;
        Ok(document)
    }

    /// Path of the scene file; those of other files are relative to its folder.
    pub fn path(&self) -> &'t Path {
        Path::new(self.file)
    }

    /// Returns the table at a dotted path.
    pub fn table<'d>(&'d self, path: &'d str) -> Table<'d> {
        let (item, offset) = self.find(path);
        Table {
            document: self,
            path,
            given: item.and_then(Item::as_table_like),
            offset,
        }
    }

    /// The item at a dotted path, and the byte offset of the item or of the nearest enclosing table that is present.
    fn find(&self, path: &str) -> (Option<&Item>, usize) {
        let (mut item, mut offset) = (Some(self.toml.as_item()), 0);
        for part in path.split('.').filter(|part| !part.is_empty()) {
            let table = item.and_then(Item::as_table_like);
            let entry = table.and_then(|table| entry(table, part));
            offset = entry.as_ref().map_or(offset, |(_, span)| span.start);
            item = entry.map(|(item, _)| item);
        }
        (item, offset)
    }

    /// Whether the file contains a table or key.
    pub fn has(&self, path: &str) -> bool {
        self.offset(path).is_some()
    }

    /// Position of the last of the given keys that is present, else the first line of the file.
    pub fn place_of<'p>(&self, paths: impl IntoIterator<Item = &'p str>) -> String {
        let offsets = paths.into_iter().filter_map(|path| self.offset(path));
        self.place(offsets.max().unwrap_or(0))
    }

    /// As [`Table::inconsistent`], with dotted paths.
    pub fn inconsistent(
        &self,
        key: &str,
        others: &[&str],
        problem: impl fmt::Display,
        remedy: impl fmt::Display,
    ) -> SceneError {
        self.table("").inconsistent(key, others, problem, remedy)
    }

    fn place(&self, offset: usize) -> String {
        place_in(self.file, self.toml.raw(), offset)
    }

    /// Byte offset of the table or value at a dotted path.
    fn offset(&self, path: &str) -> Option<usize> {
        if cfg!(test) {
            let is_declared = SCHEMA.find(path).is_some() || SCHEMA.has_table(path);
            assert!(is_declared, "{path}");
        }
        let (item, offset) = self.find(path);
        item.map(|_| offset)
    }

    /// Where a key without its table and its value are in the text.
    pub fn span(&self, path: &str) -> Option<Range<usize>> {
        let (table, name) = split(path);
        let (key, item) = self.table(table).given?.get_key_value(name)?;
        Some(key.span()?.start..item.span()?.end)
    }

    /// First line of a value as written, shortened for messages.
    fn excerpt(&self, span: Range<usize>) -> String {
        const LONGEST: usize = 40;
        let written = self.toml.raw().get(span).unwrap_or_default();
        let line = written.lines().next().unwrap_or_default();
        match line.char_indices().nth(LONGEST) {
            Some((end, _)) => format!("{}...", &line[..end]),
            None if line.len() < written.len() => format!("{line} ..."),
            None => line.to_owned(),
        }
    }

    /// Rejects the first undeclared key of the text, in reading order.
    fn reject_unknown(&self, table: &dyn TableLike, path: &str) -> Result<(), SceneError> {
        for (name, item) in table.iter() {
            let span = table.key(name).and_then(toml_edit::Key::span);
            let span = span.unwrap_or_default();
            let full = join(path, name);
            match (SCHEMA.find(&full).is_some(), SCHEMA.has_table(&full)) {
                (false, false) => return Err(self.unknown(path, span)),
                (false, true) => match item.as_table_like() {
                    Some(inner) => self.reject_unknown(inner, &full)?,
                    None => {
                        let problem = format!("`{full}` is a table, not a value");
                        let remedy = format!("write `[{full}]` and its keys below");
                        return Err(SceneError::new(self.place(span.start), problem, remedy));
                    }
                },
                (true, true) => {
                    for (inner, _) in elements(item) {
                        self.reject_unknown(inner, &full)?;
                    }
                }
                // A declared key: its kind checks the value when it is read.
                (true, false) => {}
            }
        }
        Ok(())
    }

    fn unknown(&self, table: &str, span: Range<usize>) -> SceneError {
        // As written and shortened: a name can be as long as the file.
        let written = self.excerpt(span.clone());
        let siblings = SCHEMA.names_in(table);
        let tables = SCHEMA.0.iter().map(|key| &key.table[..]);
        let subtables = tables.filter(|inner| split(inner).0 == table);
        let nearest = nearest_path(&join(table, &written), SCHEMA.paths().chain(subtables));
        let place = match table {
            "" => "the top level".to_owned(),
            table => format!("[{table}]"),
        };
        let (key, meant) = (join(table, &written), did_you_mean(nearest));
        let remedy = format!("{place} has the keys {}", siblings.join(", "));
        let problem = format!("unknown key `{key}`{meant}");
        SceneError::new(self.place(span.start), problem, remedy)
    }
}

impl<'d> Table<'d> {
    /// Whether the file contains this table.
    pub fn is_given(self) -> bool {
        self.given.is_some()
    }

    /// Whether the table contains a key.
    pub fn has(self, name: &str) -> bool {
        self.given.is_some_and(|table| table.contains_key(name))
    }

    /// Dotted path of a key of this table. A name with a dot is already a path.
    pub fn path_of(self, name: &str) -> String {
        if name.contains('.') {
            name.to_owned()
        } else {
            join(self.path, name)
        }
    }

    /// Position of the table, or of the nearest enclosing table that is present.
    pub fn place(self) -> String {
        self.document.place(self.offset)
    }

    /// Reads a key, or its default if it is absent.
    pub fn get<T>(self, key: &Key<T>) -> Result<T, SceneError> {
        match (self.find(key)?, key.if_absent) {
            (Some(value), _) => Ok(value),
            (None, IfAbsent::Default(literal)) => {
                let value = literal.parse::<Value>().ok();
                let value = value.and_then(|value| key.kind.read(&value).ok());
                Ok(value.expect("a valid default: a test reads all of them"))
            }
            (None, _) => Err(self.missing(key.name)),
        }
    }

    /// Reads a key if it is present.
    pub fn find<T>(self, key: &Key<T>) -> Result<Option<T>, SceneError> {
        let Some((item, span)) = self.given.and_then(|table| entry(table, key.name)) else {
            return Ok(None);
        };
        // Tables with a heading become values, too.
        let value = item.clone().into_value().map_err(|_| Mismatch::Type);
        let value = value.and_then(|value| key.kind.read(&value));
        value.map(Some).map_err(|mismatch| {
            let path = self.path_of(key.name);
            let mut expected = key.kind.limits.expected();
            let is_number = item.is_integer() || item.is_float();
            if is_number && let Some(constant) = constant_of(&path) {
                expected += &format!("; a constant is `{constant}`");
            }
            let found = self.document.excerpt(span.clone());
            mismatch.at(self.document.place(span.start), &path, &expected, &found)
        })
    }

    /// Whether the value of a key is a list.
    pub fn is_list(self, name: &str) -> bool {
        let item = self.given.and_then(|table| table.get(name));
        item.is_some_and(Item::is_array)
    }

    /// Returns a value that other keys of the table require, or the error for its absence.
    pub fn needed<T>(self, name: &str, value: Option<T>) -> Result<T, SceneError> {
        value.ok_or_else(|| self.missing(name))
    }

    /// Rejects keys that are incompatible with `others`.
    pub fn reject(
        self,
        names: &[&str],
        others: &[&str],
        problem: &str,
        remedy: &str,
    ) -> Result<(), SceneError> {
        match names.iter().find(|name| self.has(name)) {
            None => Ok(()),
            Some(name) => Err(self.inconsistent(name, others, problem, remedy)),
        }
    }

    /// Rejects parameters of other laws than the one that a key selects, since they would have no effect.
    pub fn reject_unused(self, selector: &str, law: &str) -> Result<(), SceneError> {
        let is_unused = |key: &&Declared| {
            key.table == self.path && !key.laws.is_empty() && !key.laws.contains(&law)
        };
        let unused = SCHEMA.0.iter().filter(is_unused).map(|key| key.name);
        let remedy = format!("remove it, or choose another {}", self.path_of(selector));
        let problem = "the selected law does not use this parameter";
        self.reject(&unused.collect::<Vec<_>>(), &[selector], problem, &remedy)
    }

    /// Returns the error for values that are inconsistent with each other. The position is that of the last
    /// key of the group in the file.
    pub fn inconsistent(
        self,
        name: &str,
        others: &[&str],
        problem: impl fmt::Display,
        remedy: impl fmt::Display,
    ) -> SceneError {
        let names = others.iter().chain([&name]);
        let paths: Vec<String> = names.map(|name| self.path_of(name)).collect();
        let place = self.document.place_of(paths.iter().map(|path| &path[..]));
        SceneError::inconsistent(place, self.path_of(name), problem, remedy)
    }

    /// Returns the error for an absent key that is required here.
    fn missing(self, name: &str) -> SceneError {
        let path = self.path_of(name);
        let declared = SCHEMA.find(&path).expect("a key of this table");
        let remedy = format!("it must be {}", declared.expected_if_missing());
        SceneError::new(self.place(), format!("`{path}` is missing"), remedy)
    }

    /// Elements of a list of tables; empty if the list is absent.
    pub fn list(self, key: &Key<usize>) -> Result<Vec<Table<'d>>, SceneError> {
        self.find(key)?;
        let path = self.path_of(key.name);
        let declared = SCHEMA.find(&path).expect("a key of this table");
        let list = self.given.and_then(|table| table.get(key.name));
        let tables = list.map(elements).unwrap_or_default().into_iter();
        let tables = tables.map(|(table, span)| Table {
            document: self.document,
            path: &declared.path,
            given: Some(table),
            offset: span.start,
        });
        Ok(tables.collect())
    }
}

/// An item of a table with its position. A table without a heading of its own is at its name.
fn entry<'d>(table: &'d dyn TableLike, name: &str) -> Option<(&'d Item, Range<usize>)> {
    let (key, item) = table.get_key_value(name)?;
    let span = item.span().or_else(|| key.span());
    Some((item, span.unwrap_or_default()))
}

/// The tables of a list with their positions.
fn elements(item: &Item) -> Vec<(&dyn TableLike, Range<usize>)> {
    let headed = item.as_array_of_tables().into_iter().flatten();
    let headed = headed.map(|table| (table as &dyn TableLike, table.span()));
    let inline = item.as_array().into_iter().flatten();
    let inline = inline.filter_map(Value::as_inline_table);
    let inline = inline.map(|table| (table as &dyn TableLike, table.span()));
    let all = headed.chain(inline);
    all.map(|(table, span)| (table, span.unwrap_or_default()))
        .collect()
}

/// A type that is read from the keys of a table.
pub(super) trait FromTable: Sized {
    /// Adds the keys to the schema.
    fn declare(schema: &mut Schema, table: &str);

    /// Reads the keys; absent ones take their defaults.
    fn read(table: Table<'_>) -> Result<Self, SceneError>;
}

/// A table that may be absent.
impl<T: FromTable> FromTable for Option<T> {
    fn declare(schema: &mut Schema, table: &str) {
        T::declare(schema, table);
    }

    fn read(table: Table<'_>) -> Result<Self, SceneError> {
        table.is_given().then(|| T::read(table)).transpose()
    }
}

/// File and line of a byte offset, such as `mine.toml:3`.
pub(super) fn place_in(file: &str, text: &str, offset: usize) -> String {
    let before = &text.as_bytes()[..offset.min(text.len())];
    let line = before.iter().filter(|&&byte| byte == b'\n').count() + 1;
    format!("{file}:{line}")
}
