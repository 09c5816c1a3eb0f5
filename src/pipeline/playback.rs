//! A signal that somebody else made, on the road of a simulation.

use super::PipelineError;
use super::message::{Frame, Header, SignalInfo, Subject};
use super::source::{Source, kinds, section_coordinates};
use crate::scene::{AnalysisSpec, SectionSpec, SectionSurface};

/// Samples that travel together.
const FRAME_SAMPLES: usize = 1024;

/// Cuts samples into frames.
///
/// Displacement and velocity are both the signal, in its own unit; there are no modes, no contact
/// and no energy, and no time is spent on integration. Where an [`AnalysisSpec`] says m, the
/// signal's unit is meant; a section of the modal state is not computed, nor what needs a simulation: exponents
/// of the tangent flow and a second copy.
#[derive(Clone, Debug)]
pub struct Playback<'a> {
    title: String,
    info: SignalInfo,
    samples: &'a [f64],
    rate: f64,
    analysis: AnalysisSpec,
    frames: u64,
}

impl<'a> Playback<'a> {
    /// Plays finite `samples` at `rate` (Hz, above 0), the first one at the time that `info` says.
    /// `title` is one line that says what they are.
    pub fn new(
        title: impl Into<String>,
        info: SignalInfo,
        samples: &'a [f64],
        rate: f64,
        analysis: AnalysisSpec,
    ) -> Self {
        let delay_section =
            |section: &SectionSpec| matches!(section.surface, SectionSurface::Delay { .. });
        Self {
            title: title.into(),
            info,
            samples,
            rate,
            analysis: AnalysisSpec {
                section: analysis.section.filter(delay_section),
                exponents: None,
                butterfly: None,
                ..analysis
            },
            frames: 0,
        }
    }

    /// Index of the next sample.
    fn next_sample(&self) -> usize {
        self.samples.len().min(self.frames as usize * FRAME_SAMPLES)
    }
}

impl Source for Playback<'_> {
    fn header(&self, command: &str) -> Header {
        Header {
            scene: self.info.source.clone(),
            title: self.title.clone(),
            about: String::new(),
            scene_text: String::new(),
            command: command.to_owned(),
            sample_rate: self.rate,
            duration: self.samples.len() as f64 / self.rate,
            endless: false,
            analyses: kinds(&self.analysis),
            section: section_coordinates(&self.analysis),
            subject: Subject::Signal(self.info.clone()),
            computed: None,
        }
    }

    fn analysis(&self) -> &AnalysisSpec {
        &self.analysis
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
        let first = self.next_sample();
        let end = self.samples.len().min(first + FRAME_SAMPLES);
        if first == end {
            return Ok(None);
        }
        let piece = self.samples[first..end].to_vec();
        let frame = Frame {
            index: self.frames,
            t0: self.info.start + first as f64 / self.rate,
            dt: 1.0 / self.rate,
            velocity: piece.clone(),
            displacement: piece,
            ..Frame::default()
        };
        self.frames += 1;
        Ok(Some(frame))
    }

    fn is_over(&self) -> bool {
        self.next_sample() == self.samples.len()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;
    use std::sync::{Arc, Mutex};

    use super::*;
    use crate::pipeline::message::Record;
    use crate::pipeline::stages::synthetic::{Motion, RATE, laboratory};
    use crate::pipeline::{Monitor, drive};

    const START: f64 = -1.5;

    fn playback(samples: &[f64]) -> Playback<'_> {
        let info = SignalInfo {
            source: "squeak.wav".into(),
            column: "left".into(),
            unit: "FS".into(),
            start: START,
            span: [-1.0, 1.0],
            highest_frequency: 10e3,
        };
        Playback::new("a squeak", info, samples, RATE, laboratory())
    }

    fn tone(seconds: f64) -> Vec<f64> {
        Motion::tones(seconds, &[(4003.0, 0.3, 0.2)]).velocity
    }

    #[test]
    fn frames_hold_every_sample_once_and_in_order() {
        for count in [0, 1, FRAME_SAMPLES, 2 * FRAME_SAMPLES + 1] {
            let samples: Vec<f64> = (0..count).map(|k| k as f64).collect();
            let mut source = playback(&samples);
            let mut played = Vec::new();
            while let Some(frame) = source.next_frame().unwrap() {
                assert_eq!(frame.t0, START + played.len() as f64 / RATE);
                assert_eq!(frame.velocity, frame.displacement);
                played.extend(frame.displacement);
            }
            assert_eq!(played, samples);
            assert!(source.is_over());
            assert!(source.next_frame().unwrap().is_none());
        }
    }

    #[test]
    fn a_signal_goes_down_the_whole_road() {
        let samples = tone(0.03);
        // Of the last window, 20 ms.
        let last = &samples[samples.len() - 4000..];
        let largest = last.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let progress = Mutex::new(Vec::new());
        let stop = Arc::new(AtomicBool::new(false));
        let monitor = Monitor {
            stop: &stop,
            progress: &|time| progress.lock().unwrap().push(time),
        };
        let mut records: Vec<Record> = Vec::new();
        let summary = drive(playback(&samples), "analyse", &mut records, monitor).unwrap();
        assert!((summary.simulated - 0.03).abs() < 1e-12);
        assert_eq!((summary.real_time_factor, summary.audit), (0.0, None));
        assert_eq!(summary.peak_velocity, largest);
        assert!((summary.peaks[0].frequency - 4003.0).abs() < 1.0);
        assert!(!summary.interrupted);
        let times = progress.into_inner().unwrap();
        assert!((times.last().unwrap() - (START + 0.03)).abs() < 1e-12);

        let Record::Header(header) = &records[0] else {
            panic!("the header comes first");
        };
        assert_eq!(header.start(), START);
        assert!((header.duration - 0.03).abs() < 1e-12);
        for record in &records {
            match record {
                Record::Health(health) => {
                    assert_eq!((health.real_time_factor, health.audit), (0.0, None));
                    assert_eq!((health.steps_per_ms, health.calls_per_ms), (0.0, 0.0));
                }
                Record::Narration { text, .. } => panic!("words on a joint: {text}"),
                _ => {}
            }
        }
        let delays = records.iter().filter(|r| matches!(r, Record::Delay { .. }));
        assert_eq!(delays.count(), 6);
    }

    #[test]
    fn a_section_of_modes_is_left_out_where_there_are_none() {
        let mut analysis = laboratory();
        let section = analysis.section.as_mut().unwrap();
        section.surface = SectionSurface::State {
            normal_q: vec![1.0],
            normal_qdot: Vec::new(),
            offset: 0.0,
            shown: [crate::scene::StateCoordinate::Q(0); 2],
        };
        let info = playback(&[]).info;
        let samples = tone(0.01);
        let source = Playback::new("", info, &samples, RATE, analysis);
        assert!(source.analysis().section.is_none());
        assert!(
            !source
                .header("")
                .has(crate::pipeline::message::AnalysisKind::Section)
        );
    }

    #[test]
    fn a_signal_without_samples_is_over_at_once() {
        let mut records: Vec<Record> = Vec::new();
        let summary = drive(playback(&[]), "", &mut records, Monitor::default()).unwrap();
        assert_eq!((summary.simulated, summary.interrupted), (0.0, false));
        assert_eq!(records.len(), 2, "header and summary");
    }
}
