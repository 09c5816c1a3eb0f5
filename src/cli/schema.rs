//! `squeakscope schema`: the JSON Schema of the `--json` output of each command, derived from the types of the results
//! and their documentation.

use std::borrow::Cow;
use std::marker::PhantomData;

use clap::builder::PossibleValuesParser;
use schemars::generate::SchemaSettings;
use schemars::transform::{RecursiveTransform, Transform as _};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::Value;

use super::args::SchemaArgs;
use super::console;
use super::error::CliError;
use super::harness::Document;
use super::model::Size;
use super::scenes::{Entry, Scenes};
use crate::pipeline::RunResult;
use crate::scene::SceneComparison;
use crate::study::StabilityResult;
use crate::study::basins::Basins;
use crate::study::branch::{Branch, StabilityMap};
use crate::study::cost::Cost;
use crate::study::friction_fit::FrictionFit;
use crate::study::lyapunov::LyapunovResult;
use crate::study::signal::{AnalysedFiles, SignalAnalysis};
use crate::study::sweep::SweepResult;
use crate::text::paper::PaperResult;

/// Makes the schema of a document.
type Derive = fn() -> Schema;

/// The commands that write JSON, with the schema of the document.
const RESULTS: [(&str, Derive); 13] = [
    ("run", root::<Document<RunResult<'_>>>),
    ("stability", root::<Document<StabilityResult>>),
    ("lyapunov", root::<Document<LyapunovResult>>),
    ("sweep", root::<Document<SweepResult>>),
    (
        "branch",
        root::<Either<Document<Branch>, Document<StabilityMap>>>,
    ),
    ("basins", root::<Document<Basins>>),
    ("merge", root::<Document<SweepResult>>),
    ("paper", root::<Document<PaperResult>>),
    ("cost", root::<Document<Cost>>),
    (
        "analyse",
        root::<Either<Document<SignalAnalysis>, Document<AnalysedFiles>>>,
    ),
    ("friction", root::<Document<FrictionFit>>),
    (
        "scenes",
        root::<Either<Document<Scenes<'_>>, Either<Document<Entry<'_>>, Document<SceneComparison>>>>,
    ),
    ("model", root::<Document<Size>>),
];

/// Parses the name of a command that writes JSON.
pub fn results() -> PossibleValuesParser {
    RESULTS.map(|(name, _)| name).into()
}

/// Either document, depending on the arguments of the command.
struct Either<A, B>(PhantomData<(A, B)>);

impl<A: JsonSchema, B: JsonSchema> JsonSchema for Either<A, B> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        format!("{}_or_{}", A::schema_name(), B::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let forms = [
            generator.subschema_for::<A>(),
            generator.subschema_for::<B>(),
        ];
        json_schema!({ "anyOf": forms })
    }
}

/// The schema of a type as it is serialised.
fn root<T: JsonSchema>() -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let mut schema = settings.into_generator().into_root_schema_for::<T>();
    RecursiveTransform(|schema: &mut Schema| {
        if let Some(Value::String(text)) = schema.get_mut("description") {
            *text = without_links(text);
        }
    })
    .transform(&mut schema);
    schema
}

/// The text of a doc comment for readers of JSON: without links into the library, and with `null` for `None`.
fn without_links(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some((before, link)) = rest.split_once("[`") {
        let Some((name, after)) = link.split_once("`]") else {
            break;
        };
        plain += &format!("{before}`{name}`");
        let target = after.strip_prefix('(').and_then(|t| t.split_once(')'));
        rest = target.map_or(after, |(_, after)| after);
    }
    (plain + rest).replace("`None`", "`null`")
}

/// Prints the schema of a command, or the commands that have one.
///
/// # Errors
/// If the standard output cannot be written.
pub(super) fn schema(args: &SchemaArgs) -> Result<(), CliError> {
    let mut results = RESULTS.into_iter();
    let wanted = results.find(|(name, _)| args.command.as_deref() == Some(*name));
    console::print(&match wanted {
        Some((_, schema)) => format!("{:#}\n", schema().to_value()),
        None => RESULTS.map(|(name, _)| format!("{name}\n")).concat(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_become_their_names() {
        let text = "See [`Lines`](super::Lines) and [`A::b`]; `None` [m] if (a) [`x`] .";
        let plain = "See `Lines` and `A::b`; `null` [m] if (a) `x` .";
        assert_eq!(without_links(text), plain);
    }
}
