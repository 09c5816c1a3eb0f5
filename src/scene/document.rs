//! A parsed scene file: TOML in which every key and value keeps its position in the text.
//!
//! Values are read by [`Key`]: a [`Table`] finds the value, and the kind of the key converts it. A fault
//! becomes a [`SceneError`] with file, line and key.

use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::error::{CLOSE, Fault, Location, SceneError, VERY_CLOSE, nearest};
use super::schema::kind::{Kind, Mismatch, Tables};
use super::schema::{IfAbsent, Key, Schema, join, split};

/// A parsed scene file that contains declared keys only.
pub(super) struct Document<'t> {
    file: &'t str,
    text: &'t str,
    root: DeTable<'t>,
    /// The declared keys.
    pub schema: &'static Schema,
}

/// A table of a scene file, present or absent, or an element of a list of tables such as `[[load.tilt]]`.
#[derive(Clone, Copy)]
pub(super) struct Table<'d> {
    pub document: &'d Document<'d>,
    /// Dotted path.
    path: &'d str,
    given: Option<&'d DeTable<'d>>,
    /// Byte offset of the table, or of the nearest enclosing table that is present.
    offset: usize,
}

impl<'t> Document<'t> {
    /// Parses a text and rejects undeclared keys. `file` names the source in messages.
    pub fn parse(
        file: &'t str,
        text: &'t str,
        schema: &'static Schema,
    ) -> Result<Self, SceneError> {
        let root = DeTable::parse(text).map_err(|error| {
            let message = error.message().replace('\n', " ");
            let line = error.span().map(|span| line_of(text, span.start));
            Fault::Syntax { message }.at(Location {
                file: file.to_owned(),
                line,
            })
        })?;
        let document = Self {
            file,
            text,
            root: root.into_inner(),
            schema,
        };
        document.reject_unknown(&document.root, "")?;
        Ok(document)
    }

    /// Folder of the scene file; paths of other files are relative to it.
    pub fn folder(&self) -> &'t Path {
        Path::new(self.file).parent().unwrap_or(Path::new(""))
    }

    /// Returns the table at a dotted path.
    pub fn table<'d>(&'d self, path: &'d str) -> Table<'d> {
        let mut table = Table {
            document: self,
            path,
            given: Some(&self.root),
            offset: 0,
        };
        for part in path.split('.').filter(|part| !part.is_empty()) {
            let value = table.given.and_then(|table| table.get(part));
            table.offset = value.map_or(table.offset, |value| value.span().start);
            table.given = value.and_then(|value| value.get_ref().as_table());
        }
        table
    }

    /// Whether the file contains a table or key.
    pub fn has(&self, path: &str) -> bool {
        self.at(path).is_some()
    }

    /// Returns the error for an absent key that is required here.
    pub fn missing(&self, path: &str) -> SceneError {
        let (table, name) = split(path);
        self.table(table).missing(name)
    }

    /// Position of the last of the given keys that is present, else the first line of the file.
    pub fn place_of<'p>(&self, paths: impl IntoIterator<Item = &'p str>) -> Location {
        let spans = paths.into_iter().filter_map(|path| self.at(path));
        self.place(spans.map(|value| value.span().start).max().unwrap_or(0))
    }

    /// As [`Table::inconsistent`], with dotted paths.
    pub fn inconsistent(
        &self,
        key: &str,
        others: &[&str],
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> SceneError {
        self.table("").inconsistent(key, others, problem, remedy)
    }

    fn place(&self, offset: usize) -> Location {
        Location {
            file: self.file.to_owned(),
            line: Some(line_of(self.text, offset)),
        }
    }

    /// Returns the value at a dotted path.
    fn at<'d>(&'d self, path: &'d str) -> Option<&'d Spanned<DeValue<'d>>> {
        if cfg!(test) {
            assert!(
                self.schema.find(path).is_some() || self.schema.has_table(path),
                "{path}"
            );
        }
        let (table, name) = split(path);
        self.table(table).given?.get(name)
    }

    /// First line of a value as written, shortened for messages.
    fn excerpt(&self, span: Range<usize>) -> String {
        const LONGEST: usize = 40;
        let written = self.text.get(span).unwrap_or_default();
        let line = written.lines().next().unwrap_or_default();
        match line.char_indices().nth(LONGEST) {
            Some((end, _)) => format!("{}...", &line[..end]),
            None if line.len() < written.len() => format!("{line} ..."),
            None => line.to_owned(),
        }
    }

    /// Rejects the first undeclared key of the text, in reading order.
    fn reject_unknown(&self, table: &DeTable<'_>, path: &str) -> Result<(), SceneError> {
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(name, _)| name.span().start);
        for (name, value) in entries {
            let full = join(path, name.get_ref());
            let is_key = self.schema.find(&full).is_some();
            let is_table = self.schema.has_table(&full);
            match (value.get_ref(), is_key, is_table) {
                (_, false, false) => {
                    return Err(self.unknown(path, name));
                }
                (DeValue::Table(inner), false, true) => self.reject_unknown(inner, &full)?,
                (DeValue::Array(items), true, true) => {
                    for inner in items.iter().filter_map(|item| item.get_ref().as_table()) {
                        self.reject_unknown(inner, &full)?;
                    }
                }
                (_, false, true) => {
                    return Err(Fault::NotATable { key: full }.at(self.place(name.span().start)));
                }
                // A declared key: its kind checks the value when it is read.
                (_, true, _) => {}
            }
        }
        Ok(())
    }

    fn unknown(&self, table: &str, name: &Spanned<DeString<'_>>) -> SceneError {
        // As written and shortened: a name can be as long as the file.
        let name_written = self.excerpt(name.span());
        let siblings = self.schema.names_in(table);
        let named = |wanted: &str| {
            let mut paths = self.schema.paths();
            let found = paths.find(|path| split(path).1 == wanted);
            found.map(str::to_owned)
        };
        let here = |close| {
            let siblings = siblings.iter().copied();
            nearest(&name_written, siblings, close).map(|name| join(table, name))
        };
        let anywhere = || {
            let names = self.schema.0.iter().map(|declared| declared.key.name);
            nearest(&name_written, names, VERY_CLOSE).and_then(named)
        };
        // Suggestions in this order: a very similar key of this table, the same name in another table, a
        // similar key of this table, a very similar key of another table.
        let nearest = here(VERY_CLOSE)
            .or_else(|| named(name.get_ref()))
            .or_else(|| here(CLOSE))
            .or_else(anywhere);
        let place = match table {
            "" => "the top level".to_owned(),
            table => format!("[{table}]"),
        };
        let unknown = Fault::UnknownKey {
            key: join(table, &name_written),
            nearest,
            known: format!("{place} has the keys {}", siblings.join(", ")),
        };
        unknown.at(self.place(name.span().start))
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
        match name.contains('.') {
            true => name.to_owned(),
            false => join(self.path, name),
        }
    }

    /// Position of the table, or of the nearest enclosing table that is present.
    pub fn place(self) -> Location {
        self.document.place(self.offset)
    }

    /// Reads a key, or its default if it is absent.
    pub fn get<K: Kind>(self, key: &Key<K>) -> Result<K::Value, SceneError> {
        match (self.find(key)?, key.if_absent) {
            (Some(value), _) => Ok(value),
            // The default is read like a value of the file; a test checks all defaults.
            (None, IfAbsent::Default(literal)) => {
                let value = DeValue::parse(literal).map_err(|_| Mismatch::Type);
                let value = value.and_then(|value| key.kind.read(value.get_ref()));
                value.map_err(|mismatch| {
                    let fault = mismatch.fault(
                        self.path_of(key.name),
                        key.kind.expected(),
                        literal.to_owned(),
                    );
                    fault.at(self.place())
                })
            }
            (None, _) => Err(self.missing(key.name)),
        }
    }

    /// Reads a key if it is present.
    pub fn find<K: Kind>(self, key: &Key<K>) -> Result<Option<K::Value>, SceneError> {
        let value = self.given.and_then(|table| table.get(key.name));
        value.map(|value| self.read(key, value)).transpose()
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

    /// Returns the error for values that are inconsistent with each other. The position is that of the last
    /// key of the group in the file.
    pub fn inconsistent(
        self,
        name: &str,
        others: &[&str],
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> SceneError {
        let names = others.iter().chain([&name]);
        let paths: Vec<String> = names.map(|name| self.path_of(name)).collect();
        let place = self.document.place_of(paths.iter().map(|path| &path[..]));
        Fault::inconsistent(self.path_of(name), problem, remedy).at(place)
    }

    /// Returns the error for an absent key that is required here.
    fn missing(self, name: &str) -> SceneError {
        let key = self.path_of(name);
        let declared = self
            .document
            .schema
            .find(&key)
            .expect("a key of this table");
        let expected = declared.key.expected_if_missing();
        Fault::Missing { key, expected }.at(self.place())
    }

    /// Elements of a list of tables; empty if the list is absent.
    pub fn list(self, key: &'d Key<Tables>) -> Result<Vec<Table<'d>>, SceneError> {
        self.find(key)?;
        let path = self.path_of(key.name);
        let declared = self
            .document
            .schema
            .find(&path)
            .expect("a key of this table");
        let list = self.given.and_then(|table| table.get(key.name));
        let items = list.and_then(|list| list.get_ref().as_array());
        let element = |item: &'d Spanned<DeValue<'d>>| Table {
            document: self.document,
            path: &declared.path,
            given: item.get_ref().as_table(),
            offset: item.span().start,
        };
        Ok(items.into_iter().flatten().map(element).collect())
    }

    fn read<K: Kind>(
        self,
        key: &Key<K>,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<K::Value, SceneError> {
        let document = self.document;
        key.kind.read(value.get_ref()).map_err(|mismatch| {
            let found = document.excerpt(value.span());
            let path = self.path_of(key.name);
            let mut expected = key.kind.expected();
            let is_number = value.get_ref().is_integer() || value.get_ref().is_float();
            if is_number && let Some(constant) = document.schema.constant_of(&path) {
                expected += &format!("; a constant is `{constant}`");
            }
            let fault = mismatch.fault(path, expected, found);
            fault.at(document.place(value.span().start))
        })
    }
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

/// Line of a byte offset, counted from 1.
pub(super) fn line_of(text: &str, offset: usize) -> usize {
    let before = &text.as_bytes()[..offset.min(text.len())];
    before.iter().filter(|&&byte| byte == b'\n').count() + 1
}
