//! The numbers of the scene that commands change during a live run, as time series.

use super::stream::RecordingStream;
use crate::pipeline::message::{Frame, Header};
use crate::plot::Color;
use crate::scene::{Control, Parameter};

/// Path and name of a number's series.
pub fn series(control: &Control) -> [String; 2] {
    let parameter = control.parameter;
    let name = format!("{}, {}", parameter.label(), parameter.unit());
    let path = parameter.path().replace('.', "/");
    let name = name.trim_end_matches(", ").to_owned();
    [format!("controls/{path}"), name]
}

/// The numbers of a live run besides the tilt, which has a series of its own.
pub fn recorded(header: &Header) -> impl Iterator<Item = &Control> {
    let controls = header.controls.iter();
    controls.filter(|control| control.parameter != Parameter::tilt())
}

/// Adds the values at the start of a frame: of the named numbers, and of the others from their first change on.
pub fn push(rec: &RecordingStream, header: &Header, frame: &Frame) {
    for control in recorded(header) {
        let mut changed = frame.changed.iter();
        let changed = changed.find(|(parameter, _)| *parameter == control.parameter);
        if control.is_named || changed.is_some() {
            let value = changed.map_or(control.value, |(_, value)| *value);
            let [path, name] = series(control);
            rec.name(&path, [(name, Color::Run)]);
            rec.row(&path, frame.t0, [value]);
        }
    }
}
