//! One picture of a knob: a curve a family, a point a setting.

use rerun::{Color, DynamicArchetype, LineStrips2D, Points2D, Radius, components::Scalar};

use super::{
    scope::{Picture, color, common_floor, failing, floors, key, row},
    view::{FamilyView, KnobView, SettingView},
    words,
};
use crate::record::{
    error::RecordError,
    paths::{self, Root},
    stream::RecordingStream,
    style,
};

/// Half the size of a cross, pixels.
const CROSS: f32 = 6.0;
/// Lengths of the strokes of a dashed line and of the gaps between them, pixels.
const STROKE: f32 = 8.0;
const GAP: f32 = 6.0;
/// Width of a letter in the field, pixels.
const LETTER: f32 = 8.0;

/// The numbers of a knob's settings, a family an entity, for those who read the recording rather than look
/// at it.
pub fn log_numbers(rec: &RecordingStream, root: &Root, knob: &KnobView) -> Result<(), RecordError> {
    for family in &knob.families {
        let settings = &family.settings;
        let column =
            |of: fn(&SettingView) -> f64| settings.iter().map(move |s| Scalar::from(of(s)));
        let error = |s: &SettingView| *s.error.as_ref().unwrap_or(&f64::NAN);
        let numbers = DynamicArchetype::new("squeakscope.Settings")
            .with_component::<Scalar>("setting", column(|s| s.value))
            .with_component::<Scalar>("cpu_ms", column(|s| 1e3 * s.seconds))
            .with_component::<Scalar>("calls", column(|s| s.calls as f64))
            .with_component::<Scalar>("error", column(error));
        rec.log_static(root.at(&paths::cost_numbers(&family.name)), &numbers)?;
    }
    Ok(())
}

/// Looks that the viewer gives to points and crosses of settings: they must not say it themselves, since
/// the tooltip names the components of what is pointed at only where they are no more than three, and
/// their words are one of them.
pub fn default_looks() -> (Points2D, LineStrips2D) {
    (
        Points2D::update_fields()
            .with_radii([Radius::new_ui_points(4.2)])
            .with_show_labels(false),
        LineStrips2D::update_fields()
            .with_radii([Radius::new_ui_points(1.2)])
            .with_show_labels(false),
    )
}

/// Draws a picture of a knob for all times.
pub fn draw_picture(
    rec: &RecordingStream,
    root: &Root,
    knob: &KnobView,
    picture: &Picture,
) -> Result<(), RecordError> {
    let path = picture.work.path();
    let axes = root.at(&paths::cost_axes(path));
    picture.plot.draw(rec, &axes, None)?;
    let key_path = root.at(&paths::cost_key(path));
    picture.plot.draw_key(rec, &key_path, &key(knob))?;
    floor(rec, root, knob, picture)?;
    advised(rec, root, knob, picture)?;
    for (place, family) in knob.families.iter().enumerate() {
        curve(rec, root, family, picture, place)?;
    }
    for (number, (place, family)) in failing(knob).enumerate() {
        failures(rec, root, family, picture, (number, color(place)))?;
    }
    Ok(())
}

/// The place of a setting that has an error.
fn place(picture: &Picture, setting: &SettingView) -> Option<[f32; 2]> {
    let error = *setting.error.as_ref().ok()?;
    Some(picture.plot.at(picture.work.of(setting)?, error))
}

/// Below the error of the reference nothing is told.
fn floor(
    rec: &RecordingStream,
    root: &Root,
    knob: &KnobView,
    picture: &Picture,
) -> Result<(), RecordError> {
    let plot = &picture.plot;
    let common = common_floor(knob);
    let height = |floor: f64| plot.at(plot.x.low, floor)[1];
    let lines: Vec<(f32, Color)> = match common {
        Some(floor) => vec![(height(floor), style::AXIS)],
        None => floors(knob)
            .map(|(place, floor)| (height(floor), style::faded(color(place), 0.7)))
            .collect(),
    };
    let Some(lowest) = lines.iter().map(|(height, _)| *height).reduce(f32::max) else {
        return Ok(());
    };
    let mut strokes = Vec::new();
    let mut colors = Vec::new();
    for (height, color) in lines {
        let lefts = (0..).map(|k| k as f32 * (STROKE + GAP));
        for left in lefts.take_while(|left| *left < plot.width) {
            strokes.push([[left, height], [(left + STROKE).min(plot.width), height]]);
            colors.push(color);
        }
    }
    let words = words::floor(common);
    let middle = 0.5 * LETTER * words.chars().count() as f32 + GAP;
    let path = root.at(&paths::cost_floor(picture.work.path()));
    let strokes = LineStrips2D::new(strokes)
        .with_colors(colors)
        .with_radii([Radius::new_ui_points(0.7)])
        .with_draw_order(0.0);
    rec.log_static(path.as_str(), &strokes)?;
    let label = Points2D::new([[middle, lowest + 2.0]])
        .with_labels([words])
        .with_show_labels(true)
        .with_colors([style::AXIS])
        .with_radii([Radius::new_ui_points(0.0)]);
    rec.log_static(path, &label)
}

/// White rims round the cheapest settings.
fn advised(
    rec: &RecordingStream,
    root: &Root,
    knob: &KnobView,
    picture: &Picture,
) -> Result<(), RecordError> {
    let settings = knob.advice.iter().filter_map(|advice| knob.advised(advice));
    let places: Vec<[f32; 2]> = settings
        .filter_map(|(_, setting)| place(picture, setting))
        .collect();
    if places.is_empty() {
        return Ok(());
    }
    let rims = Points2D::new(places)
        .with_colors([style::POLE])
        .with_radii([Radius::new_ui_points(7.5)])
        .with_draw_order(1.0);
    let path = root.at(&paths::cost_advised(picture.work.path()));
    rec.log_static(path, &rims)
}

/// The settings of a family in their order. A line that another may cover is wider, so that it is still
/// seen.
fn curve(
    rec: &RecordingStream,
    root: &Root,
    family: &FamilyView,
    picture: &Picture,
    number: usize,
) -> Result<(), RecordError> {
    let drawn = family.settings.iter();
    let drawn = drawn.filter_map(|setting| Some((place(picture, setting)?, setting)));
    let (places, settings): (Vec<[f32; 2]>, Vec<&SettingView>) = drawn.unzip();
    let (color, path) = (color(number), picture.work.path());
    let wider = 0.1 * (6 - number.min(6)) as f32;
    let line = LineStrips2D::new(Some(&places).filter(|places| places.len() > 1))
        .with_colors([color])
        .with_radii([Radius::new_ui_points(0.9 + wider)])
        .with_draw_order(2.0 + number as f32);
    rec.log_static(root.at(&paths::cost_curve(path, &family.name)), &line)?;
    // Three components and no more, so that the pointer shows the words: the rest is the view's default.
    let points = Points2D::new(places)
        .with_colors([color])
        .with_labels(settings.iter().map(|setting| words::point(family, setting)));
    rec.log_static(root.at(&paths::cost_points(path, &family.name)), &points)
}

/// Crosses in a row of their own above all errors, and whose they are.
fn failures(
    rec: &RecordingStream,
    root: &Root,
    family: &FamilyView,
    picture: &Picture,
    (number, color): (usize, Color),
) -> Result<(), RecordError> {
    let plot = &picture.plot;
    let height = row(number);
    let failed = family.settings.iter().filter(|s| s.error.is_err());
    let failed = failed.filter_map(|s| Some((plot.at(picture.work.of(s)?, plot.y.high)[0], s)));
    let (places, settings): (Vec<f32>, Vec<&SettingView>) = failed.unzip();
    if places.is_empty() {
        return Ok(());
    }
    // Through the middle to all four ends in one stroke: one strip a setting, so that each has its words.
    let cross = |x: f32| {
        let end = |right: f32, down: f32| [x + CROSS * right, height + CROSS * down];
        [
            end(-1.0, -1.0),
            end(1.0, 1.0),
            end(0.0, 0.0),
            end(-1.0, 1.0),
            end(1.0, -1.0),
        ]
    };
    let crosses = LineStrips2D::new(places.iter().map(|x| cross(*x)))
        .with_colors([color])
        .with_labels(settings.iter().map(|setting| words::point(family, setting)));
    let path = picture.work.path();
    let crosses_path = root.at(&paths::cost_failed(path, &family.name));
    rec.log_static(crosses_path, &crosses)?;
    let words = format!("{} failed", family.name);
    let label = Points2D::new([[beside(&places, &words, plot.width), height - 13.0]])
        .with_labels([words])
        .with_show_labels(true)
        .with_colors([color])
        .with_radii([Radius::new_ui_points(0.0)]);
    let path = root.at(&paths::cost_failed_words(path, &family.name));
    rec.log_static(path, &label)
}

/// The middle of words beside crosses: right of the last where there is room in the field, else left of
/// the first.
fn beside(crosses: &[f32], words: &str, width: f32) -> f32 {
    let half = 0.5 * LETTER * words.chars().count() as f32 + CROSS + GAP;
    let first = crosses.iter().copied().fold(f32::INFINITY, f32::min);
    let last = crosses.iter().copied().fold(0.0, f32::max);
    if last + 2.0 * half < width {
        last + half
    } else {
        first - half
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stand_beside_crosses_within_the_field() {
        let (right, left) = (
            beside(&[10.0, 40.0], "rk4", 200.0),
            beside(&[190.0], "rk4", 200.0),
        );
        assert!(right > 40.0 + CROSS && left < 190.0 - CROSS);
        assert_eq!(right - 40.0, 190.0 - left);
    }
}
