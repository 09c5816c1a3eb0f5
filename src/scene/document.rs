//! A scene file as parsed: TOML whose every key and value knows the line it stands on.
//!
//! Reading is by [`Key`]: a [`Table`] finds the value, the key's kind reads it, and whatever is
//! wrong becomes a [`SceneError`] that names file, line and key.

use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::error::{CLOSE, Fault, Place, SceneError, VERY_CLOSE, nearest};
use super::schema::kind::{Kind, Mismatch, Tables};
use super::schema::{Key, Otherwise, Schema, join, split};

/// A parsed scene file in which every key is known.
pub(super) struct Document<'t> {
    file: &'t str,
    text: &'t str,
    root: DeTable<'t>,
    /// The keys that it can have.
    pub schema: &'static Schema,
}

/// A table of a scene file, given or not; or one of a list of tables, such as a knot of `[[load.tilt]]`.
#[derive(Clone, Copy)]
pub(super) struct Table<'d> {
    pub document: &'d Document<'d>,
    /// Dotted path.
    path: &'d str,
    given: Option<&'d DeTable<'d>>,
    /// Where it begins, or else the nearest given one that should hold it.
    offset: usize,
}

impl<'t> Document<'t> {
    /// Parses a text and refuses keys that the schema has not. `file` names the source in messages.
    pub fn parse(
        file: &'t str,
        text: &'t str,
        schema: &'static Schema,
    ) -> Result<Self, SceneError> {
        let root = DeTable::parse(text).map_err(|error| {
            let message = error.message().replace('\n', " ");
            let line = error.span().map(|span| line_of(text, span.start));
            Fault::Syntax { message }.at(Place {
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
        document.refuse_unknown(&document.root, "")?;
        Ok(document)
    }

    /// The folder in which the files that the scene names are.
    pub fn folder(&self) -> &'t Path {
        Path::new(self.file).parent().unwrap_or(Path::new(""))
    }

    /// The table at a dotted path.
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

    /// Whether a table or key is given.
    pub fn has(&self, path: &str) -> bool {
        self.at(path).is_some()
    }

    /// The error of a key that must be given here and is not.
    pub fn missing(&self, path: &str) -> SceneError {
        let (table, name) = split(path);
        self.table(table).missing(name)
    }

    /// Where the last given one of some keys stands, or else the top of the file.
    pub fn place_of<'p>(&self, paths: impl IntoIterator<Item = &'p str>) -> Place {
        let spans = paths.into_iter().filter_map(|path| self.at(path));
        self.place(spans.map(|value| value.span().start).max().unwrap_or(0))
    }

    /// As [`Table::inconsistent`], of keys by their paths.
    pub fn inconsistent(
        &self,
        key: &str,
        others: &[&str],
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> SceneError {
        self.table("").inconsistent(key, others, problem, remedy)
    }

    fn place(&self, offset: usize) -> Place {
        Place {
            file: self.file.to_owned(),
            line: Some(line_of(self.text, offset)),
        }
    }

    /// The value at a dotted path.
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

    /// The text of a value as written: its first line, shortened.
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

    /// Refuses the first key of the text, in reading order, that no scene has.
    fn refuse_unknown(&self, table: &DeTable<'_>, path: &str) -> Result<(), SceneError> {
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
                (DeValue::Table(inner), false, true) => self.refuse_unknown(inner, &full)?,
                (DeValue::Array(items), true, true) => {
                    for inner in items.iter().filter_map(|item| item.get_ref().as_table()) {
                        self.refuse_unknown(inner, &full)?;
                    }
                }
                (_, false, true) => {
                    return Err(Fault::NotATable { key: full }.at(self.place(name.span().start)));
                }
                // A key: its kind says whether the value fits, once it is read.
                (_, true, _) => {}
            }
        }
        Ok(())
    }

    fn unknown(&self, table: &str, name: &Spanned<DeString<'_>>) -> SceneError {
        // As written and shortened, since a name can be as long as the file.
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
        // A likely misspelling of a key of this table, else the right name in the wrong table, else what
        // may be a misspelling of a key of this table, else a likely one of a key of another.
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
            known: format!("{place} knows {}", siblings.join(", ")),
        };
        unknown.at(self.place(name.span().start))
    }
}

impl<'d> Table<'d> {
    /// Whether the file has it.
    pub fn is_given(self) -> bool {
        self.given.is_some()
    }

    /// Whether it has a key.
    pub fn has(self, name: &str) -> bool {
        self.given.is_some_and(|table| table.contains_key(name))
    }

    /// The dotted path of one of its keys; of a key of another table it is the name already.
    pub fn path_of(self, name: &str) -> String {
        match name.contains('.') {
            true => name.to_owned(),
            false => join(self.path, name),
        }
    }

    /// Where it stands, or the nearest given one that should hold it.
    pub fn place(self) -> Place {
        self.document.place(self.offset)
    }

    /// The value of a key, or its default.
    pub fn get<K: Kind>(self, key: &Key<K>) -> Result<K::Value, SceneError> {
        match (self.find(key)?, key.otherwise) {
            (Some(value), _) => Ok(value),
            // The same way as a value of the file; a test shows that no default fails on it.
            (None, Otherwise::Default(literal)) => {
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

    /// The value of a key, if it is given.
    pub fn find<K: Kind>(self, key: &Key<K>) -> Result<Option<K::Value>, SceneError> {
        let value = self.given.and_then(|table| table.get(key.name));
        value.map(|value| self.read(key, value)).transpose()
    }

    /// A value that the other keys of the table make necessary.
    pub fn needed<T>(self, name: &str, value: Option<T>) -> Result<T, SceneError> {
        value.ok_or_else(|| self.missing(name))
    }

    /// Refuses keys that do not go with others.
    pub fn refuse(
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

    /// The error of a value that does not fit together with those of other keys. The last given
    /// one of them all is taken to be the culprit.
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

    /// The error of a key that must be given here and is not.
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

    /// The tables of a list of tables; none if it is not given.
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
            let fault = mismatch.fault(self.path_of(key.name), key.kind.expected(), found);
            fault.at(document.place(value.span().start))
        })
    }
}

/// What the keys of a table say.
pub(super) trait FromTable: Sized {
    /// Adds its keys to those of all tables.
    fn declare(schema: &mut Schema, table: &str);

    /// Reads its keys; what is not given has its default.
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

/// The line, counted from 1, of a byte of a text.
pub(super) fn line_of(text: &str, offset: usize) -> usize {
    let before = &text.as_bytes()[..offset.min(text.len())];
    before.iter().filter(|&&byte| byte == b'\n').count() + 1
}
