//! The tables of a scene file: keys, values and consistency checks.

pub mod analysis;
mod axis;
pub mod csv;
pub mod friction;
pub mod joint;
pub mod knots;
pub mod load;
pub mod run;
pub mod small;

use std::sync::LazyLock;

use super::controls;
use super::document::FromTable;
use super::schema::{Declared, Schema};

pub use axis::{check_imported_patch, check_sliding};
pub use run::{Events, Frames, Header, Integrator, RecordSpec, Start};

/// All keys of all tables, in the order of the guide.
pub static SCHEMA: LazyLock<Schema> = LazyLock::new(|| {
    let mut schema = Schema::default();
    Header::declare(&mut schema, "");
    controls::declare(&mut schema);
    joint::declare(&mut schema);
    small::declare(&mut schema);
    Start::declare(&mut schema, "start");
    Frames::declare(&mut schema, "time");
    schema.add("time", &load::CARRY);
    Integrator::declare(&mut schema, "time");
    analysis::AnalysisSpec::declare(&mut schema, "analysis");
    RecordSpec::declare(&mut schema, "record");
    schema
});

/// All keys with meaning, unit, permitted values and default, as Markdown: one table for each table of a
/// scene file.
pub fn key_reference() -> String {
    let mut reference = String::new();
    let mut tables: Vec<&str> = Vec::new();
    for Declared { table, .. } in &SCHEMA.0 {
        if tables.contains(&&**table) {
            continue;
        }
        tables.push(table);
        let heading = match &table[..] {
            "" => "Top level".to_owned(),
            // A path that is both a table and a key is a list of tables.
            list if SCHEMA.find(list).is_some() => format!("`[[{list}]]`"),
            table => format!("`[{table}]`"),
        };
        reference.push_str(&format!(
            "\n## {heading}\n\n| key | meaning | unit | value | default |\n|---|---|---|---|---|\n"
        ));
        let keys = SCHEMA.0.iter().filter(|key| key.table == *table);
        reference.extend(keys.map(Declared::guide_row));
    }
    reference
}
