//! Consistency checks of the analyses with each other, the samples and the modes.

use super::{
    AnalysisSpec, ChaosSpec, DelaySpec, EmbeddingSpec, QuantificationSpec, RecurrenceSpec,
    SectionSurface, StateCoordinate, ThresholdSpec,
};
use crate::analysis::recurrence::Threshold;
use crate::scene::document::{Document, FromTable, Table};
use crate::scene::error::{SceneError, ensure};

/// Reads the analyses for samples at `rate` (Hz) of a system with the given number of modes.
pub fn read(document: &Document<'_>, rate: f64, modes: usize) -> Result<AnalysisSpec, SceneError> {
    let mut analysis = AnalysisSpec::read(document.table("analysis"))?;
    let delay = analysis.delay;
    let of = |path| Checks {
        table: document.table(path),
        rate,
        delay: delay.as_ref(),
    };
    if let Some(spec) = &analysis.spectrum {
        of("analysis.spectrum").window(spec.window)?;
    }
    if let Some(spec) = &analysis.spectrogram {
        let checks = of("analysis.spectrogram");
        checks.window(spec.window)?;
        let (highest, half) = (spec.max_frequency / 1e3, rate / 2e3);
        ensure!(checks.table,
            spec.max_frequency <= rate / 2.0 => "max_frequency_khz", &["time.sample_rate_khz"];
            "{highest} kHz exceeds the Nyquist frequency of {half} kHz";
            "reduce it, or increase time.sample_rate_khz");
    }
    if let Some(spec) = &analysis.delay {
        let checks = of("analysis.delay");
        checks.window(spec.window)?;
        checks.at_least_a_sample("max_lag_us", spec.largest_lag)?;
        // The criterion for the last dimension uses one more delay.
        let reach = spec.largest_dimension as f64 * spec.largest_lag;
        checks.leaves_half_of_window(spec.window, reach, &["max_lag_us", "max_dimension"])?;
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
        of("analysis.regime").window(spec.window)?;
    }
    if let Some(spec) = &mut analysis.exponents {
        let table = document.table("analysis.lyapunov");
        let (count, dimension) = (spec.count, 2 * modes);
        // The default count is for joints with many modes.
        let is_explicit = table.has("count") && count < usize::MAX;
        ensure!(table,
            count <= dimension || !is_explicit => "count", &["body.bending_pairs", "body.torsion_modes", "body.axial_modes"];
            "{count} exponents exceed the dimension {dimension} of the phase space";
            "reduce count, or set it to \"all\"");
        spec.count = count.min(dimension);
    }
    Ok(analysis)
}

/// The table of an analysis with the quantities it depends on.
#[derive(Clone, Copy)]
struct Checks<'d> {
    table: Table<'d>,
    /// Sampling rate, Hz.
    rate: f64,
    /// The analysis that determines automatic delays and dimensions.
    delay: Option<&'d DelaySpec>,
}

impl Checks<'_> {
    fn recurrence(&self, spec: &RecurrenceSpec) -> Result<(), SceneError> {
        self.window(spec.window)?;
        self.recurrence_criterion(&spec.criterion, spec.size)?;
        self.embedding(&spec.embedding)?;
        let samples = spec.window * self.rate;
        ensure!(self.table, spec.size as f64 <= samples.round() => "size", &["window_ms"];
            "{} points exceed the {samples:.0} samples of the window", spec.size;
            "reduce the number of points, or increase window_ms");
        Ok(())
    }

    /// Rounds the spacing of the states up to one sample and checks the number of states.
    fn quantification(&self, spec: &mut QuantificationSpec) -> Result<(), SceneError> {
        /// Fewer states contain no lines; more take longer than the run.
        const STATES: std::ops::RangeInclusive<f64> = 16.0..=20_000.0;

        self.window(spec.window)?;
        spec.step = spec.step.max(1.0 / self.rate);
        let states = (spec.window / spec.step).round();
        ensure!(self.table, STATES.contains(&states) => "step_us", &["window_ms"];
            "the window contains {states} states";
            "choose step_us and window_ms for {} to {} states", STATES.start(), STATES.end());
        self.leaves_half_of_window(spec.window, spec.theiler, &["theiler_us"])?;
        self.embedding(&spec.embedding)?;
        let compared = states - 2.0 * (spec.theiler / spec.step).round();
        self.recurrence_criterion(&spec.criterion, compared.max(0.0) as usize)
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
                "the normal has more components than the system has modes ({modes})";
                "give at most one component for each mode");
        }
        ensure!(self.table,
            normal_q.iter().chain(normal_qdot).any(|&n| n != 0.0) => PLANES[usize::from(normal_q.is_empty())], &PLANES;
            "the normal of the plane is zero";
            "set at least one component to a value other than zero");
        let is_known = |coordinate: &StateCoordinate| match coordinate {
            StateCoordinate::Q(mode) | StateCoordinate::Qdot(mode) => *mode < modes,
        };
        ensure!(self.table, shown.iter().all(is_known) => "coordinates", &[];
            "the system has {modes} modes only";
            "use modes from 1 to {modes}, in order of frequency");
        Ok(())
    }

    fn chaos(&self, spec: &ChaosSpec) -> Result<(), SceneError> {
        self.window(spec.window)?;
        self.embedding(&spec.embedding)?;
        let (lag, dimension) = match self.delay {
            Some(delay) => (delay.largest_lag, delay.largest_dimension),
            None => (0.0, 1),
        };
        let lag = spec.embedding.lag.unwrap_or(lag);
        let dimension = spec.embedding.dimension.unwrap_or(dimension);
        let reach = (dimension as f64 - 1.0) * lag + spec.theiler + spec.horizon;
        let reaching = ["lag_us", "dimension", "theiler_us", "horizon_ms"];
        self.leaves_half_of_window(spec.window, reach, &reaching)
    }

    /// A window must contain enough samples.
    fn window(&self, window: f64) -> Result<(), SceneError> {
        const MIN_SAMPLES: f64 = 16.0;
        ensure!(self.table,
            (window * self.rate).round() >= MIN_SAMPLES => "window_ms", &["time.sample_rate_khz"];
            "the window contains fewer than {MIN_SAMPLES} samples";
            "increase it to at least {} ms", MIN_SAMPLES / self.rate * 1e3);
        Ok(())
    }

    fn embedding(&self, spec: &EmbeddingSpec) -> Result<(), SceneError> {
        self.lag("lag_us", spec.lag)?;
        self.chosen("dimension", spec.dimension)
    }

    fn lag(&self, name: &str, lag: Option<f64>) -> Result<(), SceneError> {
        self.chosen(name, lag)?;
        lag.map_or(Ok(()), |lag| self.at_least_a_sample(name, lag))
    }

    /// An automatic value requires `[analysis.delay]`.
    fn chosen<T>(&self, name: &str, setting: Option<T>) -> Result<(), SceneError> {
        ensure!(self.table, self.delay.is_some() || setting.is_some() => name, &[];
            "\"auto\" requires [analysis.delay], which the scene does not contain";
            "add that table, or give a number");
        Ok(())
    }

    fn at_least_a_sample(&self, name: &str, delay: f64) -> Result<(), SceneError> {
        ensure!(self.table,
            delay * self.rate >= 0.999 => name, &["time.sample_rate_khz"];
            "the delay is shorter than one sample ({} µs)", 1e6 / self.rate;
            "increase it to at least one sample");
        Ok(())
    }

    /// A reach within the window must leave at least half of it for comparison.
    fn leaves_half_of_window(
        &self,
        window: f64,
        reach: f64,
        names: &[&str],
    ) -> Result<(), SceneError> {
        // The tolerance accepts numbers that are equal within rounding.
        ensure!(self.table, reach <= window / 2.0 * (1.0 + 1e-9) => "window_ms", names;
            "{} together span {} ms, which exceeds half of the window", names.join(", "), reach * 1e3;
            "increase it to at least {} ms, or reduce the other values", 2e3 * reach);
        Ok(())
    }

    /// Each state must have enough `others` to compare with.
    fn recurrence_criterion(&self, spec: &ThresholdSpec, others: usize) -> Result<(), SceneError> {
        if let Threshold::Neighbours(count) = spec.threshold {
            ensure!(self.table, count < others => "neighbours", &[];
                "{count} neighbours require more than {others} states";
                "reduce the number of neighbours, or increase the number of states");
        }
        Ok(())
    }
}
