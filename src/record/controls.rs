//! The numbers of the scene that commands change during a live run, as time series.

use super::{
    error::RecordError,
    samples::{Rows, name_series},
    stream::RecordingStream,
    style,
};
use crate::{
    pipeline::message::{Frame, Header},
    scene::{Control, Parameter},
};

/// The series: those of the named numbers, and of the others from their first change on.
#[derive(Debug)]
pub struct Controls(Vec<(Control, Rows)>);

/// Path and name of a number's series.
pub fn series(control: &Control) -> [String; 2] {
    let parameter = control.parameter;
    let name = format!("{}, {}", parameter.label(), parameter.unit());
    let path = parameter.path().replace('.', "/");
    [
        format!("controls/{path}"),
        name.trim_end_matches(", ").to_owned(),
    ]
}

/// The numbers of a live run besides the tilt, which has a series of its own.
pub fn recorded(header: &Header) -> impl Iterator<Item = &Control> {
    let controls = header.controls.iter();
    controls.filter(|control| control.parameter != Parameter::tilt())
}

impl Controls {
    /// Names the series and starts empty.
    pub fn new(rec: &RecordingStream, header: &Header) -> Result<Self, RecordError> {
        let series = recorded(header).map(|control| {
            let [path, name] = series(control);
            name_series(rec, &path, [name], [style::SIGNAL])?;
            Ok((*control, Rows::new(path, 1)))
        });
        series.collect::<Result<_, _>>().map(Self)
    }

    /// Adds the values at the start of a frame.
    pub fn push(&mut self, rec: &RecordingStream, frame: &Frame) -> Result<(), RecordError> {
        for (control, rows) in &mut self.0 {
            let mut changed = frame.changed.iter();
            let changed = changed.find(|(parameter, _)| *parameter == control.parameter);
            if control.is_named || changed.is_some() {
                let value = changed.map_or(control.value, |(_, value)| *value);
                rows.push(frame.t0, [value]);
                rows.send_full(rec)?;
            }
        }
        Ok(())
    }

    /// Sends pending rows.
    pub fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        self.0.iter_mut().try_for_each(|(_, rows)| rows.send(rec))
    }
}
