//! What a recording of a sweep is made of.

use crate::{
    analysis::{Measures, RecurrenceImage, Regime},
    dynamics::LyapunovSpectrum,
    pipeline::message::{SpectralLine, SurfaceMesh},
};

/// A sweep over one parameter, as far as it has come.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepView {
    /// Name of the scene.
    pub scene: String,
    /// Its title.
    pub title: String,
    /// What it shows.
    pub about: String,
    /// Text of the scene file.
    pub scene_text: String,
    /// How the program was started.
    pub command: String,
    /// Letter of the probe's displacement on axes.
    pub letter: &'static str,
    /// Delay of the Poincaré sections, s.
    pub lag: f64,
    /// What is varied.
    pub parameter: ParameterView,
    /// All of its values, rising, in its unit.
    pub values: Vec<f64>,
    /// The ways in which points were started, those without any point left out.
    pub starts: Vec<StartView>,
    /// Ball and beam with their natural modes, if they are to be shown.
    pub body: Option<BodyView>,
}

/// Ball and beam with their natural modes.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyView {
    /// The surface, whose vertices carry the mode shapes.
    pub outline: SurfaceMesh,
    /// The modes to show.
    pub modes: Vec<ShapeView>,
}

/// A natural mode.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeView {
    /// What it is called.
    pub name: String,
    /// Natural frequency, Hz.
    pub frequency: f64,
    /// Its place among the shapes of the surface.
    pub mode: usize,
    /// Whether it turns about the beam's axis.
    pub turns: bool,
}

/// A parameter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterView {
    /// Its name in a word or two, such as `tilt`.
    pub name: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// Name and unit as they stand on an axis.
    pub label: String,
}

/// The points that were started in one way.
#[derive(Clone, Debug, PartialEq)]
pub struct StartView {
    /// The way in a word: the folder of its entities.
    pub key: String,
    /// The way in words, such as `continued up`.
    pub words: String,
    /// The points, in any order.
    pub points: Vec<PointView>,
}

impl StartView {
    /// The point at a value.
    pub fn at(&self, value: f64) -> Option<&PointView> {
        self.points.iter().find(|point| point.value == value)
    }
}

/// A point of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct PointView {
    /// Value of the parameter.
    pub value: f64,
    /// The value from whose settled state it was started; `None` if from the scene's own kick.
    pub from: Option<f64>,
    /// The response, or why there is none.
    pub outcome: Result<ResponseView, String>,
}

/// A settled response, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseView {
    /// Time before the measurement began, s.
    pub transient: f64,
    /// Whether the transient was over by then.
    pub settled: bool,
    /// Kind of motion.
    pub regime: Regime,
    /// How sure that is, 0 to 1.
    pub confidence: f64,
    /// Half the range of the displacement, m.
    pub amplitude: f64,
    /// Root mean square of the velocity, m/s.
    pub rms_velocity: f64,
    /// Local maxima of the displacement, m.
    pub maxima: Vec<f64>,
    /// Passages through the Poincaré section, m: `y(t)` and `y(t + 2 tau)`.
    pub section: Vec<[f64; 2]>,
    /// Lines of the displacement's spectrum, the strongest first, m.
    pub lines: Vec<SpectralLine>,
    /// Lyapunov exponents; `None` if none were followed.
    pub exponents: Option<LyapunovSpectrum>,
    /// Recurrence measures; `None` where nothing moves.
    pub measures: Option<Measures>,
    /// Unstable linear modes of steady sliding; `None` for a system without.
    pub unstable: Option<Vec<UnstableMode>>,
    /// A piece of the motion; `None` if none was kept.
    pub motion: Option<MotionView>,
    /// Its recurrence plot; `None` where there is none.
    pub recurrence: Option<RecurrenceImage>,
}

/// A linear mode that grows.
#[derive(Clone, Debug, PartialEq)]
pub struct UnstableMode {
    /// What it is called.
    pub label: String,
    /// Frequency, Hz.
    pub frequency: f64,
    /// Growth rate, 1/s.
    pub growth: f64,
}

/// A piece of the settled motion, and its spectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionView {
    /// Spacing of the samples, s.
    pub dt: f64,
    /// Displacements, m.
    pub displacement: Vec<f32>,
    /// Velocities at the same instants, m/s.
    pub velocity: Vec<f32>,
    /// Spacing of the spectrum's bins, the first at 0, Hz.
    pub bin: f64,
    /// Amplitude spectrum of the displacement, m.
    pub spectrum: Vec<f32>,
}
