//! What can be wrong with a scene, said in one message: what, where, and the remedy.

use std::fmt;
use std::io;

use thiserror::Error;

use crate::joint::OwnModesError;

/// Where in its source a scene is at fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file as the user named it, or the name of a built-in scene.
    pub file: String,
    /// Line, counted from 1; `None` for a value that did not come from the text.
    pub line: Option<usize>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}", self.file),
            None => f.write_str(&self.file),
        }
    }
}

/// A scene that cannot be run. The message names the place, the key, what is allowed and, where
/// something was probably misspelt, the nearest known name.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Neither a built-in scene nor a file has the given name.
    #[error(
        "no scene is called `{name}`{}; the scenes are {known}, or give the path of a scene file",
        did_you_mean(nearest)
    )]
    UnknownScene {
        /// The name asked for.
        name: String,
        /// The built-in scene spelt most like it, if any is close.
        nearest: Option<String>,
        /// All built-in scenes, for the message.
        known: String,
    },
    /// The file cannot be read.
    #[error(
        "cannot read the scene file `{file}`; give a readable TOML file or the name of a built-in scene"
    )]
    Unreadable {
        /// The path asked for.
        file: String,
        /// Why not.
        source: io::Error,
    },
    /// The file is far larger than a scene can sensibly be.
    #[error(
        "the scene file `{file}` is larger than {limit} bytes; a scene is a few kilobytes of TOML"
    )]
    TooLarge {
        /// The path asked for.
        file: String,
        /// The largest size read, bytes.
        limit: u64,
    },
    /// A joint is needed, and the scene runs something else.
    #[error(
        "the scene `{scene}` runs {subject}, and this needs a ball joint; take a scene with a [load] \
         table, such as `{}`",
        super::DEFAULT_SCENE
    )]
    NoJoint {
        /// Name of the scene.
        scene: String,
        /// What it runs.
        subject: &'static str,
    },
    /// A ball on a beam is needed, and the scene takes its modes from a file.
    #[error(
        "the scene `{scene}` takes its modes and its contact patch from `{file}`, and this needs \
         those of ball and beam; take a scene without body.modes, such as `{}`",
        super::DEFAULT_SCENE
    )]
    NoBeam {
        /// Name of the scene.
        scene: String,
        /// The file of the modes.
        file: String,
    },
    /// The file of the modes is at fault.
    #[error("{at}: `body.modes`: {file}: {problem}")]
    Modes {
        /// Where the scene names it.
        at: Place,
        /// The file.
        file: String,
        /// What is wrong with it, and what to do.
        problem: Box<OwnModesError>,
    },
    /// A small system is needed, and the scene runs a joint.
    #[error(
        "the scene `{scene}` runs a ball joint, and this needs a small system; take a scene with a \
         table such as [impact_oscillator]"
    )]
    NoSmallSystem {
        /// Name of the scene.
        scene: String,
    },
    /// The content is at fault.
    #[error("{at}: {fault}")]
    Content {
        /// Where: the value or key at fault, or the table that lacks a key.
        at: Place,
        /// What is wrong.
        fault: Box<Fault>,
    },
}

/// What is wrong with the content of a scene.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// The bytes are not text.
    #[error("the scene file is not UTF-8 text; save it as UTF-8")]
    NotText,
    /// The text is not TOML.
    #[error(
        "not valid TOML: {message}; `squeakscope scenes NAME` prints a valid scene to start from"
    )]
    Syntax {
        /// What the parser said.
        message: String,
    },
    /// A key or table that no scene has.
    #[error("unknown key `{key}`{}; {known}", did_you_mean(nearest))]
    UnknownKey {
        /// Full path of the key.
        key: String,
        /// Full path of the known key spelt most like it, if any is close.
        nearest: Option<String>,
        /// The keys known in its table, for the message.
        known: String,
    },
    /// A plain value under a name that is a table's.
    #[error("`{key}` is a table, not a value; write `[{key}]` and its keys below")]
    NotATable {
        /// Full path of the table.
        key: String,
    },
    /// A required key is absent.
    #[error("`{key}` is missing; it must be {expected}")]
    Missing {
        /// Full path of the key.
        key: String,
        /// What the value must be.
        expected: String,
    },
    /// A value of another type than the key's.
    #[error("`{key}` is {found}; it must be {expected}")]
    WrongType {
        /// Full path of the key.
        key: String,
        /// The value as written, shortened.
        found: String,
        /// What the value must be.
        expected: String,
    },
    /// A key that is no single number, or part of a function of time, where one is to be varied.
    #[error(
        "`{key}` is no single number that holds for a whole run; only such can be varied, \
         `squeakscope scenes --keys` lists them"
    )]
    NotANumber {
        /// Its dotted path.
        key: String,
    },
    /// No advice for an error so small.
    #[error("the scene `{scene}` knows no integrator for an error of {error}; {remedy}")]
    NoAdvice {
        /// Name of the scene.
        scene: String,
        /// The error wanted.
        error: String,
        /// What to do.
        remedy: String,
    },
    /// A number outside its range, or not finite.
    #[error("`{key}` = {found} is out of range; it must be {expected}")]
    OutOfRange {
        /// Full path of the key.
        key: String,
        /// The value as written, shortened.
        found: String,
        /// What the value must be.
        expected: String,
    },
    /// A word that is none of the choices.
    #[error(
        "`{key}` = {found} is not a choice{}; it must be {expected}",
        did_you_mean(nearest)
    )]
    UnknownChoice {
        /// Full path of the key.
        key: String,
        /// The value as written, shortened.
        found: String,
        /// The choice spelt most like it, if any is close.
        nearest: Option<String>,
        /// What the value must be.
        expected: String,
    },
    /// Values that are each allowed, but not together.
    #[error("`{key}`: {problem}; {remedy}")]
    Inconsistent {
        /// Full path of its key.
        key: String,
        /// What does not fit together.
        problem: String,
        /// What to do about it.
        remedy: String,
    },
}

impl Fault {
    /// Values that are each allowed, but not together.
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

    /// The error of this fault at a place.
    pub(super) fn at(self, at: Place) -> SceneError {
        SceneError::Content {
            at,
            fault: Box::new(self),
        }
    }
}

/// Refuses values that do not fit together, unless the condition holds. After it come the key at fault,
/// other keys that take part, the problem, and the remedy.
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

/// The part of a message that offers another spelling.
fn did_you_mean(nearest: &Option<String>) -> String {
    nearest
        .as_ref()
        .map(|name| format!(" (did you mean `{name}`?)"))
        .unwrap_or_default()
}

/// Below this likeness (0 to 1) a suggestion confuses more than it helps.
pub(super) const CLOSE: f64 = 0.5;
/// From this likeness (0 to 1) on it is hardly anything but a misspelling.
pub(super) const VERY_CLOSE: f64 = 0.75;

/// The candidate spelt most like `word`, if any is as `close` (0 to 1) as that.
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

/// Something in a valid scene that the user probably did not mean.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SceneWarning {
    /// The kinetic coefficient of friction exceeds the static one, so friction grows with speed
    /// and the negative slope that drives the squeak is gone.
    KineticAboveStatic {
        /// Static coefficient.
        mu_s: f64,
        /// Kinetic coefficient.
        mu_d: f64,
    },
    /// The run ends before tilt, load or rotation have gone through their whole schedule.
    ///
    /// A change at the very end counts, too: no sample is later.
    ScheduleCutShort {
        /// Which of them.
        of: &'static str,
        /// Simulated time, s.
        duration: f64,
        /// Time of the schedule's last knot or step, s.
        last: f64,
    },
    /// Points of tilt, load or rotation follow each other faster than the joint follows them.
    PointsWithinFrame {
        /// Which of them.
        of: &'static str,
        /// Time of the later of the two points, s.
        time: f64,
        /// Length of a frame, s.
        frame: f64,
    },
    /// The run ends before something that it asks for has begun.
    NeverBegins {
        /// Path of the key that says when.
        key: &'static str,
        /// When it would begin, s.
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
                "friction.mu_d = {mu_d} exceeds friction.mu_s = {mu_s}: friction then grows with \
                 speed, and the falling part of the curve that drives squeak is absent"
            ),
            Self::ScheduleCutShort { of, duration, last } => write!(
                f,
                "the run ends at {} ms, {} the last change of the {of} at {} ms",
                duration * 1e3,
                match last > duration {
                    true => "before",
                    false => "too early for",
                },
                last * 1e3
            ),
            Self::PointsWithinFrame { of, time, frame } => write!(
                f,
                "the {of} has a knot at {} ms that is less than a frame after the one before, and is looked at \
                 only where a frame starts, every {} ms: what is between is not seen; make time.frame_samples \
                 smaller, or use steps",
                time * 1e3,
                frame * 1e3
            ),
            Self::NeverBegins {
                key,
                start,
                duration,
            } => write!(
                f,
                "the run ends at {} ms, before {key} = {}: nothing comes of its table",
                duration * 1e3,
                start * 1e3
            ),
        }
    }
}
