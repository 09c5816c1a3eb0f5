//! What is made of the samples.

use super::exponents;
use crate::analysis::{DivergenceMethod, Threshold};
use crate::scene::error::SceneError;
use crate::scene::file::Document;
use crate::scene::keys::{self, Divergence, Key, NearnessKeys};
use crate::scene::kind::{AutoOr, Count, Number};
use crate::scene::spec::{
    AnalysisSpec, ChaosSpec, DelaySpec, EmbeddingSpec, NearnessSpec, QuantificationSpec,
    RecurrenceSpec, RegimeSpec, SectionSpec, SectionSurface, Setting, SlidingSpec, SpectrogramSpec,
    StateCoordinate,
};

/// The analyses of samples at `rate` (Hz) of a joint with so many modes.
pub(super) fn analysis(
    document: &Document<'_>,
    rate: f64,
    modes: usize,
) -> Result<AnalysisSpec, SceneError> {
    let tables = Tables { document, rate };
    let delay = tables.delay()?;
    Ok(AnalysisSpec {
        spectrum: tables.spectrum()?,
        spectrogram: tables.spectrogram()?,
        delay,
        recurrence: tables.recurrence(delay.as_ref())?,
        quantification: tables.quantification(delay.as_ref())?,
        section: tables.section(modes)?,
        chaos: tables.chaos(delay.as_ref())?,
        regime: tables.regime()?,
        exponents: exponents::exponents(document, 2 * modes)?,
        butterfly: exponents::butterfly(document)?,
    })
}

/// The tables of a document, and the rate (Hz) of the samples that they are about.
struct Tables<'d> {
    document: &'d Document<'d>,
    rate: f64,
}

impl Tables<'_> {
    fn spectrum(&self) -> Result<Option<SlidingSpec>, SceneError> {
        if !self.document.has("analysis.spectrum") {
            return Ok(None);
        }
        self.sliding(&keys::SPECTRUM_WINDOW, &keys::SPECTRUM_EVERY)
            .map(Some)
    }

    fn spectrogram(&self) -> Result<Option<SpectrogramSpec>, SceneError> {
        let document = self.document;
        if !document.has("analysis.spectrogram") {
            return Ok(None);
        }
        let spec = SpectrogramSpec {
            sliding: self.sliding(&keys::SPECTROGRAM_WINDOW, &keys::SPECTROGRAM_EVERY)?,
            max_frequency: document.get(&keys::MAX_FREQUENCY)?,
        };
        if spec.max_frequency > self.rate / 2.0 {
            return Err(document.inconsistent(
                keys::MAX_FREQUENCY.path,
                &[keys::SAMPLE_RATE.path],
                format!(
                    "{} kHz is above half the sample rate ({} kHz), beyond which samples say nothing",
                    spec.max_frequency / 1e3,
                    self.rate / 2e3
                ),
                "lower it, or raise time.sample_rate_khz",
            ));
        }
        Ok(Some(spec))
    }

    fn delay(&self) -> Result<Option<DelaySpec>, SceneError> {
        let document = self.document;
        if !document.has("analysis.delay") {
            return Ok(None);
        }
        let spec = DelaySpec {
            sliding: self.sliding(&keys::DELAY_WINDOW, &keys::DELAY_EVERY)?,
            largest_lag: document.get(&keys::LARGEST_LAG)?,
            largest_dimension: document.get(&keys::LARGEST_DIMENSION)?,
            bins: document.get(&keys::BINS)?,
            false_share: document.get(&keys::FALSE_SHARE)?,
        };
        self.at_least_a_sample(keys::LARGEST_LAG.path, spec.largest_lag)?;
        // The last dimension is judged by the one after it.
        let reach = spec.largest_dimension as f64 * spec.largest_lag;
        let reaching = [keys::LARGEST_LAG.path, keys::LARGEST_DIMENSION.path];
        self.room(keys::DELAY_WINDOW.path, spec.sliding, reach, &reaching)?;
        Ok(Some(spec))
    }

    fn recurrence(&self, delay: Option<&DelaySpec>) -> Result<Option<RecurrenceSpec>, SceneError> {
        let document = self.document;
        if !document.has("analysis.recurrence") {
            return Ok(None);
        }
        let size = document.get(&keys::RECURRENCE_SIZE)?;
        let spec = RecurrenceSpec {
            nearness: self.nearness(&keys::RECURRENCE_NEARNESS, size)?,
            sliding: self.sliding(&keys::RECURRENCE_WINDOW, &keys::RECURRENCE_EVERY)?,
            size,
            embedding: self.embedding(
                &keys::RECURRENCE_LAG,
                &keys::RECURRENCE_DIMENSION,
                delay.is_some(),
            )?,
        };
        if size as f64 > (spec.sliding.window * self.rate).round() {
            return Err(document.inconsistent(
                keys::RECURRENCE_SIZE.path,
                &[keys::RECURRENCE_WINDOW.path],
                format!(
                    "{size} points from a window of {:.0} samples",
                    spec.sliding.window * self.rate
                ),
                "take fewer points or a longer window",
            ));
        }
        Ok(Some(spec))
    }

    fn quantification(
        &self,
        delay: Option<&DelaySpec>,
    ) -> Result<Option<QuantificationSpec>, SceneError> {
        /// Fewer states have no lines to speak of; more take longer than the run.
        const STATES: std::ops::RangeInclusive<f64> = 16.0..=20_000.0;

        let document = self.document;
        if !document.has("analysis.quantification") {
            return Ok(None);
        }
        let sliding = self.sliding(&keys::QUANTIFICATION_WINDOW, &keys::QUANTIFICATION_EVERY)?;
        let step = document.get(&keys::STEP)?.max(1.0 / self.rate);
        let states = (sliding.window / step).round();
        if !STATES.contains(&states) {
            return Err(document.inconsistent(
                keys::STEP.path,
                &[keys::QUANTIFICATION_WINDOW.path],
                format!("{states} states in a window"),
                format!("take {} to {} of them", STATES.start(), STATES.end()),
            ));
        }
        let theiler = document.get(&keys::QUANTIFICATION_THEILER)?;
        let theiler_path = keys::QUANTIFICATION_THEILER.path;
        self.room(
            keys::QUANTIFICATION_WINDOW.path,
            sliding,
            theiler,
            &[theiler_path],
        )?;
        let compared = states - 2.0 * (theiler / step).round();
        Ok(Some(QuantificationSpec {
            sliding,
            step,
            embedding: self.embedding(
                &keys::QUANTIFICATION_LAG,
                &keys::QUANTIFICATION_DIMENSION,
                delay.is_some(),
            )?,
            nearness: self.nearness(&keys::QUANTIFICATION_NEARNESS, compared.max(0.0) as usize)?,
            theiler,
            least_diagonal: document.get(&keys::LEAST_DIAGONAL)?,
            least_vertical: document.get(&keys::LEAST_VERTICAL)?,
        }))
    }

    fn section(&self, modes: usize) -> Result<Option<SectionSpec>, SceneError> {
        let document = self.document;
        if !document.has("analysis.section") {
            return Ok(None);
        }
        let normals = [
            document.find(&keys::PLANE_Q)?,
            document.find(&keys::PLANE_QDOT)?,
        ];
        let surface = if normals.iter().any(Option::is_some) {
            self.state_surface(normals.map(Option::unwrap_or_default), modes)?
        } else {
            self.delay_surface()?
        };
        Ok(Some(SectionSpec {
            every: document.get(&keys::SECTION_EVERY)?,
            surface,
            direction: document.get(&keys::DIRECTION)?,
        }))
    }

    fn delay_surface(&self) -> Result<SectionSurface, SceneError> {
        for key in [keys::OFFSET.path, keys::SHOWN.path] {
            self.refuse(
                key,
                "it belongs to a plane of the modal state, and none is given",
                "add plane_q or plane_qdot_ms, or leave it out",
            )?;
        }
        Ok(SectionSurface::Delay {
            lag: self.lag(&keys::SECTION_LAG, self.document.has("analysis.delay"))?,
            level: self.document.get(&keys::LEVEL)?,
        })
    }

    fn state_surface(
        &self,
        [normal_q, normal_qdot]: [Vec<f64>; 2],
        modes: usize,
    ) -> Result<SectionSurface, SceneError> {
        let document = self.document;
        for key in [keys::SECTION_LAG.path, keys::LEVEL.path] {
            self.refuse(
                key,
                "the section is given twice, in delay coordinates and as a plane of the modal state",
                "keep one of them",
            )?;
        }
        let planes = [keys::PLANE_Q.path, keys::PLANE_QDOT.path];
        if normal_q.len().max(normal_qdot.len()) > modes {
            let longer = planes[usize::from(normal_qdot.len() > modes)];
            return Err(document.inconsistent(
                longer,
                &[],
                format!("more numbers than modes, of which there are {modes}"),
                "give at most one for each",
            ));
        }
        if normal_q.iter().chain(&normal_qdot).all(|&n| n == 0.0) {
            return Err(document.inconsistent(
                planes[usize::from(!document.has(planes[0]))],
                &planes,
                "a plane needs a normal, and this one is zero",
                "let one number differ from zero",
            ));
        }
        let Some(shown) = document.find(&keys::SHOWN)? else {
            return Err(document.missing(&keys::SHOWN));
        };
        let mode = |coordinate| match coordinate {
            StateCoordinate::Q(mode) | StateCoordinate::Qdot(mode) => mode,
        };
        if shown
            .into_iter()
            .any(|coordinate| mode(coordinate) >= modes)
        {
            return Err(document.inconsistent(
                keys::SHOWN.path,
                &[],
                format!("a mode that is not there; there are {modes}"),
                "modes are counted from 1, by frequency",
            ));
        }
        Ok(SectionSurface::State {
            normal_q,
            normal_qdot,
            offset: document.find(&keys::OFFSET)?.unwrap_or(0.0),
            shown,
        })
    }

    fn chaos(&self, delay: Option<&DelaySpec>) -> Result<Option<ChaosSpec>, SceneError> {
        let document = self.document;
        if !document.has("analysis.chaos") {
            return Ok(None);
        }
        let method = match document.get(&keys::DIVERGENCE)? {
            Divergence::Rosenstein => {
                self.refuse(
                    keys::RADIUS.path,
                    "nearest neighbours have no radius",
                    "leave it out, or take method = \"kantz\"",
                )?;
                DivergenceMethod::Rosenstein
            }
            Divergence::Kantz => match document.find(&keys::RADIUS)? {
                Some(radius) => DivergenceMethod::Kantz { radius },
                None => return Err(document.missing(&keys::RADIUS)),
            },
        };
        let spec = ChaosSpec {
            sliding: self.sliding(&keys::CHAOS_WINDOW, &keys::CHAOS_EVERY)?,
            embedding: self.embedding(&keys::CHAOS_LAG, &keys::CHAOS_DIMENSION, delay.is_some())?,
            theiler: document.get(&keys::CHAOS_THEILER)?,
            horizon: document.get(&keys::HORIZON)?,
            method,
        };
        let [lag, dimension] = match delay {
            Some(delay) => [delay.largest_lag, delay.largest_dimension as f64],
            None => [0.0, 1.0],
        };
        let lag = spec.embedding.lag.or(lag);
        let dimension = spec.embedding.dimension.map(|m| m as f64).or(dimension);
        let reach = (dimension - 1.0) * lag + spec.theiler + spec.horizon;
        let reaching = [
            keys::CHAOS_LAG.path,
            keys::CHAOS_DIMENSION.path,
            keys::CHAOS_THEILER.path,
            keys::HORIZON.path,
        ];
        self.room(keys::CHAOS_WINDOW.path, spec.sliding, reach, &reaching)?;
        Ok(Some(spec))
    }

    fn regime(&self) -> Result<Option<RegimeSpec>, SceneError> {
        if !self.document.has("analysis.regime") {
            return Ok(None);
        }
        Ok(Some(RegimeSpec {
            sliding: self.sliding(&keys::REGIME_WINDOW, &keys::REGIME_EVERY)?,
            silence: self.document.get(&keys::SILENCE)?,
        }))
    }

    /// A window that holds enough samples to be analysed.
    fn sliding(
        &self,
        window: &Key<Number>,
        every: &Key<Number>,
    ) -> Result<SlidingSpec, SceneError> {
        const FEWEST_SAMPLES: f64 = 16.0;
        let spec = SlidingSpec {
            window: self.document.get(window)?,
            every: self.document.get(every)?,
        };
        if (spec.window * self.rate).round() >= FEWEST_SAMPLES {
            return Ok(spec);
        }
        Err(self.document.inconsistent(
            window.path,
            &[keys::SAMPLE_RATE.path],
            format!("the window holds fewer than {FEWEST_SAMPLES} samples"),
            format!("make it at least {} ms", FEWEST_SAMPLES / self.rate * 1e3),
        ))
    }

    /// Delay vectors; `chooser` says whether there is someone to choose what is automatic.
    fn embedding(
        &self,
        lag: &Key<AutoOr<Number>>,
        dimension: &Key<AutoOr<Count>>,
        chooser: bool,
    ) -> Result<EmbeddingSpec, SceneError> {
        let lag = self.lag(lag, chooser)?;
        let setting = self.document.get(dimension)?;
        self.chosen(dimension.path, setting, chooser)?;
        Ok(EmbeddingSpec {
            lag,
            dimension: setting,
        })
    }

    fn lag(&self, key: &Key<AutoOr<Number>>, chooser: bool) -> Result<Setting<f64>, SceneError> {
        let setting = self.document.get(key)?;
        self.chosen(key.path, setting, chooser)?;
        if let Setting::Given(lag) = setting {
            self.at_least_a_sample(key.path, lag)?;
        }
        Ok(setting)
    }

    fn chosen<T>(
        &self,
        key: &'static str,
        setting: Setting<T>,
        chooser: bool,
    ) -> Result<(), SceneError> {
        if chooser || matches!(setting, Setting::Given(_)) {
            return Ok(());
        }
        Err(self.document.inconsistent(
            key,
            &[],
            "\"auto\" takes what [analysis.delay] chooses, and that table is absent",
            "add it, or give a number",
        ))
    }

    fn at_least_a_sample(&self, key: &'static str, delay: f64) -> Result<(), SceneError> {
        if delay * self.rate >= 0.999 {
            return Ok(());
        }
        Err(self.document.inconsistent(
            key,
            &[keys::SAMPLE_RATE.path],
            format!(
                "the delay is shorter than one sample ({} us)",
                1e6 / self.rate
            ),
            "make it at least that long",
        ))
    }

    /// What reaches over a stretch of the window must leave half of it to be compared.
    fn room(
        &self,
        window: &'static str,
        sliding: SlidingSpec,
        reach: f64,
        reaching: &[&str],
    ) -> Result<(), SceneError> {
        // A hair above, for numbers that are equal but for rounding.
        if reach <= sliding.window / 2.0 * (1.0 + 1e-9) {
            return Ok(());
        }
        let names: Vec<&str> = reaching.iter().map(|path| keys::split(path).1).collect();
        Err(self.document.inconsistent(
            window,
            reaching,
            format!(
                "{} reach over {} ms, more than half of the window",
                names.join(", "),
                reach * 1e3
            ),
            format!("make it at least {} ms, or them shorter", 2e3 * reach),
        ))
    }

    /// A norm and exactly one threshold, for states of which each is compared with `others`.
    fn nearness(&self, keys: &NearnessKeys, others: usize) -> Result<NearnessSpec, SceneError> {
        let document = self.document;
        let given = [
            document.find(keys.rate)?.map(Threshold::Rate),
            document.find(keys.distance)?.map(Threshold::Distance),
            document.find(keys.spread)?.map(Threshold::Spread),
            document.find(keys.neighbours)?.map(Threshold::Neighbours),
        ];
        let paths = [
            keys.rate.path,
            keys.distance.path,
            keys.spread.path,
            keys.neighbours.path,
        ];
        let mut thresholds = given
            .into_iter()
            .zip(paths)
            .filter(|(one, _)| one.is_some());
        let threshold = match (thresholds.next(), thresholds.next()) {
            (Some((Some(threshold), _)), None) => threshold,
            (Some((_, first)), Some((_, second))) => {
                let last = thresholds.next().map_or(second, |(_, third)| third);
                return Err(document.inconsistent(
                    last,
                    &[first, second],
                    "the threshold is given more than once",
                    "keep one of threshold_rate, threshold_um, threshold_spread and neighbours",
                ));
            }
            _ => return Err(document.missing(keys.rate)),
        };
        if let Threshold::Neighbours(count) = threshold
            && count >= others
        {
            return Err(document.inconsistent(
                keys.neighbours.path,
                &[],
                format!("{count} neighbours among {others} states"),
                "ask for fewer, or take more states",
            ));
        }
        Ok(NearnessSpec {
            norm: document.get(keys.norm)?,
            threshold,
        })
    }

    /// Refuses a key that does not belong to what else is given.
    fn refuse(
        &self,
        key: &'static str,
        problem: &'static str,
        remedy: &'static str,
    ) -> Result<(), SceneError> {
        if self.document.has(key) {
            return Err(self.document.inconsistent(key, &[], problem, remedy));
        }
        Ok(())
    }
}
