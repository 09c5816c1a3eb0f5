//! A run in frames of a playback speed, for the tests of the stores.

use std::sync::Arc;

use crate::pipeline::message::{DisplayRates, Record};
use crate::pipeline::{Analyser, Simulation, Sink, Source as _};
use crate::scene::Scene;

/// Runs a scene in frames of a playback speed (simulated seconds per second), and calls a function after each frame.
pub fn run_frames(
    scene: Scene,
    speed: f64,
    duration_ms: f64,
    sink: &mut impl Sink,
    mut after: impl FnMut(),
) {
    let scene = scene.with_duration(duration_ms).unwrap();
    let mut source = Simulation::new(&scene).unwrap();
    let header = source.header("");
    let (samples, shown) = DisplayRates::at_speed(speed, header.sample_rate);
    source.set_frame_length(samples, shown);
    let mut analyser = Analyser::new(&header.analysis, &header);
    sink.accept(Record::Header(Arc::new(header))).unwrap();
    while let Some(frame) = source.next_frame().unwrap() {
        analyser.push(&Arc::new(frame), sink).unwrap();
        after();
    }
}
