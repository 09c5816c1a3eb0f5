//! A recorded signal as the source of a run.

use super::PipelineError;
use super::endpoints::Source;
use super::message::{Frame, Header, SignalInfo, Subject};
use crate::scene::AnalysisSpec;

/// Samples per frame.
const FRAME_SAMPLES: usize = 1024;

/// Splits a recorded signal into frames.
///
/// Displacement and velocity are both the signal, in its own unit. There are no modes, no contact and no
/// energy, and no integration time. Thresholds of the [`AnalysisSpec`] in m are in the signal's unit.
/// Analyses that need a simulation have no results: sections of the modal state, Lyapunov exponents from the
/// tangent flow, and the perturbed trajectory.
#[derive(Clone, Debug)]
pub struct SignalSource<'a> {
    header: Header,
    samples: &'a [f64],
    /// Index of the next sample.
    next: usize,
}

impl<'a> SignalSource<'a> {
    /// Plays finite `samples` at the sample rate `rate` (Hz, above 0), starting at [`SignalInfo::start`].
    pub fn new(info: SignalInfo, samples: &'a [f64], rate: f64, analysis: AnalysisSpec) -> Self {
        let (source, column, count) = (&info.source, &info.column, samples.len());
        let header = Header {
            scene: source.clone(),
            title: format!("{source}, {column}: {count} samples at {rate} Hz"),
            about: String::new(),
            scene_text: String::new(),
            command: String::new(),
            sample_rate: rate,
            duration: samples.len() as f64 / rate,
            endless: false,
            controls: Vec::new(),
            analysis,
            rest_speed: 0.0,
            subject: Subject::Signal(info),
            computed: None,
        };
        Self {
            header,
            samples,
            next: 0,
        }
    }
}

impl Source for SignalSource<'_> {
    fn header(&self, command: &str) -> Header {
        Header {
            command: command.to_owned(),
            ..self.header.clone()
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
        let first = self.next;
        let end = self.samples.len().min(first + FRAME_SAMPLES);
        if first == end {
            return Ok(None);
        }
        let piece = self.samples[first..end].to_vec();
        let frame = Frame {
            index: (first / FRAME_SAMPLES) as u64,
            t0: self.header.start() + first as f64 / self.header.sample_rate,
            dt: 1.0 / self.header.sample_rate,
            velocity: piece.clone(),
            displacement: piece,
            ..Frame::default()
        };
        self.next = end;
        Ok(Some(frame))
    }

    fn is_finished(&self) -> bool {
        self.next == self.samples.len()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;
    use std::sync::{Arc, Mutex};

    use super::*;
    use crate::analysis::levels::LevelReference;
    use crate::pipeline::message::Record;
    use crate::pipeline::stages::synthetic_tests::{Motion, RATE, all_analyses};
    use crate::pipeline::{Monitor, drive};
    use crate::scene::{SectionSurface, StateCoordinate};

    const START: f64 = -1.5;

    fn playback(samples: &[f64]) -> SignalSource<'_> {
        let info = SignalInfo {
            source: "squeak.wav".into(),
            column: "left".into(),
            unit: "FS".into(),
            start: START,
            span: [-1.0, 1.0],
            highest_frequency: 10e3,
            events: Vec::new(),
            level_reference: LevelReference::FullScale,
        };
        SignalSource::new(info, samples, RATE, all_analyses())
    }

    fn tone(seconds: f64) -> Vec<f64> {
        Motion::tones(seconds, &[(4003.0, 0.3, 0.2)]).velocity
    }

    #[test]
    fn frames_contain_every_sample_once_and_in_order() {
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
            assert!(source.is_finished());
            assert!(source.next_frame().unwrap().is_none());
        }
    }

    #[test]
    fn a_signal_passes_through_the_whole_pipeline() {
        let samples = tone(0.03);
        // The last window of 20 ms.
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
        assert!((summary.simulated_s - 0.03).abs() < 1e-12);
        assert_eq!(
            (summary.real_time_factor, summary.energy_residual),
            (0.0, None)
        );
        assert_eq!(summary.peak_velocity_m_per_s, largest);
        assert!((summary.lines[0].frequency - 4003.0).abs() < 1.0);
        assert!(!summary.interrupted);
        let times = progress.into_inner().unwrap();
        assert!((times.last().unwrap() - (START + 0.03)).abs() < 1e-12);

        let Record::Header(header) = &records[0] else {
            panic!("the first record must be the header");
        };
        assert_eq!(header.start(), START);
        assert!((header.duration - 0.03).abs() < 1e-12);
        for record in &records {
            match record {
                Record::Health(health) => {
                    assert_eq!((health.real_time_factor, health.audit), (0.0, None));
                    assert_eq!((health.steps_per_ms, health.rhs_evals_per_ms), (0.0, 0.0));
                }
                Record::Narration { observation, .. } => {
                    panic!("only joints are described: {observation:?}")
                }
                _ => {}
            }
        }
        let delays = records.iter().filter(|r| matches!(r, Record::Delay { .. }));
        assert_eq!(delays.count(), 6);
    }

    #[test]
    fn a_section_of_the_modal_state_has_no_results() {
        let mut analysis = all_analyses();
        let section = analysis.section.as_mut().unwrap();
        section.surface = SectionSurface::State {
            normal_q: vec![1.0],
            normal_qdot: Vec::new(),
            offset: 0.0,
            shown: [StateCoordinate::Q(0); 2],
        };
        let samples = tone(0.01);
        let mut source = playback(&samples);
        source.header.analysis = analysis;
        let mut records: Vec<Record> = Vec::new();
        drive(source, "", &mut records, Monitor::default()).unwrap();
        let mut sections = records
            .iter()
            .filter(|r| matches!(r, Record::Section { .. }));
        assert!(sections.next().is_none());
    }

    #[test]
    fn a_signal_without_samples_ends_immediately() {
        let mut records: Vec<Record> = Vec::new();
        let summary = drive(playback(&[]), "", &mut records, Monitor::default()).unwrap();
        assert_eq!((summary.simulated_s, summary.interrupted), (0.0, false));
        assert_eq!(records.len(), 2, "header and summary");
    }
}
