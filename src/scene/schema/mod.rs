//! The declaration of every scene key: name, meaning, unit, range, default, and the field that it sets.
//!
//! [`keys!`] declares the keys of a table next to the struct that they fill. Parsing, error messages,
//! the parameters of studies and the key reference of the guide derive from this declaration. To add a
//! key, add its two lines to the declaration and, if another module defines the struct, its field.

pub mod kind;
#[cfg(test)]
mod kind_tests;
pub mod unit;

use kind::{Kind, Limits};

/// A key of a table, read as `T`.
pub struct Key<T> {
    /// Name in its table.
    pub name: &'static str,
    /// Meaning, in one sentence.
    pub meaning: &'static str,
    /// Behaviour if the key is absent.
    pub if_absent: IfAbsent,
    /// The laws that use the key, where the table selects one; empty for all.
    pub laws: &'static [&'static str],
    /// Type and range of the value.
    pub kind: Kind<T>,
}

/// Behaviour if a key is absent.
#[derive(Clone, Copy, Debug)]
pub enum IfAbsent {
    /// The scene is rejected.
    Required,
    /// A default value, as written in a scene file.
    Default(&'static str),
    /// Another behaviour, described in words for the guide.
    Described(&'static str),
}

/// A declared key with its position in the schema; the fields are those of [`Key`].
pub struct Declared {
    /// Dotted path of the table; empty for the top level.
    pub table: String,
    /// Dotted path of the key.
    pub path: String,
    pub name: &'static str,
    pub meaning: &'static str,
    pub if_absent: IfAbsent,
    pub laws: &'static [&'static str],
    pub limits: Limits,
}

impl Declared {
    /// Description of the permitted values, and of when the key is required.
    pub fn expected_if_missing(&self) -> String {
        match (self.if_absent, self.laws) {
            (IfAbsent::Default(_), _) | (IfAbsent::Required, []) => self.limits.expected(),
            _ => format!("{} ({})", self.limits.expected(), self.if_absent()),
        }
    }

    /// What applies if the key is absent (Markdown).
    fn if_absent(&self) -> String {
        match (self.if_absent, self.laws) {
            (IfAbsent::Required, []) => "required".to_owned(),
            (IfAbsent::Required, laws) => format!("required with `{}`", laws.join("` and `")),
            (IfAbsent::Default(literal), _) => format!("`{literal}`"),
            (IfAbsent::Described(words), _) => words.to_owned(),
        }
    }

    /// Row of the key in the guide's table (Markdown).
    pub fn guide_row(&self) -> String {
        let if_absent = self.if_absent();
        let (name, meaning) = (self.name, self.meaning);
        let (unit, allowed) = (self.limits.unit.symbol, self.limits.allowed());
        format!("| `{name}` | {meaning} | {unit} | {allowed} | {if_absent} |\n")
    }
}

/// All keys, in the order of the guide.
#[derive(Default)]
pub struct Schema(pub Vec<Declared>);

impl Schema {
    pub fn add<T>(&mut self, table: &str, key: &Key<T>) {
        self.0.push(Declared {
            table: table.to_owned(),
            path: join(table, key.name),
            name: key.name,
            meaning: key.meaning,
            if_absent: key.if_absent,
            laws: key.laws,
            limits: key.kind.limits,
        });
    }

    pub fn paths(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|declared| &declared.path[..])
    }

    pub fn find(&self, path: &str) -> Option<&Declared> {
        self.0.iter().find(|declared| declared.path == path)
    }

    /// Names of the keys and subtables of a table, without duplicates.
    pub fn names_in(&self, table: &str) -> Vec<&str> {
        let prefix = join(table, "");
        let inside = self.paths().filter_map(|path| path.strip_prefix(&prefix));
        let mut names = Vec::new();
        for name in inside.filter_map(|inside| inside.split('.').next()) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// Whether a path is that of a table.
    pub fn has_table(&self, path: &str) -> bool {
        let end = path.len();
        let is_inside = |key: &str| key.as_bytes().get(end) == Some(&b'.') && key.starts_with(path);
        self.paths().any(is_inside)
    }
}

/// Splits a dotted path into table and name.
pub fn split(path: &str) -> (&str, &str) {
    path.rsplit_once('.').unwrap_or(("", path))
}

/// Joins a table and a name to a dotted path.
pub fn join(table: &str, name: &str) -> String {
    match table {
        "" => name.to_owned(),
        table => format!("{table}.{name}"),
    }
}

/// Declares the keys of a table and implements [`FromTable`](super::document::FromTable).
///
/// The declaration of a key consists of a line with its meaning and a line with field, name, type and
/// default:
///
/// ```text
/// /// Maximum edge length of the finite elements.
/// size = "element_size_mm": number(MILLIMETRE, Closed(0.1, 100.0)), default 16.0;
/// ```
///
/// A key without a default is required. With `else "words"` it becomes an `Option`; the words describe in
/// the guide what applies if it is absent. `with ["law"]` names the laws that use the key; without a default it is an
/// `Option` that these laws require. `..field: Type;` reads a field from the keys that `Type`
/// declares, in the same table or in the table after `=>`.
///
/// `struct Name` also defines the struct; its fields then need types. Otherwise `Name` is a struct of
/// another module with these fields, or `|table|` and `=> expression;` construct it. `static NAME: T`
/// declares a single key that is read as `T`.
macro_rules! keys {
    (@key $meaning:literal, $key:literal: $kind:expr $(, $clause:ident $value:tt)*) => {
        Key {
            name: $key,
            meaning: $meaning.trim_ascii(),
            kind: $kind,
            if_absent: keys!(@if_absent $($clause $value)*),
            laws: keys!(@laws $($clause $value)*),
        }
    };
    (@if_absent default $default:tt $(with $laws:tt)?) => { IfAbsent::Default(stringify!($default)) };
    (@if_absent else $words:tt $(with $laws:tt)?) => { IfAbsent::Described($words) };
    (@if_absent $(with $laws:tt)?) => { IfAbsent::Required };
    (@laws) => { &[] };
    (@laws with $laws:tt) => { &$laws };
    (@laws $clause:ident $value:tt $($rest:tt)*) => { keys!(@laws $($rest)*) };

    (@value $table:ident, $key:expr) => { $table.get($key)? };
    (@value $table:ident, $key:expr, default $default:tt $(, with $laws:tt)?) => { $table.get($key)? };
    (@value $table:ident, $key:expr, $($optional:tt)+) => { $table.find($key)? };

    (@declare $schema:ident, $table:ident, $part:ty) => { <$part>::declare($schema, $table) };
    (@declare $schema:ident, $table:ident, $part:ty => $path:literal) => { <$part>::declare($schema, $path) };

    (@part $table:ident, $part:ty) => { <$part>::read($table)? };
    (@part $table:ident, $part:ty => $path:literal) => { <$part>::read($table.document.table($path))? };

    (@made [$($fields:tt)*]) => { $($fields)* };
    (@made [$($fields:tt)*] $made:expr) => { $made };

    (
        @table $name:ident |$table:ident| { $(
            #[doc = $meaning:literal]
            $($field:ident = $key:literal: $kind:expr $(, $clause:ident $value:tt)*;)?
            $(..$part:ident: $part_type:ty $(=> $path:literal)?;)?
        )* }
        $(=> $made:expr)?
    ) => {
        impl FromTable for $name {
            #[allow(unused_variables, reason = "it may have no keys but those of other tables")]
            fn declare(schema: &mut Schema, table: &str) { $(
                $(schema.add(table, &keys!(@key $meaning, $key: $kind $(, $clause $value)*));)?
                $(keys!(@declare schema, table, $part_type $(=> $path)?);)?
            )* }

            fn read($table: Table<'_>) -> Result<Self, SceneError> {
                $(
                    $(let $field = keys!(
                        @value $table, &keys!(@key $meaning, $key: $kind $(, $clause $value)*) $(, $clause $value)*
                    );)?
                    $(let $part = keys!(@part $table, $part_type $(=> $path)?);)?
                )*
                Ok(keys!(@made [$name { $($($field,)? $($part,)?)* }] $($made)?))
            }
        }
    };

    (
        #[doc = $meaning:literal]
        static $name:ident: $type:ty = $key:literal: $kind:expr $(, $clause:ident $value:tt)*;
        $($rest:tt)*
    ) => {
        #[doc = $meaning]
        pub static $name: Key<$type> = keys!(@key $meaning, $key: $kind $(, $clause $value)*);
        keys! { $($rest)* }
    };
    (
        $(#[$attribute:meta])*
        $visibility:vis struct $name:ident { $(
            #[doc = $meaning:literal]
            $($field:ident: $type:ty = $key:literal: $kind:expr $(, $clause:ident $value:tt)*;)?
            $(..$part:ident: $part_type:ty $(=> $path:literal)?;)?
        )* }
        $($rest:tt)*
    ) => {
        $(#[$attribute])*
        $visibility struct $name { $(
            $(
                #[doc = $meaning]
                #[doc = concat!("\n\nKey `", $key, "` of a scene file; here in SI units.")]
                pub $field: $type,
            )?
            $(#[doc = $meaning] pub $part: $part_type,)?
        )* }
        keys! { $name { $(
            #[doc = $meaning]
            $($field = $key: $kind $(, $clause $value)*;)?
            $(..$part: $part_type $(=> $path)?;)?
        )* } $($rest)* }
    };
    ($name:ident { $($keys:tt)* } $($rest:tt)*) => {
        keys! { @table $name |table| { $($keys)* } }
        keys! { $($rest)* }
    };
    ($name:ident |$table:ident| { $($keys:tt)* } => $made:expr; $($rest:tt)*) => {
        keys! { @table $name |$table| { $($keys)* } => $made }
        keys! { $($rest)* }
    };
    () => {};
}

pub(in crate::scene) use keys;
