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
        did_you_mean(nearest)
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
    /// The operation requires a ball joint, and the scene defines another system.
    #[error(
        "a ball joint is required, but the scene `{scene}` defines {subject}; choose a scene with a [load] \
         table, such as `{}`",
        super::DEFAULT_SCENE
    )]
    NoJoint {
        /// Name of the scene.
        scene: String,
        /// The system that the scene defines.
        subject: &'static str,
    },
    /// The operation requires the finite-element model of ball and beam, and the scene imports its modes.
    #[error(
        "modes and contact patch of ball and beam are required, but the scene `{scene}` imports them \
         from `{file}`; choose a scene without body.modes, such as `{}`",
        super::DEFAULT_SCENE
    )]
    NoBeam {
        /// Name of the scene.
        scene: String,
        /// File of the modes.
        file: String,
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
    /// The operation requires a small system, and the scene defines a ball joint.
    #[error(
        "a small system is required, but the scene `{scene}` defines a ball joint; choose a scene with \
         a table such as [impact_oscillator]"
    )]
    NoSmallSystem {
        /// Name of the scene.
        scene: String,
    },
    /// The content is invalid.
    #[error("{at}: {fault}")]
    Content {
        /// Position of the faulty value or key, or of the table that lacks a key.
        at: Location,
        /// The fault.
        fault: Box<Fault>,
    },
}

/// A fault in the content of a scene.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// The file is not UTF-8 text.
    #[error("the scene file is not UTF-8 text; save it as UTF-8")]
    NotText,
    /// The text is not valid TOML.
    #[error(
        "not valid TOML: {message}; `squeakscope scenes NAME` prints a valid scene to start from"
    )]
    Syntax {
        /// Message of the TOML parser.
        message: String,
    },
    /// An undeclared key or table.
    #[error("unknown key `{key}`{}; {known}", did_you_mean(nearest))]
    UnknownKey {
        /// Dotted path of the key.
        key: String,
        /// Dotted path of the most similar declared key, if any is similar enough.
        nearest: Option<String>,
        /// The declared keys of the table.
        known: String,
    },
    /// A plain value in place of a table.
    #[error("`{key}` is a table, not a value; write `[{key}]` and its keys below")]
    NotATable {
        /// Dotted path of the table.
        key: String,
    },
    /// A required key is absent.
    #[error("`{key}` is missing; it must be {expected}")]
    Missing {
        /// Dotted path of the key.
        key: String,
        /// Permitted values.
        expected: String,
    },
    /// A value of the wrong type.
    #[error("`{key}` is {found}; it must be {expected}")]
    WrongType {
        /// Dotted path of the key.
        key: String,
        /// The value as written, shortened.
        found: String,
        /// Permitted values.
        expected: String,
    },
    /// A key that cannot be varied: it is not a single number, or it is part of a function of time.
    #[error(
        "`{key}` cannot be varied{}: it is not a single number that is constant in time; choose a numeric \
         key from `squeakscope scenes --keys`",
        did_you_mean(constant)
    )]
    NotANumber {
        /// Dotted path of the key.
        key: String,
        /// Dotted path of the number that it replaces by a function of time, if there is one.
        constant: Option<String>,
    },
    /// A method with a fixed step, which has no tolerance.
    #[error(
        "`{method}` has a fixed step and no tolerance that an accuracy could determine; choose another time.method, such \
         as \"lawson54\""
    )]
    FixedStep {
        /// Name of the method.
        method: &'static str,
    },
    /// A number that is out of range or not finite.
    #[error("`{key}` = {found} is out of range; it must be {expected}")]
    OutOfRange {
        /// Dotted path of the key.
        key: String,
        /// The value as written, shortened.
        found: String,
        /// Permitted values.
        expected: String,
    },
    /// A word that is not among the choices.
    #[error(
        "`{key}` = {found} is not a valid choice{}; it must be {expected}",
        did_you_mean(nearest)
    )]
    UnknownChoice {
        /// Dotted path of the key.
        key: String,
        /// The value as written, shortened.
        found: String,
        /// The most similar choice, if any is similar enough.
        nearest: Option<String>,
        /// Permitted values.
        expected: String,
    },
    /// Values that are valid individually but inconsistent with each other.
    #[error("`{key}`: {problem}; {remedy}")]
    Inconsistent {
        /// Dotted path of the key.
        key: String,
        /// The inconsistency.
        problem: String,
        /// Remedy.
        remedy: String,
    },
}

impl Fault {
    /// Builds [`Fault::Inconsistent`].
    pub(super) fn inconsistent(
        key: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Inconsistent {
            key: key.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    /// Builds the error for this fault at a position.
    pub(super) fn at(self, at: Location) -> SceneError {
        SceneError::Content {
            at,
            fault: Box::new(self),
        }
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
fn did_you_mean(nearest: &Option<String>) -> String {
    nearest
        .as_ref()
        .map(|name| format!(" (did you mean `{name}`?)"))
        .unwrap_or_default()
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
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SceneWarning {
    /// The kinetic coefficient of friction exceeds the static one. Friction then increases with speed, and no
    /// negative slope excites vibration.
    KineticAboveStatic {
        /// Static coefficient of friction.
        mu_s: f64,
        /// Kinetic coefficient of friction.
        mu_d: f64,
    },
    /// The contact patch is so wide that Hertz contact describes it badly.
    WidePatch {
        /// Half-angle, rad.
        half_angle: f64,
        /// Share of the load that the normal forces do not carry.
        lost_load: f64,
    },
    /// The published natural frequencies are those of another body: dimensions or material differ.
    FrequenciesOfAnotherBody,
    /// The run ends before the schedule of tilt, load or rotation ends.
    ///
    /// This includes a step at the end of the run: no sample follows it.
    ScheduleCutShort {
        /// The quantity.
        of: &'static str,
        /// Simulated time, s.
        duration: f64,
        /// Time of the last knot or step of the schedule, s.
        last: f64,
    },
    /// Two knots of tilt, load or rotation lie within one frame, in which the joint is constant.
    PointsWithinFrame {
        /// The quantity.
        of: &'static str,
        /// Time of the later knot, s.
        time: f64,
        /// Length of a frame, s.
        frame: f64,
    },
    /// The run ends before an analysis starts.
    AnalysisNeverStarts {
        /// Path of the key that sets the start.
        key: &'static str,
        /// Start of the analysis, s.
        start: f64,
        /// Simulated time, s.
        duration: f64,
    },
}

impl fmt::Display for SceneWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::KineticAboveStatic { mu_s, mu_d } => write!(
                f,
                "friction.mu_d = {mu_d} exceeds friction.mu_s = {mu_s}: friction increases with speed, \
                 and no negative slope excites vibration"
            ),
            Self::WidePatch {
                half_angle,
                lost_load,
            } => write!(
                f,
                "the contact patch has a half-angle of {:.0} degrees, and Hertz contact holds for small ones: the normal \
                 force along the load is {:.1} % too small; give the pressure over the radius as contact.pressure",
                half_angle.to_degrees(),
                100.0 * lost_load
            ),
            Self::FrequenciesOfAnotherBody => f.write_str(
                "the published natural frequencies are those of the body of the paper, and body has other \
                 dimensions or another material; set body.frequencies = \"scaled\" or \"fe\"",
            ),
            Self::ScheduleCutShort { of, duration, last } => write!(
                f,
                "the run ends at {} ms, {} the last change of the {of} at {} ms; increase time.duration_ms",
                duration * 1e3,
                match last > duration {
                    true => "before",
                    false => "without a sample after",
                },
                last * 1e3
            ),
            Self::PointsWithinFrame { of, time, frame } => write!(
                f,
                "the {of} has a knot at {} ms that follows the previous knot by less than a frame; the {of} is \
                 updated once per frame, every {} ms, and knots within a frame have no effect; reduce \
                 time.frame_samples, or use steps",
                time * 1e3,
                frame * 1e3
            ),
            Self::AnalysisNeverStarts {
                key,
                start,
                duration,
            } => write!(
                f,
                "the run ends at {} ms, before {key} = {}, so this analysis has no result; increase \
                 time.duration_ms",
                duration * 1e3,
                start * 1e3
            ),
        }
    }
}
