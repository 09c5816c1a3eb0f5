//! `squeakscope schema`: the JSON Schema of the `--json` output of each command, derived from the types of the results
//! and their documentation.

use std::borrow::Cow;
use std::marker::PhantomData;

use clap::ValueEnum;
use schemars::generate::SchemaSettings;
use schemars::transform::{RecursiveTransform, Transform as _};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::Value;

use super::analyse_files::AnalysedFiles;
use super::args::SchemaArgs;
use super::console;
use super::error::CliError;
use super::harness::Document;
use super::model::Size;
use super::paper::PaperResult;
use super::run::RunResult;
use super::scenes::{Entry, Scenes};
use crate::study::StabilityResult;
use crate::study::basins::Basins;
use crate::study::branch::{Branch, StabilityMap};
use crate::study::cost::Cost;
use crate::study::friction_fit::FrictionFit;
use crate::study::lyapunov::LyapunovResult;
use crate::study::signal::SignalAnalysis;
use crate::study::sweep::SweepResult;

/// The commands that write JSON.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ResultOf {
    Run,
    Stability,
    Lyapunov,
    Sweep,
    Branch,
    Basins,
    Merge,
    Paper,
    Cost,
    Analyse,
    Friction,
    Scenes,
    Model,
}

/// A document with either result, depending on the arguments of the command.
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
            generator.subschema_for::<Document<A>>(),
            generator.subschema_for::<Document<B>>(),
        ];
        json_schema!({ "anyOf": forms })
    }
}

impl ResultOf {
    /// The schema of the JSON document.
    fn schema(self) -> Schema {
        match self {
            Self::Run => root::<Document<RunResult<'_>>>(),
            Self::Stability => root::<Document<StabilityResult>>(),
            Self::Lyapunov => root::<Document<LyapunovResult>>(),
            Self::Sweep | Self::Merge => root::<Document<SweepResult>>(),
            Self::Branch => root::<Either<Branch, StabilityMap>>(),
            Self::Basins => root::<Document<Basins>>(),
            Self::Paper => root::<Document<PaperResult>>(),
            Self::Cost => root::<Document<Cost>>(),
            Self::Analyse => root::<Either<SignalAnalysis, AnalysedFiles>>(),
            Self::Friction => root::<Document<FrictionFit>>(),
            Self::Scenes => root::<Either<Scenes<'_>, Entry<'_>>>(),
            Self::Model => root::<Document<Size>>(),
        }
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
    let text = match args.command {
        Some(command) => format!("{:#}\n", command.schema().to_value()),
        None => ResultOf::value_variants()
            .iter()
            .filter_map(ValueEnum::to_possible_value)
            .map(|command| format!("{}\n", command.get_name()))
            .collect(),
    };
    Ok(console::print(&text)?)
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
