//! Reading the JSON documents of the commands.

use serde_json::Value;

use super::analyse_files::AnalysedFiles;
use super::calibrate::CalibrationResult;
use super::document::read_as;
use super::growth::GrowthResult;
use super::lyapunov_text::LyapunovResult;
use super::model::Size;
use super::paper::PaperResult;
use super::run::RunResult;
use super::scenes::{Entry, Scenes};
use super::stability::StabilityResult;
use crate::study::basins::Basins;
use crate::study::branch::{Branch, StabilityMap};
use crate::study::cost::CostStudy;
use crate::study::effects::Effects;
use crate::study::friction_fit::FrictionFit;
use crate::study::signal::AnalysedFile;
use crate::study::sweep::SweepResult;

/// Reads the document of a command as its result type, and converts it to JSON again.
///
/// # Errors
/// If the document is not one of the command.
pub fn read_back(command: &str, document: &Value) -> serde_json::Result<Value> {
    let read = match command {
        "run" => read_as::<RunResult<'_>>,
        "stability" => read_as::<StabilityResult>,
        "model" => read_as::<Size>,
        "lyapunov" => read_as::<LyapunovResult<'_>>,
        "sweep" | "merge" => read_as::<SweepResult<'_>>,
        "branch" if document.get("axes").is_some() => read_as::<StabilityMap>,
        "branch" => read_as::<Branch>,
        "basins" => read_as::<Basins>,
        "paper" => read_as::<PaperResult>,
        "calibrate" => read_as::<CalibrationResult<'_>>,
        "cost" => read_as::<CostStudy>,
        "friction" => read_as::<FrictionFit>,
        "growth" => read_as::<GrowthResult<'_>>,
        "analyse" if document.get("analyses").is_some() => read_as::<AnalysedFiles>,
        "analyse" => read_as::<AnalysedFile>,
        _ if document.get("effects").is_some() => read_as::<Effects>,
        _ if document.get("scenes").is_some() => read_as::<Scenes<'_>>,
        _ => read_as::<Entry<'_>>,
    };
    read(document)
}
