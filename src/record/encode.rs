//! Encoding of records as rows of entities.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::record::sdk::Scalars;

use super::{
    body::Body,
    controls::Controls,
    error::RecordError,
    exponents::RunningExponents,
    health,
    lesson::Lesson,
    panel_view::PanelView,
    patch::Patch,
    paths::{self, Root},
    perturbed::PerturbedTrajectory,
    portrait::{self, Embedding, Portrait},
    quantification::Quantification,
    regime,
    samples::{Samples, Waveform, name_series},
    small::SmallFrames,
    spectrogram::Spectrogram,
    stream::{self, Moment, RecordingStream},
    style, text,
};
use crate::{
    analysis::Verdict,
    pipeline::message::{AnalysisKind, Frame, Header, Record, Subject},
    plot::RunPanels,
    scene::RecordSpec,
};

/// Encodes the records after a header.
#[derive(Debug)]
pub struct Encoder {
    header: Arc<Header>,
    frames: Frames,
    /// The pictures that are panels, and where they are drawn.
    panels: RunPanels,
    views: BTreeMap<&'static str, PanelView>,
    spectrogram: Spectrogram,
    embedding: Embedding,
    quantification: Quantification,
    exponents: RunningExponents,
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
        name_series(rec, paths::ZERO_ONE, ["K".to_owned()], [style::ACCENT])?;
        let panels = RunPanels::new(Arc::clone(&header));
        let mut spectrum = PanelView::of("spectrum", &Root::of_run());
        spectrum.draw_axes(rec, None, &panels.empty_spectrum())?;
        let lesson = header.computed.as_ref();
        let lesson = lesson.map(|computed| Lesson::new(rec, &header, computed));
        Ok(Self {
            lesson: lesson.transpose()?,
            controls: Controls::new(rec, &header)?,
            frames: Frames::new(rec, &header, spec)?,
            panels,
            views: BTreeMap::from([("spectrum", spectrum)]),
            spectrogram: Spectrogram::new(rec, &header)?,
            embedding: Embedding::new(&header.subject),
            quantification: Quantification::default(),
            exponents: RunningExponents::default(),
            perturbed: if header.has(AnalysisKind::PerturbedTrajectory) {
                Some(PerturbedTrajectory::new(rec)?)
            } else {
                None
            },
            header,
        })
    }

    /// Logs a record.
    pub fn accept(&mut self, rec: &RecordingStream, record: &Record) -> Result<(), RecordError> {
        for (name, time, panel) in self.panels.accept(record) {
            let view = self.views.entry(name);
            let view = view.or_insert_with(|| PanelView::of(name, &Root::of_run()));
            view.draw(rec, Some(Moment::from(time)), &panel)?;
        }
        match record {
            // This encoder was created from the header; another header would be the same. The other records have panels
            // only.
            Record::Header(_)
            | Record::Spectrum { .. }
            | Record::Recurrence { .. }
            | Record::Delay { .. }
            | Record::Section { .. } => Ok(()),
            Record::Samples(frame) => {
                self.frames.push(rec, frame)?;
                self.controls.push(rec, frame)?;
                match &mut self.perturbed {
                    Some(perturbed) => perturbed.push(rec, frame),
                    None => Ok(()),
                }
            }
            Record::SpectrogramColumn {
                time,
                bin,
                level_db,
            } => self.spectrogram.push(rec, *time, *bin, level_db),
            Record::Embedding { time, points } => self.embedding.draw(rec, *time, points),
            Record::Quantification {
                time,
                dt,
                measures,
                periods,
                ..
            } => self.quantification.draw(rec, *time, *dt, measures, periods),
            Record::Chaos { time, zero_one, .. } => {
                stream::log_at(rec, paths::ZERO_ONE, *time, &Scalars::single(zero_one.k))
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
                Some(lesson) => lesson.push(rec, &self.header, course),
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
