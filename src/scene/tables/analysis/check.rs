//! Whether the analyses fit together, and with the samples and the modes.

use super::{
    AnalysisSpec, ChaosSpec, DelaySpec, EmbeddingSpec, ExponentsSpec, NearnessSpec,
    QuantificationSpec, RecurrenceSpec, SlidingSpec,
};
use crate::analysis::Threshold;
use crate::scene::document::{Document, FromTable, Table};
use crate::scene::error::{SceneError, ensure};
use crate::scene::setting::{SectionSurface, Setting, StateCoordinate};

/// The analyses of samples at `rate` (Hz) of a system with so many modes.
pub fn read(document: &Document<'_>, rate: f64, modes: usize) -> Result<AnalysisSpec, SceneError> {
    let mut analysis = AnalysisSpec::read(document.table("analysis"))?;
    let delay = analysis.delay;
    let of = |path| Checks {
        table: document.table(path),
        rate,
        delay: delay.as_ref(),
    };
    if let Some(spec) = &analysis.spectrum {
        of("analysis.spectrum").window(spec.sliding)?;
    }
    if let Some(spec) = &analysis.spectrogram {
        of("analysis.spectrogram").window(spec.sliding)?;
        of("analysis.spectrogram").spectrogram(spec.max_frequency)?;
    }
    if let Some(spec) = &analysis.delay {
        of("analysis.delay").delay(spec)?;
    }
    if let Some(spec) = &analysis.recurrence {
        of("analysis.recurrence").recurrence(spec)?;
    }
    if let Some(spec) = &mut analysis.quantification {
        of("analysis.quantification").quantification(spec)?;
    }
    if let Some(spec) = &analysis.section {
        of("analysis.section").surface(&spec.surface, modes)?;
    }
    if let Some(spec) = &analysis.chaos {
        of("analysis.chaos").chaos(spec)?;
    }
    if let Some(spec) = &analysis.regime {
        of("analysis.regime").window(spec.sliding)?;
    }
    if let Some(spec) = &mut analysis.exponents {
        of("analysis.exponents").exponents(spec, 2 * modes)?;
    }
    Ok(analysis)
}

/// The table of an analysis, and what it depends on.
#[derive(Clone, Copy)]
struct Checks<'d> {
    table: Table<'d>,
    /// Samples a second, Hz.
    rate: f64,
    /// What chooses the delays and dimensions that are automatic.
    delay: Option<&'d DelaySpec>,
}

impl Checks<'_> {
    fn spectrogram(&self, max_frequency: f64) -> Result<(), SceneError> {
        let (highest, half) = (max_frequency / 1e3, self.rate / 2e3);
        ensure!(self.table,
            max_frequency <= self.rate / 2.0 => "max_frequency_khz", &["time.sample_rate_khz"];
            "{highest} kHz is above half the sample rate ({half} kHz), beyond which samples say nothing";
            "lower it, or raise time.sample_rate_khz");
        Ok(())
    }

    fn delay(&self, spec: &DelaySpec) -> Result<(), SceneError> {
        self.window(spec.sliding)?;
        self.at_least_a_sample("largest_lag_us", spec.largest_lag)?;
        // The last dimension is judged by the one after it.
        let reach = spec.largest_dimension as f64 * spec.largest_lag;
        self.room(
            spec.sliding,
            reach,
            &["largest_lag_us", "largest_dimension"],
        )
    }

    fn recurrence(&self, spec: &RecurrenceSpec) -> Result<(), SceneError> {
        self.window(spec.sliding)?;
        self.nearness(&spec.nearness, spec.size)?;
        self.embedding(&spec.embedding)?;
        let samples = spec.sliding.window * self.rate;
        ensure!(self.table, spec.size as f64 <= samples.round() => "size", &["window_ms"];
            "{} points from a window of {samples:.0} samples", spec.size;
            "take fewer points or a longer window");
        Ok(())
    }

    /// Steps are at least as long as a sample.
    fn quantification(&self, spec: &mut QuantificationSpec) -> Result<(), SceneError> {
        /// Fewer states have no lines to speak of; more take longer than the run.
        const STATES: std::ops::RangeInclusive<f64> = 16.0..=20_000.0;

        self.window(spec.sliding)?;
        spec.step = spec.step.max(1.0 / self.rate);
        let states = (spec.sliding.window / spec.step).round();
        ensure!(self.table, STATES.contains(&states) => "step_us", &["window_ms"];
            "{states} states in a window";
            "take {} to {} of them", STATES.start(), STATES.end());
        self.room(spec.sliding, spec.theiler, &["theiler_us"])?;
        self.embedding(&spec.embedding)?;
        let compared = states - 2.0 * (spec.theiler / spec.step).round();
        self.nearness(&spec.nearness, compared.max(0.0) as usize)
    }

    fn surface(&self, surface: &SectionSurface, modes: usize) -> Result<(), SceneError> {
        let (normal_q, normal_qdot, shown) = match surface {
            SectionSurface::Delay { lag, .. } => return self.lag("lag_us", *lag),
            SectionSurface::State {
                normal_q,
                normal_qdot,
                shown,
                ..
            } => (normal_q, normal_qdot, shown),
        };
        const PLANES: [&str; 2] = ["plane_q", "plane_qdot_ms"];
        for (name, normal) in PLANES.into_iter().zip([normal_q, normal_qdot]) {
            ensure!(self.table, normal.len() <= modes => name, &[];
                "more numbers than modes, of which there are {modes}";
                "give at most one for each");
        }
        ensure!(self.table,
            normal_q.iter().chain(normal_qdot).any(|&n| n != 0.0) => PLANES[usize::from(normal_q.is_empty())], &PLANES;
            "a plane needs a normal, and this one is zero";
            "let one number differ from zero");
        let is_there = |coordinate: &StateCoordinate| match coordinate {
            StateCoordinate::Q(mode) | StateCoordinate::Qdot(mode) => *mode < modes,
        };
        ensure!(self.table, shown.iter().all(is_there) => "shown", &[];
            "a mode that is not there; there are {modes}";
            "modes are counted from 1, by frequency");
        Ok(())
    }

    fn chaos(&self, spec: &ChaosSpec) -> Result<(), SceneError> {
        self.window(spec.sliding)?;
        self.embedding(&spec.embedding)?;
        let [lag, dimension] = match self.delay {
            Some(delay) => [delay.largest_lag, delay.largest_dimension as f64],
            None => [0.0, 1.0],
        };
        let lag = spec.embedding.lag.or(lag);
        let dimension = spec.embedding.dimension.map(|m| m as f64).or(dimension);
        let reach = (dimension - 1.0) * lag + spec.theiler + spec.horizon;
        let reaching = ["lag_us", "dimension", "theiler_us", "horizon_ms"];
        self.room(spec.sliding, reach, &reaching)
    }

    /// All of them are as many as the motion has dimensions.
    fn exponents(&self, spec: &mut ExponentsSpec, dimension: usize) -> Result<(), SceneError> {
        let count = spec.count;
        // The default is for joints of many modes.
        let is_asked_for = self.table.has("count") && count < usize::MAX;
        ensure!(self.table,
            count <= dimension || !is_asked_for => "count", &["body.bending_pairs", "body.torsion", "body.axial"];
            "{count} exponents of a motion that has {dimension}";
            "ask for fewer, or for \"all\"");
        spec.count = count.min(dimension);
        Ok(())
    }

    /// A window must hold enough samples to be analysed.
    fn window(&self, sliding: SlidingSpec) -> Result<(), SceneError> {
        const FEWEST_SAMPLES: f64 = 16.0;
        ensure!(self.table,
            (sliding.window * self.rate).round() >= FEWEST_SAMPLES => "window_ms", &["time.sample_rate_khz"];
            "the window holds fewer than {FEWEST_SAMPLES} samples";
            "make it at least {} ms", FEWEST_SAMPLES / self.rate * 1e3);
        Ok(())
    }

    fn embedding(&self, spec: &EmbeddingSpec) -> Result<(), SceneError> {
        self.lag("lag_us", spec.lag)?;
        self.chosen("dimension", spec.dimension)
    }

    fn lag(&self, name: &str, lag: Setting<f64>) -> Result<(), SceneError> {
        self.chosen(name, lag)?;
        match lag {
            Setting::Given(lag) => self.at_least_a_sample(name, lag),
            Setting::Auto => Ok(()),
        }
    }

    /// There must be something to choose what is automatic.
    fn chosen<T>(&self, name: &str, setting: Setting<T>) -> Result<(), SceneError> {
        ensure!(self.table, self.delay.is_some() || matches!(setting, Setting::Given(_)) => name, &[];
            "\"auto\" takes what [analysis.delay] chooses, and that table is absent";
            "add it, or give a number");
        Ok(())
    }

    fn at_least_a_sample(&self, name: &str, delay: f64) -> Result<(), SceneError> {
        ensure!(self.table,
            delay * self.rate >= 0.999 => name, &["time.sample_rate_khz"];
            "the delay is shorter than one sample ({} us)", 1e6 / self.rate;
            "make it at least that long");
        Ok(())
    }

    /// What reaches over a stretch of the window must leave half of it to be compared.
    fn room(&self, sliding: SlidingSpec, reach: f64, names: &[&str]) -> Result<(), SceneError> {
        // A hair above, for numbers that are equal but for rounding.
        ensure!(self.table, reach <= sliding.window / 2.0 * (1.0 + 1e-9) => "window_ms", names;
            "{} reach over {} ms, more than half of the window", names.join(", "), reach * 1e3;
            "make it at least {} ms, or them shorter", 2e3 * reach);
        Ok(())
    }

    /// Each state must have enough `others` with which it is compared.
    fn nearness(&self, spec: &NearnessSpec, others: usize) -> Result<(), SceneError> {
        if let Threshold::Neighbours(count) = spec.threshold {
            ensure!(self.table, count < others => "neighbours", &[];
                "{count} neighbours among {others} states";
                "ask for fewer, or take more states");
        }
        Ok(())
    }
}
