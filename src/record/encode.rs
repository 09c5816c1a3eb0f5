//! Encoding of records as rows of entities.

use std::sync::Arc;

use super::{
    body::Body,
    chaos::Chaos,
    controls::Controls,
    delay::Delay,
    error::RecordError,
    exponents::ExponentsPlot,
    health,
    lesson::Lesson,
    patch::Patch,
    paths,
    perturbed::PerturbedTrajectory,
    portrait::{self, Embedding, Portrait},
    quantification::Quantification,
    recurrence::Recurrence,
    regime,
    samples::{Samples, Waveform},
    section::Section,
    small::SmallFrames,
    spectrum::{Spectrogram, SpectrumPlot},
    stream::RecordingStream,
    style::{self, Quantity},
    text,
};
use crate::{
    analysis::Verdict,
    pipeline::message::{AnalysisKind, Frame, Header, Record, Subject},
    scene::RecordSpec,
};

/// Encodes the records after a header.
#[derive(Debug)]
pub struct Encoder {
    header: Arc<Header>,
    frames: Frames,
    spectrum: SpectrumPlot,
    spectrogram: Spectrogram,
    recurrence: Recurrence,
    embedding: Embedding,
    delay: Delay,
    quantification: Quantification,
    section: Section,
    chaos: Chaos,
    exponents: ExponentsPlot,
    perturbed: Option<PerturbedTrajectory>,
    lesson: Option<Lesson>,
    controls: Controls,
}

/// Encoders of frames, by the subject of the run.
#[derive(Debug)]
enum Frames {
    /// Frames of a joint.
    Joint(Box<JointFrames>),
    /// Frames of a small system.
    Small(Box<SmallFrames>),
    /// Frames of a signal from a file.
    Signal(Waveform),
}

/// Encoders of the frames of a joint.
#[derive(Debug)]
struct JointFrames {
    samples: Samples,
    patch: Patch,
    body: Body,
    portrait: Portrait,
}

impl Frames {
    fn new(rec: &RecordingStream, header: &Header, spec: RecordSpec) -> Result<Self, RecordError> {
        let joint = match &header.subject {
            Subject::Joint(joint) => joint,
            Subject::Small(small) => {
                health::name(rec)?;
                portrait::style_point(rec)?;
                return Ok(Self::Small(Box::new(SmallFrames::new(rec, small)?)));
            }
            Subject::Signal(signal) => return Ok(Self::Signal(Waveform::new(rec, signal)?)),
        };
        health::name(rec)?;
        portrait::style_point(rec)?;
        Ok(Self::Joint(Box::new(JointFrames {
            samples: Samples::new(rec, joint)?,
            patch: Patch::new(rec, joint)?,
            body: Body::new(rec, joint, spec.body_rate, spec.deformation_scale)?,
            portrait: Portrait::new(portrait::TRAIL, vec![style::SIGNAL]),
        })))
    }

    fn push(&mut self, rec: &RecordingStream, frame: &Frame) -> Result<(), RecordError> {
        match self {
            Self::Joint(joint) => {
                joint.samples.push(rec, frame)?;
                joint.patch.push(rec, frame)?;
                joint.body.push(rec, frame)?;
                joint.portrait.push(rec, frame)
            }
            Self::Small(small) => small.push(rec, frame),
            Self::Signal(waveform) => waveform.push(rec, frame),
        }
    }

    fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        match self {
            Self::Joint(joint) => {
                joint.samples.finish(rec)?;
                joint.patch.finish(rec)?;
                joint.body.finish(rec)
            }
            Self::Small(small) => small.finish(rec),
            Self::Signal(waveform) => waveform.finish(rec),
        }
    }
}

impl Encoder {
    /// Creates the encoders, and logs the static entities and the description.
    pub fn new(
        rec: &RecordingStream,
        header: Arc<Header>,
        spec: RecordSpec,
    ) -> Result<Self, RecordError> {
        text::send_properties(rec, header.as_ref().into())?;
        text::log_about(rec, &header)?;
        regime::name_regimes(rec)?;
        let spectrum = SpectrumPlot::new(&header);
        spectrum.plot().draw(rec, paths::SPECTRUM, None)?;
        let subject = &header.subject;
        let lesson = header.computed.as_ref();
        let lesson = lesson.map(|computed| Lesson::new(rec, &header, computed, &spectrum));
        Ok(Self {
            lesson: lesson.transpose()?,
            controls: Controls::new(rec, &header)?,
            frames: Frames::new(rec, &header, spec)?,
            spectrum,
            spectrogram: Spectrogram::new(rec, &header)?,
            recurrence: Recurrence::new(Quantity::displacement(subject)),
            embedding: Embedding::new(subject),
            delay: Delay::default(),
            quantification: Quantification::default(),
            section: Section::new(rec, &header)?,
            chaos: Chaos::new(rec, &header)?,
            exponents: ExponentsPlot::new(),
            perturbed: match header.has(AnalysisKind::PerturbedTrajectory) {
                true => Some(PerturbedTrajectory::new(rec)?),
                false => None,
            },
            header,
        })
    }

    /// Logs a record.
    pub fn accept(&mut self, rec: &RecordingStream, record: &Record) -> Result<(), RecordError> {
        match record {
            // This encoder was created from the header; another header would be the same.
            Record::Header(_) => Ok(()),
            Record::Samples(frame) => {
                self.section.redraw.set_rate(frame);
                self.frames.push(rec, frame)?;
                self.controls.push(rec, frame)?;
                match &mut self.perturbed {
                    Some(perturbed) => perturbed.push(rec, frame),
                    None => Ok(()),
                }
            }
            Record::Spectrum {
                time,
                bin,
                amplitude,
                peaks,
            } => self.spectrum.draw(rec, *time, *bin, amplitude, peaks),
            Record::SpectrogramColumn {
                time,
                bin,
                level_db,
            } => self.spectrogram.push(rec, *time, *bin, level_db),
            Record::Recurrence { time, image } => self.recurrence.draw(rec, *time, image),
            Record::Embedding { time, points } => self.embedding.draw(rec, *time, points),
            Record::Delay {
                time, dt, choice, ..
            } => self.delay.draw(rec, *time, *dt, choice),
            Record::Quantification {
                time,
                dt,
                measures,
                periods,
                ..
            } => self.quantification.draw(rec, *time, *dt, measures, periods),
            Record::Section { time, points } => self.section.push(rec, *time, points),
            Record::Chaos {
                time,
                window,
                dt,
                divergence,
                zero_one,
            } => {
                let times = [*time, *window, *dt];
                self.chaos.draw(rec, times, divergence, zero_one)
            }
            Record::Regime {
                time,
                window,
                verdict,
            } => self.draw_regime(rec, *time, *window, verdict),
            Record::Exponents(exponents) => self.exponents.draw(rec, &self.header, exponents),
            Record::TrajectoryDivergence(separation) => match &mut self.perturbed {
                Some(perturbed) => perturbed.push_distance(rec, &self.header, separation),
                None => Ok(()),
            },
            // The playback of a file has no solver whose state could be shown.
            Record::Health(health) => match self.frames {
                Frames::Joint(_) | Frames::Small(_) => health::log(rec, health),
                Frames::Signal(_) => Ok(()),
            },
            Record::Narration { time, observation } => {
                let words = crate::text::narration(observation);
                text::narrate(rec, &self.header, *time, &words)
            }
            Record::Event { time, text } => text::note(rec, *time, text),
            Record::Lesson(now) => match &mut self.lesson {
                Some(lesson) => lesson.write(rec, now),
                None => Ok(()),
            },
            Record::LevelSample(course) => match &mut self.lesson {
                Some(lesson) => lesson.push(rec, course),
                None => Ok(()),
            },
            Record::Warning { time, text } => text::warn(rec, *time, text),
            Record::Summary(summary) => text::summarise(rec, &self.header, summary),
        }
    }

    /// Draws the classification; for subjects without narration it is also the text of the overview.
    fn draw_regime(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        window: f64,
        verdict: &Verdict,
    ) -> Result<(), RecordError> {
        let header = &self.header;
        regime::draw_verdict(rec, header, time, window, verdict)?;
        let words = regime::words(verdict);
        match &mut self.frames {
            Frames::Joint(_) => Ok(()),
            Frames::Small(small) => {
                let words = format!("{words}\n{}", small.status_summary());
                text::narrate(rec, header, time, &words)
            }
            Frames::Signal(_) => text::narrate(rec, header, time, &words),
        }
    }

    /// Sends the pending rows of frames and of the lesson.
    pub fn send_pending(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        if let Some(lesson) = &mut self.lesson {
            lesson.finish(rec)?;
        }
        self.controls.finish(rec)?;
        self.frames.finish(rec)
    }

    /// Sends all pending rows.
    pub fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        self.send_pending(rec)?;
        if let Some(perturbed) = &mut self.perturbed {
            perturbed.finish(rec)?;
        }
        self.spectrogram.finish(rec)
    }
}
