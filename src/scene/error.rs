//! Errors and warnings of scenes. Each message states the fault, its position and the remedy.

use std::fmt;
use std::io;

use thiserror::Error;

use crate::joint::ImportedModesError;

/// Location of a fault in its source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// The file as the user named it, or the name of a built-in scene.
    pub file: String,
    /// Line, counted from 1; `None` if the value does not come from the text.
    pub line: Option<usize>,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}", self.file),
            None => f.write_str(&self.file),
        }
    }
}

/// A scene that cannot be run. The message contains position, key, permitted values and, for a likely
/// misspelling, the most similar known name.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The name is neither a built-in scene nor a file.
    #[error(
        "no scene is called `{name}`{}; choose one of {known}, or give the path of a scene file",
        did_you_mean(nearest.as_deref())
    )]
    UnknownScene {
        /// The requested name.
        name: String,
        /// The most similar built-in scene, if any is similar enough.
        nearest: Option<String>,
        /// Names of all built-in scenes.
        known: String,
    },
    /// The file cannot be read.
    #[error(
        "cannot read the scene file `{file}`; give a readable TOML file or the name of a built-in scene"
    )]
    Unreadable {
        /// The requested path.
        file: String,
        /// Cause.
        source: io::Error,
    },
    /// The file exceeds the size limit for scenes.
    #[error(
        "the scene file `{file}` is larger than {limit} bytes; a scene is a few kilobytes of TOML"
    )]
    TooLarge {
        /// The requested path.
        file: String,
        /// Size limit, bytes.
        limit: u64,
    },
    /// The operation requires another system than that of the scene.
    #[error("{required} required, but the scene `{scene}` {defines}; choose a scene {remedy}")]
    WrongSystem {
        /// Name of the scene.
        scene: String,
        /// What is required, with the verb.
        required: &'static str,
        /// What the scene has, with the verb.
        defines: String,
        /// What a suitable scene has.
        remedy: String,
    },
    /// The file of the modes is invalid.
    #[error("{at}: `body.modes`: {file}: {problem}")]
    Modes {
        /// Position of `body.modes` in the scene.
        at: Location,
        /// The file of the modes.
        file: String,
        /// Fault and remedy.
        problem: Box<ImportedModesError>,
    },
    /// The content is invalid.
    #[error("{at}: {fault}")]
    Content {
        /// Position of the faulty value or key, or of the table that lacks a key.
        at: Location,
        /// The fault.
        fault: Fault,
    },
}

impl SceneError {
    /// The same fault at another position.
    pub(super) fn moved_to(self, at: Location) -> Self {
        match self {
            Self::Content { fault, .. } => fault.at(at),
            other => other,
        }
    }
}

/// A fault in the content of a scene.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{problem}; {remedy}")]
pub struct Fault {
    /// The faulty key or value, and why it is rejected.
    pub problem: String,
    /// Remedy.
    pub remedy: String,
}

impl Fault {
    pub(super) fn new(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self {
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    /// Values that are valid individually but inconsistent with each other.
    pub(super) fn inconsistent(
        key: impl fmt::Display,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::new(format!("`{key}`: {}", problem.into()), remedy)
    }

    /// A text that is not valid TOML.
    pub(super) fn syntax(error: &toml_edit::TomlError) -> Self {
        let message = error.message().replace('\n', " ");
        let remedy = "`squeakscope scenes NAME` prints a valid scene to start from";
        Self::new(format!("not valid TOML: {message}"), remedy)
    }

    /// Builds the error for this fault at a position.
    pub(super) fn at(self, at: Location) -> SceneError {
        SceneError::Content { at, fault: self }
    }
}

/// Returns an error for inconsistent values unless the condition holds. The arguments after the condition
/// are the key, the other keys involved, the problem and the remedy.
macro_rules! ensure {
    (
        $document:expr, $holds:expr => $key:expr, $others:expr;
        $problem:literal $(, $value:expr)*;
        $remedy:literal $(, $limit:expr)*
    ) => {{
        let holds: bool = $holds;
        if !holds {
            let (problem, remedy) = (format!($problem $(, $value)*), format!($remedy $(, $limit)*));
            return Err($document.inconsistent($key, $others, problem, remedy));
        }
    }};
}

pub(super) use ensure;

/// Part of a message that suggests a similar name.
pub(super) fn did_you_mean(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |name| format!(" (did you mean `{name}`?)"))
}

/// Minimum similarity (0 to 1) of a suggestion; a less similar name does not help the user.
pub(super) const CLOSE: f64 = 0.5;
/// Similarity (0 to 1) from which a name is almost certainly a misspelling.
pub(super) const VERY_CLOSE: f64 = 0.75;

/// Returns the candidate most similar to `word` if its similarity is at least `close` (0 to 1).
pub(super) fn nearest<'c>(
    word: &str,
    candidates: impl IntoIterator<Item = &'c str>,
    close: f64,
) -> Option<&'c str> {
    candidates
        .into_iter()
        .map(|candidate| {
            let likeness = strsim::normalized_damerau_levenshtein(word, candidate);
            (likeness, candidate)
        })
        .filter(|(likeness, _)| *likeness >= close)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

/// A warning about a valid scene: a property that is probably unintended.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SceneWarning {
    /// The kinetic coefficient of friction exceeds the static one. Friction then increases with speed, and no
    /// negative slope excites vibration.
    #[error(
        "friction.mu_d = {mu_d} exceeds friction.mu_s = {mu_s}: friction increases with speed, and no negative \
         slope excites vibration"
    )]
    KineticAboveStatic {
        /// Static coefficient of friction.
        mu_s: f64,
        /// Kinetic coefficient of friction.
        mu_d: f64,
    },
    /// The contact patch is so wide that Hertz contact describes it badly.
    #[error(
        "the contact patch has a half-angle of {:.0} degrees, and Hertz contact holds for small ones: the normal \
         force along the load is {:.1} % too small; give the pressure over the radius as contact.pressure",
        .half_angle.to_degrees(),
        .lost_load * 100.0
    )]
    WidePatch {
        /// Half-angle, rad.
        half_angle: f64,
        /// Share of the load that the normal forces do not carry.
        lost_load: f64,
    },
    /// The published natural frequencies are those of another body: dimensions or material differ.
    #[error(
        "the published natural frequencies are those of the body of the paper, and body has other dimensions or \
         another material; set body.frequencies = \"scaled\" or \"fe\""
    )]
    FrequenciesOfAnotherBody,
    /// The run ends before the schedule of tilt, load or rotation ends.
    ///
    /// This includes a step at the end of the run: no sample follows it.
    #[error(
        "the run ends at {} ms, {} the last change of the {of} at {} ms; increase time.duration_ms",
        .duration * 1e3,
        if .last > .duration { "before" } else { "without a sample after" },
        .last * 1e3
    )]
    ScheduleCutShort {
        /// The quantity.
        of: &'static str,
        /// Simulated time, s.
        duration: f64,
        /// Time of the last knot or step of the schedule, s.
        last: f64,
    },
    /// Two knots of tilt, load or rotation lie within one frame, in which the joint is constant.
    #[error(
        "the {of} has a knot at {} ms that follows the previous knot by less than a frame; the {of} is updated once \
         per frame, every {} ms, and knots within a frame have no effect; reduce time.frame_samples, or use steps",
        .time * 1e3,
        .frame * 1e3
    )]
    PointsWithinFrame {
        /// The quantity.
        of: &'static str,
        /// Time of the later knot, s.
        time: f64,
        /// Length of a frame, s.
        frame: f64,
    },
    /// The run ends before an analysis starts.
    #[error(
        "the run ends at {} ms, before {key} = {}, so this analysis has no result; increase time.duration_ms",
        .duration * 1e3,
        .start * 1e3
    )]
    AnalysisNeverStarts {
        /// Path of the key that sets the start.
        key: &'static str,
        /// Start of the analysis, s.
        start: f64,
        /// Simulated time, s.
        duration: f64,
    },
}
