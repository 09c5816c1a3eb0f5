//! Encoding of records as rows of entities.

use std::sync::Arc;

use super::body::Body;
use super::lesson::Lesson;
use super::panel_view::PanelViews;
use super::patch::Patch;
use super::paths::{self, Root};
use super::perturbed::PerturbedTrajectory;
use super::portrait::{Embedding, Portrait, TRAIL};
use super::samples::Samples;
use super::sdk::TextLogLevel;
use super::small::{self, SmallFrames};
use super::spectrogram::Spectrogram;
use super::stream::RecordingStream;
use super::{controls, exponents, health, quantification, regime, style, text};
use crate::analysis::regime::Verdict;
use crate::pipeline::message::{Frame, Header, Record, Subject};
use crate::plot::{Color, RunPanels};
use crate::scene::RecordSpec;

/// Encodes the records after a header.
#[derive(Debug)]
pub struct Encoder {
    /// The header.
    pub header: Arc<Header>,
    /// What is drawn from the frames of a joint, of a small system, and of both.
    joint: Option<(Samples, Patch, Body)>,
    small: Option<SmallFrames>,
    portrait: Option<Portrait>,
    /// The pictures that are panels, and where they are drawn.
    panels: RunPanels,
    views: PanelViews,
    spectrogram: Spectrogram,
    embedding: Embedding,
    perturbed: Option<PerturbedTrajectory>,
    lesson: Option<Lesson>,
}

impl Encoder {
    /// Creates the encoders, and logs the static entities and the description.
    pub fn new(rec: &RecordingStream, header: Arc<Header>, spec: RecordSpec) -> Self {
        let origin = [&*header.scene, &header.scene_text, &header.command];
        text::send_properties(rec, &header.scene, origin);
        text::log_about(rec, &header);
        regime::name_regimes(rec);
        rec.name(paths::ZERO_ONE, [("K", Color::Compared)]);
        let panels = RunPanels::new(Arc::clone(&header));
        let views = PanelViews::new(Root::of_run());
        let lesson = header.computed.as_ref();
        let lesson = lesson.map(|computed| Lesson::new(rec, &header, computed));
        let (mut joint_frames, mut small_frames, mut portrait) = (None, None, None);
        match &header.subject {
            Subject::Joint(joint) => {
                let samples = Samples::new(rec, joint);
                let body = Body::new(rec, joint, spec);
                joint_frames = Some((samples, Patch::new(rec, joint), body));
                portrait = Some(Portrait::new(rec, TRAIL, vec![Color::Run]));
            }
            Subject::Small(small) => {
                small_frames = Some(SmallFrames::new(rec, small));
                portrait = Some(small::portrait(rec, small));
            }
            Subject::Signal(signal) => {
                let name = style::signal_title(signal);
                rec.name(paths::WAVEFORM, [(name, Color::Run)]);
            }
        }
        let has_perturbed = header.analysis.perturbed_trajectory.is_some();
        Self {
            joint: joint_frames,
            small: small_frames,
            portrait,
            lesson,
            panels,
            views,
            spectrogram: Spectrogram::new(rec, &header),
            embedding: Embedding::new(&header.subject),
            perturbed: has_perturbed.then(|| PerturbedTrajectory::new(rec)),
            header,
        }
    }

    /// Logs a record.
    pub fn accept(&mut self, rec: &RecordingStream, record: &Record) {
        self.panels.accept(record, &mut |time, name, panel| {
            self.views.of(name).draw(rec, time.into(), &panel);
        });
        let header = &self.header;
        match record {
            // This encoder was created from the header; another header would be the same. The other records have panels
            // only.
            Record::Header(_)
            | Record::Spectrum { .. }
            | Record::Recurrence { .. }
            | Record::Delay { .. }
            | Record::Section { .. } => {}
            Record::Samples(frame) => self.push(rec, frame),
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
                quantification::draw(rec, (*time, *dt), found);
            }
            Record::Chaos { time, zero_one, .. } => rec.row(paths::ZERO_ONE, *time, [zero_one.k]),
            Record::Regime {
                time,
                window,
                verdict,
            } => self.draw_regime(rec, *time, *window, verdict),
            Record::Exponents(exponents) => exponents::draw(rec, header, exponents),
            Record::TrajectoryDivergence(separation) => {
                if let Some(perturbed) = &mut self.perturbed {
                    perturbed.push_distance(rec, header, separation);
                }
            }
            Record::Health(health) => {
                // The playback of a file has no solver whose state could be shown.
                if self.portrait.is_some() {
                    health::log(rec, health);
                }
            }
            Record::Narration { time, observation } => {
                let narration = crate::text::narration(observation);
                text::narrate(rec, header, *time, &narration);
            }
            Record::Event { time, text } => text::note(rec, *time, text, TextLogLevel::INFO),
            Record::Lesson(now) => {
                if let Some(lesson) = &mut self.lesson {
                    lesson.write(rec, now);
                }
            }
            Record::LevelSample(sample) => {
                if let Some(lesson) = &mut self.lesson {
                    lesson.push(rec, header, sample);
                }
            }
            Record::Warning { time, text } => text::note(rec, *time, text, TextLogLevel::WARN),
            Record::Summary(summary) => text::summarise(rec, header, summary),
        }
    }

    /// Adds a frame.
    fn push(&mut self, rec: &RecordingStream, frame: &Frame) {
        if let Some((samples, patch, body)) = &mut self.joint {
            samples.push(rec, frame);
            patch.push(rec, frame);
            body.push(rec, frame);
        }
        if let Some(small) = &mut self.small {
            small.push(rec, frame);
        }
        match &mut self.portrait {
            Some(portrait) => portrait.push(rec, frame),
            None => {
                let samples = frame.displacement.iter().enumerate();
                let samples = samples.map(|(k, &value)| (frame.time(k), [value]));
                rec.rows(paths::WAVEFORM, samples);
            }
        }
        controls::push(rec, &self.header, frame);
        if let Some(perturbed) = &mut self.perturbed {
            perturbed.push(rec, frame);
        }
    }

    /// Draws the classification; for subjects without narration it is also the text of the overview.
    fn draw_regime(&mut self, rec: &RecordingStream, time: f64, window: f64, verdict: &Verdict) {
        let header = &self.header;
        regime::draw_verdict(rec, header, (time, window), verdict);
        if self.joint.is_none() {
            let status = self.small.as_mut().map(SmallFrames::status_summary);
            let status = status.map_or_else(String::new, |status| format!("\n{status}"));
            let text = format!("{}{status}", regime::markdown(verdict));
            text::narrate(rec, header, time, &text);
        }
    }

    /// Sends the pending frames.
    pub fn send_pending(&mut self, rec: &RecordingStream) {
        if let Some((_, patch, body)) = &mut self.joint {
            patch.send(rec);
            body.send(rec);
        }
    }

    /// Sends everything that is pending at the end.
    pub fn finish(&mut self, rec: &RecordingStream) {
        if let Some(perturbed) = &self.perturbed {
            perturbed.finish(rec);
        }
        if let Some(portrait) = &self.portrait {
            portrait.finish(rec);
        }
        self.send_pending(rec);
        self.spectrogram.finish(rec);
    }
}
