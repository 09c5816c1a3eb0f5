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
/// signal's unit is meant; a section of the modal state is not computed.
#[derive(Clone, Debug)]
pub struct Playback {
    title: String,
    info: SignalInfo,
    samples: Vec<f64>,
    rate: f64,
    analysis: AnalysisSpec,
    frames: u64,
}

impl Playback {
    /// Plays finite `samples` at `rate` (Hz, above 0), the first one at the time that `info` says.
    /// `title` is one line that says what they are.
    pub fn new(
        title: impl Into<String>,
        info: SignalInfo,
        samples: Vec<f64>,
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

impl Source for Playback {
    fn header(&self, command: &str) -> Header {
        Header {
            scene: self.info.source.clone(),
            title: self.title.clone(),
            about: String::new(),
            scene_text: String::new(),
            command: command.to_owned(),
            sample_rate: self.rate,
            duration: self.samples.len() as f64 / self.rate,
            analyses: kinds(&self.analysis),
            section: section_coordinates(&self.analysis),
            subject: Subject::Signal(self.info.clone()),
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
