//! A scene file as parsed: TOML whose every key and value knows the line it stands on.
//!
//! Reading is by [`Key`]: the document finds the value, the key's kind reads it, and whatever is
//! wrong becomes a [`SceneError`] that names file, line and key.

use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::error::{CLOSE, Fault, Place, SceneError, VERY_CLOSE, nearest};
use super::keys::{ALL, Key, Otherwise, split};
use super::kind::{Kind, Mismatch, Tables};

/// A parsed scene file in which every key is known.
pub(super) struct Document<'t> {
    file: &'t str,
    text: &'t str,
    root: DeTable<'t>,
}

/// One table of a list of tables, such as a knot of `[[load.tilt]]`.
pub(super) struct Element<'d> {
    table: &'d DeTable<'d>,
    span: Range<usize>,
}

impl<'t> Document<'t> {
    /// Parses a text and refuses unknown keys. `file` names the source in messages.
    pub fn parse(file: &'t str, text: &'t str) -> Result<Self, SceneError> {
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
        };
        document.refuse_unknown(&document.root, "")?;
        Ok(document)
    }

    /// The folder in which the files that the scene names are.
    pub fn folder(&self) -> &'t Path {
        Path::new(self.file).parent().unwrap_or(Path::new(""))
    }

    /// The value of a key, or its default.
    pub fn get<K: Kind>(&self, key: &Key<K>) -> Result<K::Value, SceneError> {
        match self.find(key)? {
            Some(value) => Ok(value),
            None => default_of(key, self.place_of_table(split(key.path).0)),
        }
    }

    /// The value of a key, if it is given.
    pub fn find<K: Kind>(&self, key: &Key<K>) -> Result<Option<K::Value>, SceneError> {
        self.at(key.path)
            .map(|value| self.read(key, value))
            .transpose()
    }

    /// The error of a key that must be given here and is not.
    pub fn missing<K: Kind>(&self, key: &Key<K>) -> SceneError {
        missing(key, self.place_of_table(split(key.path).0))
    }

    /// Whether a table or key is given.
    pub fn has(&self, path: &str) -> bool {
        self.at(path).is_some()
    }

    /// The tables of a list of tables, if it is given.
    pub fn list(&self, key: &Key<Tables>) -> Result<Option<Vec<Element<'_>>>, SceneError> {
        let Some(value) = self.at(key.path) else {
            return Ok(None);
        };
        self.read(key, value)?;
        let items = value.get_ref().as_array().into_iter().flatten();
        let elements = items.filter_map(|item| {
            item.get_ref().as_table().map(|table| Element {
                table,
                span: item.span(),
            })
        });
        Ok(Some(elements.collect()))
    }

    /// The value of a key in one table of a list, or its default.
    pub fn get_in<K: Kind>(
        &self,
        element: &Element<'_>,
        key: &Key<K>,
    ) -> Result<K::Value, SceneError> {
        match element.table.get(key.name()) {
            Some(value) => self.read(key, value),
            None => default_of(key, self.place_of_element(element)),
        }
    }

    /// Where a table of a list stands.
    pub fn place_of_element(&self, element: &Element<'_>) -> Place {
        self.place(element.span.start)
    }

    /// Where the last given one of some keys stands, or else the top of the file.
    pub fn place_of(&self, paths: &[&str]) -> Place {
        let spans = paths.iter().filter_map(|path| self.at(path));
        self.place(spans.map(|value| value.span().start).max().unwrap_or(0))
    }

    /// The error of a value that does not fit together with those of other keys. The last given
    /// one of them all is taken to be the culprit.
    pub fn inconsistent(
        &self,
        key: &'static str,
        others: &[&str],
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> SceneError {
        let paths: Vec<_> = others.iter().copied().chain([key]).collect();
        let fault = Fault::Inconsistent {
            key,
            problem: problem.into(),
            remedy: remedy.into(),
        };
        fault.at(self.place_of(&paths))
    }

    /// Where a table stands, or the nearest given one that should hold it.
    fn place_of_table(&self, path: &str) -> Place {
        let mut path = path;
        while !path.is_empty() {
            if let Some(table) = self.at(path) {
                return self.place(table.span().start);
            }
            path = split(path).0;
        }
        self.place(0)
    }

    fn place(&self, offset: usize) -> Place {
        Place {
            file: self.file.to_owned(),
            line: Some(line_of(self.text, offset)),
        }
    }

    /// The value at a dotted path.
    fn at(&self, path: &str) -> Option<&Spanned<DeValue<'t>>> {
        let (tables, name) = split(path);
        let mut table = &self.root;
        for part in tables.split('.').filter(|part| !part.is_empty()) {
            table = table.get(part)?.get_ref().as_table()?;
        }
        table.get(name)
    }

    fn read<K: Kind>(
        &self,
        key: &Key<K>,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<K::Value, SceneError> {
        key.kind.read(value.get_ref()).map_err(|mismatch| {
            let at = self.place(value.span().start);
            let found = self.excerpt(value.span());
            mismatched(key, mismatch, at, found)
        })
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
            let is_key = ALL.iter().any(|key| key.path() == full);
            let is_table = ALL.iter().any(|key| is_inside(key.path(), &full));
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
        let mut siblings: Vec<&str> = Vec::new();
        for sibling in ALL.iter().filter_map(|key| child(key.path(), table)) {
            if !siblings.contains(&sibling) {
                siblings.push(sibling);
            }
        }
        let named = |wanted: &str| {
            let mut paths = ALL.iter().map(|key| key.path());
            paths
                .find(|path| split(path).1 == wanted)
                .map(str::to_owned)
        };
        let here = |close| {
            let siblings = siblings.iter().copied();
            nearest(&name_written, siblings, close).map(|name| join(table, name))
        };
        let anywhere = || {
            let names = ALL.iter().map(|key| split(key.path()).1);
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

/// The default of a key that is not given.
fn default_of<K: Kind>(key: &Key<K>, at: Place) -> Result<K::Value, SceneError> {
    let Otherwise::Default(literal) = key.otherwise else {
        return Err(missing(key, at));
    };
    // The same road as a value of the file; a test shows that no default fails on it.
    let mismatch = match DeValue::parse(literal) {
        Ok(value) => match key.kind.read(value.get_ref()) {
            Ok(value) => return Ok(value),
            Err(mismatch) => mismatch,
        },
        Err(_) => Mismatch::Type,
    };
    Err(mismatched(key, mismatch, at, literal.to_owned()))
}

fn missing<K: Kind>(key: &Key<K>, at: Place) -> SceneError {
    let expected = match key.otherwise {
        Otherwise::Else(words) => format!("{} ({words})", key.kind.expected()),
        Otherwise::Required | Otherwise::Default(_) => key.kind.expected(),
    };
    let key = key.path;
    Fault::Missing { key, expected }.at(at)
}

/// What to say of a value that its key does not take.
pub(super) fn mismatched<K: Kind>(
    key: &Key<K>,
    mismatch: Mismatch,
    at: Place,
    found: String,
) -> SceneError {
    let expected = key.kind.expected();
    let key = key.path;
    let fault = match mismatch {
        Mismatch::Type => Fault::WrongType {
            key,
            found,
            expected,
        },
        Mismatch::Range => Fault::OutOfRange {
            key,
            found,
            expected,
        },
        Mismatch::Choice(nearest) => Fault::UnknownChoice {
            key,
            found,
            nearest: nearest.map(str::to_owned),
            expected,
        },
    };
    fault.at(at)
}

/// The line, counted from 1, of a byte of a text.
pub(super) fn line_of(text: &str, offset: usize) -> usize {
    let before = &text.as_bytes()[..offset.min(text.len())];
    before.iter().filter(|&&byte| byte == b'\n').count() + 1
}

/// The dotted path of a name in a table.
fn join(table: &str, name: &str) -> String {
    if table.is_empty() {
        name.to_owned()
    } else {
        format!("{table}.{name}")
    }
}

/// Whether a path lies inside a table.
fn is_inside(path: &str, table: &str) -> bool {
    path.strip_prefix(table)
        .is_some_and(|rest| rest.starts_with('.'))
}

/// The name by which a table holds a path, directly or as the next table on the way to it.
fn child<'p>(path: &'p str, table: &str) -> Option<&'p str> {
    let rest = match table {
        "" => path,
        table => path.strip_prefix(table)?.strip_prefix('.')?,
    };
    rest.split('.').next()
}
