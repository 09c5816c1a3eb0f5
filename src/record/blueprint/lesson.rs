//! The layout of a scene with a mechanism: its lesson, and the plots that show the mechanism.

use rerun::external::re_sdk_types::blueprint::components::Corner2D;

use super::{ContainerLike, Layout, Parts, tab};
use crate::{
    pipeline::message::{AnalysisKind, Header, MechanismPrediction, Subject},
    plot::prediction_panel,
    record::{lesson, paths, portrait::Portrait, section::Section, small, style::Quantity},
    scene::{Mechanism, RecordSpec},
};

/// Time window of the series of a joint, s.
const SERIES: f64 = 5e-3;
/// Natural periods in the time window of a small system.
const PERIODS: f64 = 12.0;
/// Fraction of the width used by the text.
const WORDS: f32 = 0.34;

impl Layout {
    /// The lesson next to the plots that show the mechanism.
    pub fn lesson_tab(&mut self, header: &Header, spec: RecordSpec) -> Option<ContainerLike> {
        let computed = header.computed.as_deref()?;
        let words = self.text("Lesson", paths::LESSON);
        let proof = match computed.mechanism {
            Mechanism::NegativeSlope
            | Mechanism::ModeCoupling
            | Mechanism::ExchangedFriction
            | Mechanism::Bristles
            | Mechanism::ContactAge
            | Mechanism::MeasuredFriction => self.growth_views(header, computed),
            Mechanism::Articulation => self.turning_views(header, computed),
            Mechanism::StickSlip | Mechanism::LiftOff => self.contact_views(header, spec),
            Mechanism::WhichModeWins | Mechanism::Prediction => self.modes_views(header, spec),
            Mechanism::Hysteresis => self.loop_views(header),
            Mechanism::Torus => self.torus_views(header),
            Mechanism::TorusBirth => self.birth_views(header, computed),
            Mechanism::Chaos => self.divergence_views(header),
        };
        let screen = Parts::new().add(WORDS, words).add(1.0 - WORDS, proof);
        tab("Lesson", screen.row())
    }

    /// Velocity level compared with the computed growth, and the computed curves.
    fn growth_views(
        &mut self,
        header: &Header,
        computed: &MechanismPrediction,
    ) -> Option<ContainerLike> {
        let level = self.level_series();
        let picture = self.computed_picture(computed);
        let portrait = self.portrait();
        let top = Parts::new().add(1.0, picture).add(0.8, portrait).row();
        let below = match &header.subject {
            Subject::Small(_) => {
                let velocity = self.velocity(header);
                Parts::new().add(0.55, level).add(0.45, velocity).column()
            }
            Subject::Joint(_) | Subject::Signal(_) => {
                let spectrum = self.spectrum(header);
                Parts::new().add(1.0, level).add(1.0, spectrum).row()
            }
        };
        Parts::new().add(1.0, top).add(1.0, below).column()
    }

    /// The contact patch next to the phase portrait; for a small system its time series.
    fn contact_views(&mut self, header: &Header, spec: RecordSpec) -> Option<ContainerLike> {
        let portrait = self.portrait();
        let velocity = self.velocity(header);
        let Subject::Joint(joint) = &header.subject else {
            let spectrum = self.spectrum(header);
            let top = Parts::new().add(1.0, portrait).add(1.0, spectrum).row();
            return Parts::new().add(1.0, top).add(0.5, velocity).column();
        };
        let patch = self.patch(joint);
        let top = Parts::new().add(1.0, patch).add(1.0, portrait).row();
        let below = (spec.patch_rate > 0.0).then(|| {
            let [counts, force] = self.contact_series(joint, spec);
            Parts::new().add(1.0, counts).add(1.0, force).row()
        });
        Parts::new()
            .add(1.0, top)
            .add(0.4, below.flatten())
            .add(0.4, velocity)
            .column()
    }

    /// Computed frequencies, measured spectrum and modal energies.
    fn modes_views(&mut self, header: &Header, spec: RecordSpec) -> Option<ContainerLike> {
        let spectrum = self.spectrum(header);
        let portrait = self.portrait();
        let spectrogram = self.spectrogram(header);
        let energy = (spec.energy_rate > 0.0).then(|| {
            let name = "Energy of each mode, µJ (whole run); colours: tab “Modes”";
            self.series(name, paths::MODES_ENERGY, None)
        });
        let top = Parts::new().add(1.5, spectrum).add(1.0, portrait).row();
        Parts::new()
            .add(1.0, top)
            .add(0.6, energy)
            .add(0.7, spectrogram)
            .column()
    }

    /// The hysteresis loop of the strongest line over the tilt.
    fn loop_views(&mut self, header: &Header) -> Option<ContainerLike> {
        let hysteresis = self.line_over_tilt(header);
        let portrait = self.portrait();
        let spectrogram = self.spectrogram(header);
        let tilt = self.tilt();
        let top = Parts::new().add(1.4, hysteresis).add(1.0, portrait).row();
        Parts::new()
            .add(1.0, top)
            .add(0.6, spectrogram)
            .add(0.35, tilt)
            .column()
    }

    /// The strongest line over the tilt, and the computed growth rate over the tilt, both ways.
    fn turning_views(
        &mut self,
        header: &Header,
        computed: &MechanismPrediction,
    ) -> Option<ContainerLike> {
        let tones = self.line_over_tilt(header);
        let growth = self.computed_picture(computed);
        let spectrogram = self.spectrogram(header);
        let level = self.level_series();
        let tilt = self.tilt();
        let top = Parts::new().add(1.0, growth).add(1.0, tones).row();
        Parts::new()
            .add(1.0, top)
            .add(0.6, spectrogram)
            .add(0.4, level)
            .add(0.35, tilt)
            .column()
    }

    /// The strongest line over the tilt, if the tilt turns.
    fn line_over_tilt(&mut self, header: &Header) -> Option<ContainerLike> {
        let name = "Strongest line over tilt: increasing (blue), decreasing (orange)";
        let bounds = lesson::loop_bounds(header)?;
        Some(self.picture(name, paths::HYSTERESIS, bounds))
    }

    /// Velocity level and its computed growth.
    fn level_series(&mut self) -> ContainerLike {
        self.many_series(
            "Velocity level: log₁₀ of mm/s (blue); computed growth (orange)",
            &[paths::LESSON_VELOCITY_LEVEL, paths::LESSON_PREDICTED],
            Corner2D::RightBottom,
        )
    }

    /// The computed curves, if there are any.
    fn computed_picture(&mut self, computed: &MechanismPrediction) -> Option<ContainerLike> {
        let picture = computed.picture.as_ref()?;
        let bounds = lesson::picture_bounds(picture);
        let title = prediction_panel(picture).title;
        Some(self.picture(&title, paths::LESSON_COMPUTED, bounds))
    }

    /// Spectrum, phase portrait, delay embedding and Poincaré section of a torus.
    fn torus_views(&mut self, header: &Header) -> Option<ContainerLike> {
        let spectrum = self.spectrum(header);
        let portrait = self.portrait();
        let embedding = self.embedding(header, 3.6);
        let section = self.section(header);
        let top = Parts::new().add(1.5, spectrum).add(1.0, portrait).row();
        let below = Parts::new().add(1.0, embedding).add(1.0, section).row();
        Parts::new().add(1.0, top).add(1.0, below).column()
    }

    /// The computed growth of the second tone, the spectrum with its side lines, and the Poincaré section that opens.
    fn birth_views(
        &mut self,
        header: &Header,
        computed: &MechanismPrediction,
    ) -> Option<ContainerLike> {
        let growth = self.computed_picture(computed);
        let spectrum = self.spectrum(header);
        let section = self.section(header);
        let tilt = self.tilt();
        let top = Parts::new().add(1.0, growth).add(1.0, section).row();
        Parts::new()
            .add(1.0, top)
            .add(0.8, spectrum)
            .add(0.35, tilt)
            .column()
    }

    /// Both trajectories and their distance.
    fn divergence_views(&mut self, header: &Header) -> Option<ContainerLike> {
        let [traces, distance, portraits] = self.both_trajectories(header);
        let left = Parts::new().add(1.0, distance).add(0.7, traces).column();
        Parts::new().add(1.2, left).add(1.0, portraits).row()
    }

    /// The Poincaré section, if it is computed.
    pub fn section(&mut self, header: &Header) -> Option<ContainerLike> {
        header
            .has(AnalysisKind::Section)
            .then(|| self.picture("Poincaré section", paths::SECTION, Section::bounds()))
    }

    pub fn portrait(&mut self) -> ContainerLike {
        self.picture("Phase portrait", paths::PORTRAIT, Portrait::bounds())
    }

    fn velocity(&mut self, header: &Header) -> ContainerLike {
        let (window, key) = match &header.subject {
            Subject::Small(small) => (
                (PERIODS / small.frequency_hz).min(header.duration),
                format!(": {}", small::key(small)),
            ),
            Subject::Joint(_) | Subject::Signal(_) => (SERIES, String::new()),
        };
        let last = Quantity::Time.format(window);
        let name = format!("Velocity, mm/s (last {last}){key}");
        self.series(&name, paths::VELOCITY, Some(window))
    }
}
