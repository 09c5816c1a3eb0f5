//! Encoding of records as rows of entities.

use std::sync::Arc;

use super::{
    body::Body,
    controls,
    error::RecordError,
    exponents::RunningExponents,
    health,
    lesson::Lesson,
    panel_view::PanelViews,
    patch::Patch,
    paths::{self, Root},
    perturbed::PerturbedTrajectory,
    portrait::{self, Embedding, Portrait},
    quantification::Quantification,
    regime,
    samples::{Rows, Samples},
    small::SmallFrames,
    spectrogram::Spectrogram,
    stream::{Moment, RecordingStream},
    style, text,
};
use crate::{
    analysis::regime::Verdict,
    pipeline::message::{AnalysisKind, Frame, Header, Record, Subject},
    plot::RunPanels,
    scene::RecordSpec,
};

/// Encodes the records after a header.
#[derive(Debug)]
pub struct Encoder {
    header: Arc<Header>,
    rows: Rows,
    frames: Frames,
    /// The pictures that are panels, and where they are drawn.
    panels: RunPanels,
    views: PanelViews,
    spectrogram: Spectrogram,
    embedding: Embedding,
    quantification: Quantification,
    exponents: RunningExponents,
    perturbed: Option<PerturbedTrajectory>,
    lesson: Option<Lesson>,
}

/// Encoders of frames, by the subject of the run.
#[derive(Debug)]
enum Frames {
    /// Frames of a joint.
    Joint(Box<JointFrames>),
    /// Frames of a small system.
    Small(Box<SmallFrames>),
    /// Frames of a signal from a file.
    Signal,
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
    fn new(
        rec: &RecordingStream,
        rows: &mut Rows,
        header: &Header,
        spec: RecordSpec,
    ) -> Result<Self, RecordError> {
        if let Subject::Signal(signal) = &header.subject {
            let name = style::signal_title(signal);
            rows.name(rec, paths::WAVEFORM, [(name, style::SIGNAL)])?;
            return Ok(Self::Signal);
        }
        health::name(rec, rows)?;
        portrait::style_point(rec)?;
        Ok(match &header.subject {
            Subject::Joint(joint) => Self::Joint(Box::new(JointFrames {
                samples: Samples::new(rec, rows, joint)?,
                patch: Patch::new(rec, rows, joint)?,
                body: Body::new(rec, joint, spec.body_rate, spec.deformation_scale)?,
                portrait: Portrait::new(portrait::TRAIL, vec![style::SIGNAL]),
            })),
            Subject::Small(small) => Self::Small(Box::new(SmallFrames::new(rec, rows, small)?)),
            Subject::Signal(_) => Self::Signal,
        })
    }

    fn push(
        &mut self,
        rec: &RecordingStream,
        rows: &mut Rows,
        frame: &Frame,
    ) -> Result<(), RecordError> {
        match self {
            Self::Joint(joint) => {
                joint.samples.push(rows, frame);
                joint.patch.push(rec, rows, frame)?;
                joint.body.push(rec, frame)?;
                joint.portrait.push(rec, frame)
            }
            Self::Small(small) => small.push(rec, rows, frame),
            Self::Signal => {
                let samples = frame.displacement.iter().enumerate();
                let samples = samples.map(|(k, &value)| (frame.time(k), [value]));
                rows.extend(paths::WAVEFORM, samples);
                Ok(())
            }
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
        let mut rows = Rows::default();
        regime::name_regimes(rec, &mut rows)?;
        rows.name(rec, paths::ZERO_ONE, [("K", style::ACCENT)])?;
        controls::name(rec, &mut rows, &header)?;
        let panels = RunPanels::new(Arc::clone(&header));
        let mut views = PanelViews::new(Root::of_run());
        let spectrum = views.of("spectrum");
        spectrum.draw_axes(rec, None, &panels.empty_spectrum())?;
        let lesson = header.computed.as_ref();
        let lesson = lesson.map(|computed| Lesson::new(rec, &mut rows, &header, computed));
        Ok(Self {
            lesson: lesson.transpose()?,
            frames: Frames::new(rec, &mut rows, &header, spec)?,
            panels,
            views,
            spectrogram: Spectrogram::new(rec, &header)?,
            embedding: Embedding::new(&header.subject),
            quantification: Quantification::default(),
            exponents: RunningExponents::default(),
            perturbed: if header.has(AnalysisKind::PerturbedTrajectory) {
                Some(PerturbedTrajectory::new(rec, &mut rows)?)
            } else {
                None
            },
            rows,
            header,
        })
    }

    /// Logs a record.
    pub fn accept(&mut self, rec: &RecordingStream, record: &Record) -> Result<(), RecordError> {
        let (time, pictures) = self.panels.accept(record);
        for (name, panel) in pictures {
            let view = self.views.of(name);
            view.draw(rec, Some(Moment::from(time)), &panel)?;
        }
        let (header, rows) = (&self.header, &mut self.rows);
        match record {
            // This encoder was created from the header; another header would be the same. The other records have panels
            // only.
            Record::Header(_)
            | Record::Spectrum { .. }
            | Record::Recurrence { .. }
            | Record::Delay { .. }
            | Record::Section { .. } => Ok(()),
            Record::Samples(frame) => {
                self.frames.push(rec, rows, frame)?;
                controls::push(rows, header, frame);
                if let Some(perturbed) = &mut self.perturbed {
                    perturbed.push(rec, rows, frame)?;
                }
                rows.send_full(rec)
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
            } => {
                let found = (measures, periods);
                self.quantification.draw(rec, rows, (*time, *dt), found)
            }
            Record::Chaos { time, zero_one, .. } => {
                rows.push(paths::ZERO_ONE, *time, [zero_one.k]);
                Ok(())
            }
            Record::Regime {
                time,
                window,
                verdict,
            } => self.draw_regime(rec, *time, *window, verdict),
            Record::Exponents(exponents) => self.exponents.draw(rec, header, exponents),
            Record::TrajectoryDivergence(separation) => match &mut self.perturbed {
                Some(perturbed) => perturbed.push_distance(rec, rows, header, separation),
                None => Ok(()),
            },
            // The playback of a file has no solver whose state could be shown.
            Record::Health(health) => match self.frames {
                Frames::Joint(_) | Frames::Small(_) => health::log(rec, rows, health),
                Frames::Signal => Ok(()),
            },
            Record::Narration { time, observation } => {
                let words = crate::text::narration(observation);
                text::narrate(rec, header, *time, &words)
            }
            Record::Event { time, text } => text::note(rec, *time, text),
            Record::Lesson(now) => match &mut self.lesson {
                Some(lesson) => lesson.write(rec, now),
                None => Ok(()),
            },
            Record::LevelSample(sample) => match &mut self.lesson {
                Some(lesson) => lesson.push(rec, rows, header, sample),
                None => Ok(()),
            },
            Record::Warning { time, text } => text::warn(rec, *time, text),
            Record::Summary(summary) => text::summarise(rec, header, summary),
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
        regime::draw_verdict(rec, &mut self.rows, header, (time, window), verdict)?;
        let words = regime::words(verdict);
        match &mut self.frames {
            Frames::Joint(_) => Ok(()),
            Frames::Small(small) => {
                let words = format!("{words}\n{}", small.status_summary());
                text::narrate(rec, header, time, &words)
            }
            Frames::Signal => text::narrate(rec, header, time, &words),
        }
    }

    /// Sends the pending rows and frames.
    pub fn send_pending(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        if let Frames::Joint(joint) = &mut self.frames {
            joint.patch.send(rec)?;
            joint.body.send(rec)?;
        }
        self.rows.send(rec)
    }

    /// Sends everything that is pending at the end.
    pub fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        if let Some(perturbed) = &self.perturbed {
            perturbed.finish(rec, &mut self.rows)?;
        }
        self.send_pending(rec)?;
        self.spectrogram.finish(rec)
    }
}
