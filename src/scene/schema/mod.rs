//! Every key of a scene file, once: name, meaning, unit, range, default, and the field that it sets.
//!
//! [`keys!`] declares the keys of a table beside the struct that they fill. Reading, the error
//! messages, the parameters that a study varies and the tables of the guide all come from that
//! declaration. To add a key, add its two lines there; if the struct belongs to another module, its
//! field as well.

pub mod kind;
#[cfg(test)]
mod kind_tests;
pub mod unit;

use kind::Kind;

/// One key of a table.
pub struct Key<K: ?Sized> {
    /// Its name in the table.
    pub name: &'static str,
    /// What it is, in a sentence.
    pub meaning: &'static str,
    /// What holds if it is not given.
    pub otherwise: Otherwise,
    /// What it can be.
    pub kind: K,
}

/// What holds if a key is not given.
#[derive(Clone, Copy, Debug)]
pub enum Otherwise {
    /// The scene is refused.
    Required,
    /// A value, written as it would be in the file.
    Default(&'static str),
    /// Something else, said here in words for the guide.
    Else(&'static str),
}

impl<K: Kind + ?Sized> Key<K> {
    /// What its value must be, and when, where it is missing.
    pub fn expected_if_missing(&self) -> String {
        match self.otherwise {
            Otherwise::Else(words) => format!("{} ({words})", self.kind.expected()),
            Otherwise::Required | Otherwise::Default(_) => self.kind.expected(),
        }
    }

    /// Its row in the guide's table (Markdown).
    pub fn guide_row(&self) -> String {
        let otherwise = match self.otherwise {
            Otherwise::Required => "required".to_owned(),
            Otherwise::Default(literal) => format!("`{literal}`"),
            Otherwise::Else(words) => words.to_owned(),
        };
        let (name, meaning) = (self.name, self.meaning);
        let (unit, allowed) = (self.kind.unit().symbol, self.kind.allowed());
        format!("| `{name}` | {meaning} | {unit} | {allowed} | {otherwise} |\n")
    }
}

/// A key in its place.
pub struct Declared {
    /// The table's dotted path; empty for the top of the file.
    pub table: String,
    /// The key's dotted path.
    pub path: String,
    pub key: &'static Key<dyn Kind>,
}

/// All keys, in the order of the guide.
#[derive(Default)]
pub struct Schema(pub Vec<Declared>);

impl Schema {
    pub fn add(&mut self, table: &str, key: &'static Key<dyn Kind>) {
        let table = table.to_owned();
        let path = join(&table, key.name);
        self.0.push(Declared { table, path, key });
    }

    pub fn paths(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|declared| &declared.path[..])
    }

    pub fn find(&self, path: &str) -> Option<&Declared> {
        self.0.iter().find(|declared| declared.path == path)
    }

    /// The names by which a table holds its keys and the tables in it, each once.
    pub fn names_in(&self, table: &str) -> Vec<&str> {
        let mut names = Vec::new();
        for path in self.paths() {
            let inside = match table {
                "" => Some(path),
                table => path
                    .strip_prefix(table)
                    .and_then(|rest| rest.strip_prefix('.')),
            };
            let name = inside.and_then(|inside| inside.split('.').next());
            names.extend(name.filter(|name| !names.contains(name)));
        }
        names
    }

    /// Whether a path is that of a table: some key lies inside it.
    pub fn has_table(&self, path: &str) -> bool {
        let is_inside = |key: &str| key.strip_prefix(path).is_some_and(|r| r.starts_with('.'));
        self.paths().any(is_inside)
    }
}

/// The table and the name of a dotted path.
pub fn split(path: &str) -> (&str, &str) {
    path.rsplit_once('.').unwrap_or(("", path))
}

/// The dotted path of a name in a table.
pub fn join(table: &str, name: &str) -> String {
    match table {
        "" => name.to_owned(),
        table => format!("{table}.{name}"),
    }
}

/// Declares the keys of a table, and what they make: implements
/// [`FromTable`](super::document::FromTable).
///
/// A key has a line that says its meaning, and one with its field, name, kind and default:
///
/// ```text
/// /// Longest edge of the finite elements.
/// size = "element_size_mm": number(MILLIMETRE, Closed(0.1, 100.0)), default 16.0;
/// ```
///
/// Without a default it is required. `else "words"` in its place makes it an `Option`, and the words say
/// in the guide what holds when it is absent. `..field: Type;` reads a field from keys that `Type`
/// declares, in the same table or in the one after `=>`. `..field: Type { keys }` fills a small struct here.
///
/// With `struct Name` the struct is defined as well, and fields need types. Else `Name` is one of
/// another module, whose fields are the keys'; or `|table|` and `=> expression;` make it of them.
/// `static NAME: Kind` is a key by itself.
macro_rules! keys {
    (@key $meaning:literal, $key:literal: $kind:expr $(, default $default:tt)? $(, else $words:expr)?) => {
        Key {
            name: $key,
            meaning: $meaning.trim_ascii(),
            kind: $kind,
            otherwise: keys!(@otherwise $(default $default)? $(else $words)?),
        }
    };
    (@otherwise) => { Otherwise::Required };
    (@otherwise default $default:tt) => { Otherwise::Default(stringify!($default)) };
    (@otherwise else $words:expr) => { Otherwise::Else($words) };

    (@value $table:ident, $key:expr) => { $table.get($key)? };
    (@value $table:ident, $key:expr, else $words:expr) => { $table.find($key)? };

    (@declare $schema:ident, $table:ident, $part:ident { $(
        #[doc = $meaning:literal] $field:ident = $key:literal: $kind:expr $(, default $default:tt)?;
    )* }) => {
        $($schema.add($table, const { &keys!(@key $meaning, $key: $kind $(, default $default)?) });)*
    };
    (@declare $schema:ident, $table:ident, $part:ty) => { <$part>::declare($schema, $table) };
    (@declare $schema:ident, $table:ident, $part:ty => $path:literal) => { <$part>::declare($schema, $path) };

    (@part $table:ident, $part:ident { $(
        #[doc = $meaning:literal] $field:ident = $key:literal: $kind:expr $(, default $default:tt)?;
    )* }) => {
        $part { $($field: $table.get(const { &keys!(@key $meaning, $key: $kind $(, default $default)?) })?),* }
    };
    (@part $table:ident, $part:ty) => { <$part>::read($table)? };
    (@part $table:ident, $part:ty => $path:literal) => { <$part>::read($table.document.table($path))? };

    (@made [$($fields:tt)*]) => { $($fields)* };
    (@made [$($fields:tt)*] $made:expr) => { $made };

    (
        @table $name:ident |$table:ident| { $(
            #[doc = $meaning:literal]
            $($field:ident = $key:literal: $kind:expr $(, default $default:tt)? $(, else $words:expr)?;)?
            $(..$part:ident: $part_type:ident $(<$inner:ty>)? $(=> $path:literal)? $({ $($part_keys:tt)* })?;)?
        )* }
        $(=> $made:expr)?
    ) => {
        impl FromTable for $name {
            #[allow(unused_variables, reason = "it may have no keys but those of other tables")]
            fn declare(schema: &mut Schema, table: &str) { $(
                $(schema.add(
                    table,
                    const { &keys!(@key $meaning, $key: $kind $(, default $default)? $(, else $words)?) },
                );)?
                $(keys!(@declare schema, table, $part_type $(<$inner>)? $(=> $path)? $({ $($part_keys)* })?);)?
            )* }

            fn read($table: Table<'_>) -> Result<Self, SceneError> {
                $(
                    $(let $field = keys!(
                        @value $table,
                        const { &keys!(@key $meaning, $key: $kind $(, default $default)? $(, else $words)?) }
                        $(, else $words)?
                    );)?
                    $(let $part = keys!(
                        @part $table, $part_type $(<$inner>)? $(=> $path)? $({ $($part_keys)* })?
                    );)?
                )*
                Ok(keys!(@made [$name { $($($field,)? $($part,)?)* }] $($made)?))
            }
        }
    };

    (
        #[doc = $meaning:literal]
        static $name:ident: $type:ty = $key:literal: $kind:expr
            $(, default $default:tt)? $(, else $words:expr)?;
        $($rest:tt)*
    ) => {
        #[doc = $meaning]
        pub static $name: Key<$type> =
            keys!(@key $meaning, $key: $kind $(, default $default)? $(, else $words)?);
        keys! { $($rest)* }
    };
    (
        $(#[$attribute:meta])*
        $visibility:vis struct $name:ident { $(
            #[doc = $meaning:literal]
            $($field:ident: $type:ty = $key:literal: $kind:expr
                $(, default $default:tt)? $(, else $words:expr)?;)?
            $(..$part:ident: $part_type:ident $(<$inner:ty>)? $(=> $path:literal)? $({ $($part_keys:tt)* })?;)?
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
            $(#[doc = $meaning] pub $part: $part_type $(<$inner>)?,)?
        )* }
        keys! { $name { $(
            #[doc = $meaning]
            $($field = $key: $kind $(, default $default)? $(, else $words)?;)?
            $(..$part: $part_type $(<$inner>)? $(=> $path)? $({ $($part_keys)* })?;)?
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
