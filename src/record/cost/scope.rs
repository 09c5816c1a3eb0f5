//! The pictures of a knob: their axes, so that both have the same scale of errors, and what holds for
//! both.

use rerun::Color;

use super::view::{FamilyView, KnobView, SettingView};
use crate::{
    analysis::range,
    record::{
        paths,
        plot::{Axis, CAPTION_HEIGHT, Plot, key_height},
        style::MODES,
    },
};

/// The field of a picture beside another, and of one alone, pixels.
const FIELD: [f32; 2] = [520.0, 700.0];
const FIELD_ALONE: [f32; 2] = [1100.0, 700.0];

/// What errors are set against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// CPU time.
    Time,
    /// Calls of the right-hand side.
    Calls,
}

impl Work {
    /// That of a setting, in the unit of the axis; `None` where there is none.
    pub fn of(self, setting: &SettingView) -> Option<f64> {
        let work = match self {
            Self::Time => 1e3 * setting.seconds,
            Self::Calls => 1e-3 * setting.calls as f64,
        };
        (work > 0.0).then_some(work)
    }

    /// Its name and unit.
    fn words(self) -> &'static str {
        match self {
            Self::Time => "CPU time, ms",
            Self::Calls => "calls of the right-hand side, thousands",
        }
    }

    /// The path of the picture.
    pub fn path(self) -> &'static str {
        match self {
            Self::Time => paths::COST_TIME,
            Self::Calls => paths::COST_CALLS,
        }
    }

    /// The name of the picture.
    pub fn title(self) -> &'static str {
        match self {
            Self::Time => "Error over CPU time",
            Self::Calls => "Error over calls of the right-hand side",
        }
    }
}

/// A picture: errors over one kind of work.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Over what.
    pub work: Work,
    /// Its axes.
    pub plot: Plot,
}

/// The pictures of a knob.
#[derive(Clone, Debug, PartialEq)]
pub struct Scope {
    /// Over CPU time, and over calls if there are any.
    pub pictures: Vec<Picture>,
}

impl Scope {
    /// That of a knob.
    pub fn new(knob: &KnobView) -> Self {
        let has_calls = knob.settings().any(|setting| setting.calls > 0);
        let (works, [width, height]): (&[Work], _) = match has_calls {
            true => (&[Work::Time, Work::Calls], FIELD),
            false => (&[Work::Time], FIELD_ALONE),
        };
        let errors = errors(knob, height);
        let picture = |&work: &Work| {
            let spent = knob.settings().filter_map(|setting| work.of(setting));
            Picture {
                work,
                plot: Plot {
                    width,
                    height,
                    head: key_height(width, &key(knob)),
                    x: Axis::closely(work.words(), ends(spent)),
                    y: Axis::powers(knob.error, errors),
                    grid: true,
                },
            }
        };
        Self {
            pictures: works.iter().map(picture).collect(),
        }
    }
}

/// The colour of a family by its place. Neighbours among the colours of the modes are alike.
pub fn color(place: usize) -> Color {
    const ORDER: [usize; 7] = [0, 2, 4, 6, 8, 10, 3];
    MODES[ORDER[place % ORDER.len()]]
}

/// Names of the families in their colours.
pub fn key(knob: &KnobView) -> Vec<(String, Color)> {
    let names = knob.families.iter().map(|family| family.name.clone());
    names.zip((0..).map(color)).collect()
}

/// The errors of the references, where they can be drawn, with the places of their families.
pub fn floors(knob: &KnobView) -> impl Iterator<Item = (usize, f64)> {
    let families = knob.families.iter().enumerate();
    let floors = families.filter_map(|(place, family)| Some((place, family.floor?)));
    floors.filter(|(_, floor)| *floor > 0.0)
}

/// The error of the reference, if all families have the same.
pub fn common_floor(knob: &KnobView) -> Option<f64> {
    let mut all = floors(knob).map(|(_, floor)| floor);
    let first = all.next()?;
    all.all(|floor| floor == first).then_some(first)
}

/// The families with settings that failed, which have a row each at the top of the field.
pub fn failing(knob: &KnobView) -> impl Iterator<Item = (usize, &FamilyView)> {
    let families = knob.families.iter().enumerate();
    families.filter(|(_, family)| family.settings.iter().any(|s| s.error.is_err()))
}

/// The decades of the errors, with room for failures at the top, and at the bottom for the words below
/// the floor. Errors of nothing at all do not count: they are drawn at the lower end.
fn errors(knob: &KnobView, height: f32) -> [i32; 2] {
    let told = knob
        .settings()
        .filter_map(|s| s.error.as_ref().ok().copied());
    let floors = || floors(knob).map(|(_, floor)| floor);
    let [mut low, mut high] = decades(told.filter(|error| *error > 0.0).chain(floors()));
    let rows = failing(knob).count();
    let room = |low: i32, high: i32, decades: f64| {
        f64::from(height) * decades / f64::from(high - low).max(1.0)
    };
    let lowest = floors().fold(f64::INFINITY, f64::min);
    if lowest.is_finite() && room(low, high, lowest.log10() - f64::from(low)) < LINE {
        low -= 1;
    }
    let top = high;
    while room(low, high, f64::from(high - top)) < LINE * rows as f64 {
        high += 1;
    }
    [low, high]
}

/// Height of a line of words in the field, pixels.
const LINE: f64 = 1.2 * CAPTION_HEIGHT as f64;

/// The height of the row of a family that fails, pixels from the top of the field.
pub fn row(number: usize) -> f32 {
    (LINE * (number as f64 + 0.5)) as f32
}

/// The ends of some positive values, apart from each other.
fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    match range(values) {
        [low, high] if low < high => [low, high],
        [only, same] if only == same => [0.7 * only, 1.5 * only],
        _ => [0.1, 1.0],
    }
}

/// Whole decades round some positive values, at least one.
fn decades(values: impl Iterator<Item = f64>) -> [i32; 2] {
    let [low, high] = range(values.map(f64::log10));
    if low > high {
        return [-1, 0];
    }
    let ends = [low, high].map(|end| end.clamp(-300.0, 300.0));
    let [low, high] = [ends[0].floor() as i32, ends[1].ceil() as i32];
    [low, high.max(low + 1)]
}
